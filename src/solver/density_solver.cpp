#include "solver/density_solver.hpp"

#include <algorithm>
#include <limits>

#include "base/threads.hpp"
#include "solver/anderson.hpp"
#include "solver/free_momentum.hpp"

namespace trevi {

namespace {

// Limits each shift by a limit on the multipliers, such that no pair is pushed apart by more than max_shift even where
// the kernel gradient is largest. If the shift of a single particle were shortened instead, the opposite shifts of its
// neighbours would stay as they are, and momentum would be lost wherever water meets at speed.
Real largest_multiplier(const DensitySettings& settings, const DensityModel& model) {
  if (settings.max_shift == 0) return std::numeric_limits<Real>::infinity();
  return settings.max_shift * model.h /
         (2 * model.mass / model.rest_density * model.kernels.gradient.steepest(model.h));
}

template <class T>
class Jacobi : public DensitySolver<T> {
 public:
  Jacobi(const DensitySettings& settings, const DensityModel& model)
      : settings_(settings), relaxation_(settings.relaxation), largest_(largest_multiplier(settings, model)) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    for (int k = 0; k < settings_.iterations; ++k) {
      problem.with_halo(Phase::lambda, [&](Range part) {  // lines 9 to 11
        problem.compute_lambda(
            part, [least = static_cast<T>(-largest_ / relaxation_)](T lambda, T) { return std::max(lambda, least); });
      });
      if (within_tolerance(settings_, problem)) return {k, true};
      problem.compute_delta();                          // lines 12 to 14
      problem.with_halo(Phase::move, [&](Range part) {  // lines 14 to 18
        problem.collide_and_move(part, relaxation_);
      });
    }
    return {settings_.iterations, ends_within_tolerance(settings_, problem)};
  }

 private:
  DensitySettings settings_;
  Real relaxation_, largest_;
};

// Chebyshev semi-iteration. Wang (2015) combines positions; here the multipliers are combined,
//   step_{k+1} = w_{k+1} relaxation lambda_k + (w_{k+1} − 1) step_k,
// so that each shift is still a sum over pairs of equal and opposite parts, and momentum is kept. The safeguard is a
// restart for each particle on its own (O'Donoghue & Candès 2015): where the new multiplier has the opposite sign of
// the last step, or is zero, the last step is dropped. This needs no reduction, and deep water is unstable without it.
template <class T>
class Chebyshev : public DensitySolver<T> {
 public:
  Chebyshev(const DensitySettings& settings, const DensityModel& model)
      : settings_(settings), relaxation_(settings.relaxation), largest_(largest_multiplier(settings, model)) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    Real weight = 1;
    for (int k = 0; k < settings_.iterations; ++k) {
      weight = next_weight(k, weight);
      problem.with_halo(Phase::lambda, [&](Range part) {  // lines 9 to 11
        problem.compute_lambda(
            part, Step{static_cast<T>(weight * relaxation_), static_cast<T>(weight - 1), static_cast<T>(-largest_)});
      });
      if (within_tolerance(settings_, problem)) return {k, true};
      problem.compute_delta_and_move(k == 0);  // lines 12 to 18
    }
    return {settings_.iterations, ends_within_tolerance(settings_, problem)};
  }

 private:
  // The step that replaces a multiplier, computed from the multiplier and the previous step.
  struct Step {
    T weight, memory, least;
    T operator()(T lambda, T last) const {
      const T kept = lambda * last > 0 ? memory : 0;  // without a branch, which would often be mispredicted
      return std::max(weight * lambda + kept * last, least);
    }
  };

  Real next_weight(int k, Real weight) const {
    const Real r2 = settings_.spectral_radius * settings_.spectral_radius;
    return k == 0 ? 1 : k == 1 ? 2 / (2 - r2) : 4 / (4 - r2 * weight);
  }

  DensitySettings settings_;
  Real relaxation_, largest_;
};

Projection make_projection(const DensitySolverContext& context) {
  return {context.comm,      context.grid,   context.box, {context.spacing, context.model.h, -context.gravity.z()},
          context.obstacles, context.scratch};
}

// The projection as the first iteration, then another solver for the remaining error; all of the motion becomes
// velocity.
template <class T>
class ProjectionFirst : public DensitySolver<T> {
 public:
  ProjectionFirst(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> fine)
      : projection_(make_projection(context)), fine_(std::move(fine)) {
    projection_.show_to(context.probes);
    projection_.open_to(context.openings);
  }

  void begin(DensityProblem<T>& problem) override {
    problem.project(projection_);
    projection_.give_back();
  }
  SolveResult solve(DensityProblem<T>& problem) override {
    problem.with_halo(Phase::move, [&](Range part) { problem.collide_and_move(part); });
    const SolveResult rest = fine_->solve(problem);
    return {rest.iterations + 1, rest.converged};
  }
  std::size_t bytes() const override { return projection_.bytes() + fine_->bytes(); }

 private:
  Projection projection_;
  std::unique_ptr<DensitySolver<T>> fine_;
};

// Velocities from the projection; the sweeps after it shift positions only.
template <class T>
class Projected : public DensitySolver<T> {
 public:
  Projected(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> sweeps, bool has_tolerance)
      : projection_(make_projection(context)), sweeps_(std::move(sweeps)), has_tolerance_(has_tolerance) {
    projection_.show_to(context.probes);
    projection_.open_to(context.openings);
  }

  void begin(DensityProblem<T>& problem) override { problem.project(projection_); }
  SolveResult solve(DensityProblem<T>& problem) override {
    problem.with_halo(Phase::move, [&](Range part) { problem.collide_and_move(part); });
    problem.set_velocities(has_tolerance_);
    const SolveResult rest = sweeps_->solve(problem);
    problem.release_in_flight();
    problem.filter_shifts(projection_);
    return {rest.iterations + 1, rest.converged};
  }
  bool sets_velocities() const override { return true; }
  std::size_t bytes() const override { return projection_.bytes() + sweeps_->bytes(); }

 private:
  Projection projection_;
  std::unique_ptr<DensitySolver<T>> sweeps_;
  bool has_tolerance_;
};

template <class T>
std::unique_ptr<DensitySolver<T>> make_fine(const DensitySettings& settings, const DensitySolverContext& context) {
  switch (settings.method) {
    case Method::chebyshev:
      return std::make_unique<Chebyshev<T>>(settings, context.model);
    case Method::anderson:
      return std::make_unique<Anderson<T>>(context.comm, settings, context.model.h);
    default:
      return std::make_unique<Jacobi<T>>(settings, context.model);
  }
}

}  // namespace

bool is_downward(const Vec3& gravity) { return gravity.z() < 0 && -gravity.z() >= gravity.head<2>().norm(); }

namespace {

bool has_projection(const DensitySettings& settings, const Vec3& gravity) {
  return settings.coarse_grid && (gravity.isZero() || is_downward(gravity));
}

}  // namespace

bool shifts_positions_only(const DensitySettings& settings, const Vec3& gravity) {
  return settings.method == Method::chebyshev && has_projection(settings, gravity);
}

template <class T>
std::unique_ptr<DensitySolver<T>> make_density_solver(const DensitySettings& settings,
                                                      const DensitySolverContext& context) {
  if (!has_projection(settings, context.gravity)) return make_fine<T>(settings, context);
  DensitySettings rest = settings;
  rest.iterations = std::max(1, rest.iterations - 1);  // without an iteration after it, the projection leaves noise
  std::unique_ptr<DensitySolver<T>> fine = make_fine<T>(rest, context);
  if (!shifts_positions_only(settings, context.gravity))
    return std::make_unique<ProjectionFirst<T>>(context, std::move(fine));
  return std::make_unique<FreeMomentum<T>>(
      context, std::make_unique<Projected<T>>(context, std::move(fine), rest.tolerance.has_value()));
}

template std::unique_ptr<DensitySolver<float>> make_density_solver(const DensitySettings&, const DensitySolverContext&);
template std::unique_ptr<DensitySolver<double>> make_density_solver(const DensitySettings&,
                                                                    const DensitySolverContext&);

}  // namespace trevi

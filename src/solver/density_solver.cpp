#include "solver/density_solver.hpp"

#include <algorithm>
#include <limits>

#include "base/threads.hpp"
#include "solver/anderson.hpp"
#include "solver/free_flight.hpp"

namespace trevi {

namespace {

// Limits each shift by a limit on the multipliers, such that no pair is pushed apart by more than max_shift even where
// the kernel gradient is largest. Shortening the shift of a particle on its own would leave its neighbours' opposite
// shifts as they are, and momentum would be lost wherever water meets at speed.
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
      problem.compute_delta();  // lines 12 to 14
      if (k == 0) problem.separate_coincident();
      problem.with_halo(Phase::move, [&](Range part) { problem.collide_and_move(part); });  // lines 14 to 18
    }
    return {settings_.iterations, ends_within_tolerance(settings_, problem)};
  }

 private:
  // What takes the place of a multiplier, from the last such step.
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

// The coarse-grid correction as the first iteration, then another solver for the error that it leaves.
template <class T>
class CoarseFirst : public DensitySolver<T> {
 public:
  CoarseFirst(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> fine)
      : coarse_(context.comm, context.grid, context.box, {context.spacing, context.model.h, -context.gravity.z()},
                context.obstacles),
        fine_(std::move(fine)) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    problem.compute_coarse_delta(coarse_);
    problem.with_halo(Phase::move, [&](Range part) { problem.collide_and_move(part); });
    const SolveResult rest = fine_->solve(problem);
    return {rest.iterations + 1, rest.converged};
  }
  std::size_t bytes() const override { return coarse_.bytes() + fine_->bytes(); }

 private:
  CoarseCorrection coarse_;
  std::unique_ptr<DensitySolver<T>> fine_;
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

template <class T>
std::unique_ptr<DensitySolver<T>> make_density_solver(const DensitySettings& settings,
                                                      const DensitySolverContext& context) {
  // Where the box repeats there is no angular momentum to keep.
  const bool endless = context.grid.is_periodic(0) || context.grid.is_periodic(1) || context.grid.is_periodic(2);
  if (settings.coarse_grid && context.gravity.isZero() && !endless)
    return std::make_unique<FreeFlight<T>>(context, make_fine<T>(settings, context));
  if (!settings.coarse_grid || !is_downward(context.gravity)) return make_fine<T>(settings, context);
  DensitySettings rest = settings;
  rest.iterations = std::max(1, rest.iterations - 1);  // without an iteration after it the correction amplifies noise
  return std::make_unique<CoarseFirst<T>>(context, make_fine<T>(rest, context));
}

template std::unique_ptr<DensitySolver<float>> make_density_solver(const DensitySettings&, const DensitySolverContext&);
template std::unique_ptr<DensitySolver<double>> make_density_solver(const DensitySettings&,
                                                                    const DensitySolverContext&);

}  // namespace trevi

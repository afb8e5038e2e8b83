#include "solver/density_method.hpp"

#include <algorithm>
#include <limits>

#include "solver/anderson.hpp"
#include "solver/free_flight.hpp"

namespace trevi {

namespace {

// The cap on shifts, as one on multipliers: a shift that is cut for each particle on its own would not be paid back by
// its neighbours, and momentum would be lost wherever water meets at speed. No pair is pushed apart by more than
// max_shift then, from the largest gradient that two particles can have.
Real largest_multiplier(const DensitySettings& settings, const DensityModel& model) {
  if (settings.max_shift == 0) return std::numeric_limits<Real>::infinity();
  return settings.max_shift * model.h /
         (2 * model.mass / model.rest_density * model.kernels.gradient.steepest(model.h));
}

template <class T>
class Jacobi : public DensityMethod<T> {
 public:
  Jacobi(const DensitySettings& settings, const DensityModel& model)
      : settings_(settings), largest_(largest_multiplier(settings, model)) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    for (int k = 0; k < settings_.iterations; ++k) {
      problem.compute_lambda(
          [&](std::size_t, Real lambda) { return std::max(lambda, -largest_ / settings_.relaxation); });
      if (within_tolerance(settings_, problem)) return {k, true};
      problem.compute_delta();
      problem.move([&](std::size_t, const Vec3& p, const Vec3& delta) {
        return problem.walls().collide(p, settings_.relaxation * delta);
      });
    }
    return {settings_.iterations, ends_within_tolerance(settings_, problem)};
  }

 private:
  DensitySettings settings_;
  Real largest_;
};

// Chebyshev semi-iteration. Wang combines positions; here the multipliers are combined,
//   step_{k+1} = w_{k+1} relaxation lambda_k + (w_{k+1} − 1) step_k,
// so that each shift is a sum over pairs of equal and opposite parts and keeps the momentum. The safeguard is a restart
// of each particle on its own (O'Donoghue & Candès 2015): where the new multiplier opposes the last step, or the
// particle is no longer compressed, its memory is dropped. It needs no reduction, and it is what makes deep water safe.
template <class T>
class Chebyshev : public DensityMethod<T> {
 public:
  Chebyshev(const DensitySettings& settings, const DensityModel& model)
      : settings_(settings), largest_(largest_multiplier(settings, model)) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    step_.assign(problem.density().size(), T{0});
    const Real r2 = settings_.spectral_radius * settings_.spectral_radius;
    Real weight = 1;
    for (int k = 0; k < settings_.iterations; ++k) {
      weight = k == 0 ? 1 : k == 1 ? 2 / (2 - r2) : 4 / (4 - r2 * weight);
      problem.compute_lambda([&](std::size_t i, Real lambda) {
        const Real memory = lambda * static_cast<Real>(step_[i]) > 0 ? (weight - 1) * static_cast<Real>(step_[i]) : 0;
        step_[i] = static_cast<T>(std::max(weight * settings_.relaxation * lambda + memory, -largest_));
        return static_cast<Real>(step_[i]);
      });
      if (within_tolerance(settings_, problem)) return {k, true};
      problem.compute_delta();
      if (k == 0) problem.separate_coincident();
      problem.move([&](std::size_t, const Vec3& p, const Vec3& delta) { return problem.walls().collide(p, delta); });
    }
    return {settings_.iterations, ends_within_tolerance(settings_, problem)};
  }
  std::size_t bytes() const override { return step_.capacity() * sizeof(T); }

 private:
  DensitySettings settings_;
  Real largest_;
  std::vector<T> step_;  // m², of the owned particles
};

// The coarse-grid correction as the first iteration, then another method for what it leaves.
template <class T>
class CoarseFirst : public DensityMethod<T> {
 public:
  CoarseFirst(const MethodContext& context, std::unique_ptr<DensityMethod<T>> fine)
      : coarse_(context.comm, context.grid, context.box, {context.spacing, context.model.h, -context.gravity.z()}),
        fine_(std::move(fine)) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    problem.compute_coarse_delta(coarse_);
    problem.move([&](std::size_t, const Vec3& p, const Vec3& delta) { return problem.walls().collide(p, delta); });
    const SolveResult rest = fine_->solve(problem);
    return {rest.iterations + 1, rest.converged};
  }
  std::size_t bytes() const override { return coarse_.bytes() + fine_->bytes(); }

 private:
  CoarseCorrection coarse_;
  std::unique_ptr<DensityMethod<T>> fine_;
};

template <class T>
std::unique_ptr<DensityMethod<T>> make_fine(const DensitySettings& settings, const MethodContext& context) {
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
std::unique_ptr<DensityMethod<T>> make_density_method(const DensitySettings& settings, const MethodContext& context) {
  if (settings.coarse_grid && context.gravity.isZero())
    return std::make_unique<FreeFlight<T>>(context, make_fine<T>(settings, context));
  if (!settings.coarse_grid || !is_downward(context.gravity)) return make_fine<T>(settings, context);
  DensitySettings rest = settings;
  rest.iterations = std::max(1, rest.iterations - 1);  // the coarse grid alone leaves noise that feeds on itself
  return std::make_unique<CoarseFirst<T>>(context, make_fine<T>(rest, context));
}

template std::unique_ptr<DensityMethod<float>> make_density_method(const DensitySettings&, const MethodContext&);
template std::unique_ptr<DensityMethod<double>> make_density_method(const DensitySettings&, const MethodContext&);

}  // namespace trevi

#include "trevi/solver/density_method.hpp"

#include "trevi/base/error.hpp"

namespace trevi {

namespace {

// Mean compression below the tolerance and the largest below ten times it; never met without a tolerance.
template <class T>
bool converged(const DensitySettings& settings, const DensityProblem<T>& problem) {
  if (!settings.tolerance) return false;
  const Compression c = problem.compression();
  return c.mean <= *settings.tolerance && c.max <= 10 * *settings.tolerance;
}

template <class T>
class Jacobi : public DensityMethod<T> {
 public:
  explicit Jacobi(const DensitySettings& settings) : settings_(settings) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    for (int k = 0; k < settings_.iterations; ++k) {
      problem.compute_lambda();
      if (converged(settings_, problem)) return {k, true};
      problem.compute_delta();
      problem.move([&](std::size_t, const Vec3& p, const Vec3& delta) {
        return problem.walls().collide(p, settings_.relaxation * delta);
      });
    }
    return {settings_.iterations, !settings_.tolerance};
  }

 private:
  DensitySettings settings_;
};

// Chebyshev semi-iteration on the multipliers (after Wang 2015, who iterates on positions).
template <class T>
class Chebyshev : public DensityMethod<T> {
 public:
  Chebyshev(const DensitySettings& settings, Real h) : settings_(settings), cap_(settings.max_shift * h) {}

  SolveResult solve(DensityProblem<T>& problem) override {
    Particles& particles = problem.particles();
    const bool warm = settings_.warm_start > 0;
    total_.assign(particles.id.size(), 0.0);
    if (warm) {
      for (std::size_t i = 0; i < total_.size(); ++i) total_[i] = settings_.warm_start * particles.lambda[i];
      problem.set_lambda([&](std::size_t i) { return total_[i]; });
      apply(problem);
    }
    previous_ = total_;
    Real omega = 1;
    const Real r2 = settings_.spectral_radius * settings_.spectral_radius;
    const bool clamp = settings_.constraint == Constraint::inequality;
    for (int k = 0; k < settings_.iterations; ++k) {
      omega = k == 0 ? 1 : k == 1 ? 2 / (2 - r2) : 4 / (4 - r2 * omega);
      problem.compute_lambda([&](std::size_t i, Real lambda) {
        const Real now = total_[i];
        Real next = omega * (now + settings_.relaxation * lambda - previous_[i]) + previous_[i];
        if (clamp) next = std::min(next, 0.0);
        previous_[i] = now;
        total_[i] = next;
        return next - now;
      });
      apply(problem);
    }
    if (warm) particles.lambda = total_;
    return {settings_.iterations, !settings_.tolerance};
  }

 private:
  void apply(DensityProblem<T>& problem) {
    problem.compute_delta();
    problem.move([&](std::size_t, const Vec3& p, const Vec3& delta) {
      Vec3 shift = delta;
      const Real length = shift.norm();
      if (cap_ > 0 && length > cap_) shift *= cap_ / length;
      return problem.walls().collide(p, shift);
    });
  }
  DensitySettings settings_;
  Real cap_;
  std::vector<Real> total_, previous_;
};

}  // namespace

template <class T>
std::unique_ptr<DensityMethod<T>> make_density_method(const DensitySettings& settings, Real h) {
  if (settings.method == Method::jacobi) return std::make_unique<Jacobi<T>>(settings);
  if (settings.method == Method::chebyshev) return std::make_unique<Chebyshev<T>>(settings, h);
  throw InputError("[density] method: only jacobi and chebyshev are built in");
}

template std::unique_ptr<DensityMethod<float>> make_density_method(const DensitySettings&, Real);
template std::unique_ptr<DensityMethod<double>> make_density_method(const DensitySettings&, Real);

}  // namespace trevi

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

}  // namespace

template <class T>
std::unique_ptr<DensityMethod<T>> make_density_method(const DensitySettings& settings, Real) {
  if (settings.method == Method::jacobi) return std::make_unique<Jacobi<T>>(settings);
  throw InputError("[density] method: only jacobi is built in");
}

template std::unique_ptr<DensityMethod<float>> make_density_method(const DensitySettings&, Real);
template std::unique_ptr<DensityMethod<double>> make_density_method(const DensitySettings&, Real);

}  // namespace trevi

#include "fluid/filters/xsph_viscosity.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "fluid/pairs/for_each_sum.hpp"
#include "kernels/poly6-inl.hpp"

namespace trevi {

namespace {

// The smallest M_i that is used, and the moment along an axis for which a gradient has half the value of a fit, both
// relative to those of the lattice. The top layer of a lattice has 0.59 to 0.68 of its M, an edge 0.34 to 0.45.
constexpr Real min_second_moment = 0.5, deficient_moment = 0.05;
// Largest eigenvalue of the sums in water of any disorder, relative to nu/M Σ_lattice F: 1.1 to 2.1.
constexpr Real largest_eigenvalue = 2.3;

// Calls use(i, Σ) for each owned particle i with the sums of a pair loop.
template <class T, class Loop, class Use>
void for_each_vector(const Neighbourhood<T>& near, const Loop& loop, const Use& use) {
  for_each_sum<Vec4<T>>(near.all(), loop, [&](Range here, const Vec4<T>* sum) {
    for (LocalId i = here.begin; i < here.end; ++i, ++sum) use(static_cast<std::size_t>(i), vector_of(*sum));
  });
}

using Matrix = Eigen::Matrix3d;

Matrix rows_of(const Vec3& x, const Vec3& y, const Vec3& z) {
  Matrix rows;
  rows << x.transpose(), y.transpose(), z.transpose();
  return rows;
}

// The moments Σ F u u, and by least squares the gradient of a velocity that is linear. Where neighbours lie in a plane
// or on a line, there is no gradient across it: along an axis with the moment m it is m²/(m² + deficient²) of that of
// the fit.
template <class T>
Matrix moments_of(const VelocityFit<T>& fit) {
  const auto& [x, y, z, mixed] = fit.row;
  return rows_of(Vec3(x.w, mixed.z, mixed.y), Vec3(mixed.z, y.w, mixed.x), Vec3(mixed.y, mixed.x, z.w));
}
template <class T>
Matrix slopes_of(const VelocityFit<T>& fit, Real deficient) {
  const auto& [x, y, z, mixed] = fit.row;
  const Matrix moments = moments_of(fit);
  const Matrix square = moments * moments + deficient * deficient * Matrix::Identity();
  return rows_of(vector_of(x), vector_of(y), vector_of(z)) * moments * square.inverse();
}

const Kernel& poly6_in(int dimensions) { return kernel_named(Poly6::name, dimensions); }

}  // namespace

template <class T>
XsphViscosity<T>::XsphViscosity(Real c, const DensityModel& model)
    : loops_(filter_loops<T>()), factor_(c * model.mass * poly6_in(model.kernels.density.dimensions).factor(model.h)) {}

template <class T>
void XsphViscosity<T>::apply(Neighbourhood<T>& near, Particles& particles, Real) {
  const ScopedEvent timed(event_);
  const Borrowed<Vec4<T>> velocities = all_velocities(near, particles.velocity);
  const Pairs<T> pairs = pairs_of(near);
  const auto smoothing = [&](Range part, Vec4<T>* out) { loops_.smoothing(pairs, part, velocities.data(), out); };
  for_each_vector(near, smoothing, [&](std::size_t i, const Vec3& sum) { particles.velocity[i] += factor_ * sum; });
  log_work(event_, static_cast<double>(near.list().pairs()) * 22, bytes_of_passes(near, 1));
}

Real longest_viscous_step(Real nu, const PointLattice& lattice, Real h) {
  return 2 / largest_eigenvalue * lattice_laplacian_moment(lattice, h) / (nu * (lattice_friction_sum(lattice, h) - 1));
}

template <class T>
KinematicViscosity<T>::KinematicViscosity(Real nu, const PointLattice& lattice, Real h,
                                          std::optional<ViscousWalls> walls)
    : loops_(friction_loops<T>(lattice.dimensions)),
      walls_(std::move(walls)),
      moment_(lattice_laplacian_moment(lattice, h)),
      per_moment_(h * h / (2 * lattice.dimensions * moment_)),
      deficient_(deficient_moment * 2 * moment_ / (h * h)),
      nu_(nu),
      truncation_(lattice_laplacian_truncation(lattice, h)) {}

// Half of the gradients; M_lattice/M_i is written to the scalar of the last one.
template <class T>
void KinematicViscosity<T>::fit(Neighbourhood<T>& near, const Vec4<T>* velocities, const std::vector<Vec3>& positions,
                                const std::array<Vec4<T>*, 3>& gradients) const {
  const Pairs<T> pairs = pairs_of(near);
  const auto number = [](Real value) { return static_cast<T>(value); };
  const auto fits = [&](Range part, VelocityFit<T>* out) { loops_.velocity_fit(pairs, part, velocities, out); };
  for_each_sum<VelocityFit<T>>(near.all(), fits, [&](Range here, const VelocityFit<T>* fit) {
    for (LocalId i = here.begin; i < here.end; ++i, ++fit) {
      Real moment = per_moment_ * moments_of(*fit).trace();
      if (walls_) moment += walls_->moment_behind(positions[static_cast<std::size_t>(i)]);
      const Matrix half = slopes_of(*fit, deficient_) / (2 * Packed<T>::units_per_h);
      for (int a = 0; a < 3; ++a)
        gradients[static_cast<std::size_t>(a)][i] = {number(half(a, 0)), number(half(a, 1)), number(half(a, 2)), T{0}};
      gradients[2][i].w = number(1 / std::max(moment, min_second_moment));
    }
  });
}

template <class T>
template <class Use>
void KinematicViscosity<T>::for_each_laplacian(Neighbourhood<T>& near, const std::vector<Vec3>& positions,
                                               const Vec4<T>* velocities, Gradients& gradients, const Use& use) const {
  auto& [x, y, z] = gradients;
  const LocalId own = near.order().low_ghosts();
  fit(near, velocities, positions, {x.data() + own, y.data() + own, z.data() + own});
  near.exchange_vectors(x);
  near.exchange_vectors(y);
  near.exchange(z);
  const Pairs<T> pairs = pairs_of(near);
  const auto friction = [&](Range part, Vec4<T>* out) {
    loops_.friction(pairs, part, velocities, {x.data(), y.data(), z.data()}, out);
  };
  for_each_vector(near, friction, [&](std::size_t i, const Vec3& sum) { use(i, sum / (2 * moment_)); });
}

template <class T>
void KinematicViscosity<T>::apply(Neighbourhood<T>& near, Particles& particles, Real dt) {
  const ScopedEvent timed(event_);
  const std::vector<Vec3>& positions = particles.predicted;
  const Borrowed<Vec4<T>> velocities = all_velocities(near, particles.velocity);
  const auto borrow = [&] { return near.scratch().template borrow<Vec4<T>>(near.records().size()); };
  Borrowed<Vec4<T>> between = borrow();
  Gradients gradients{borrow(), borrow(), borrow()};
  const auto own = static_cast<std::size_t>(near.order().low_ghosts());
  const auto number = [](Real value) { return static_cast<T>(value); };
  for_each_laplacian(near, positions, velocities.data(), gradients, [&](std::size_t i, const Vec3& laplacian) {
    const bool at_wall = walls_ && walls_->is_near(positions[i]);
    const Vec3 v = particles.velocity[i] + (at_wall ? 0 : nu_ * dt / 2 - truncation_) * laplacian;
    between[own + i] = {number(v.x()), number(v.y()), number(v.z()), T{0}};
  });
  near.exchange_vectors(between);
  for_each_laplacian(near, positions, between.data(), gradients,
                     [&](std::size_t i, const Vec3& laplacian) { particles.velocity[i] += nu_ * dt * laplacian; });
  if (walls_) {
    for_each_index(near.all(), [&](std::size_t i) {
      Vec3& v = particles.velocity[i];
      v = walls_->held(positions[i], v, gradients[2][own + i].w, dt);
    });
  }
  log_work(event_, static_cast<double>(near.list().pairs()) * 2 * (45 + 51), bytes_of_passes(near, 6));
}

template class XsphViscosity<float>;
template class XsphViscosity<double>;
template class KinematicViscosity<float>;
template class KinematicViscosity<double>;

}  // namespace trevi

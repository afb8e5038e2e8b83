#include "fluid/filters/viscous_walls.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trevi {

namespace {

constexpr Real pi = std::numbers::pi;

// Fraction of the moment behind a frictionless wall. A vortex between such walls keeps its rate best with it. With all
// of the moment, water moving along the wall lacks friction; without it, water moving across has too much
// (tests/fluid/test_viscosity.cpp).
constexpr Real share_behind_frictionless = 0.72;

// ∫ F x² over the volume, or in two dimensions the area, behind a plane at distance u; x in units of h.
Real moment_behind_plane(Real u, int dimensions) {
  const Real c2 = 1 - u * u, c = std::sqrt(c2), c3 = c2 * c, c5 = c3 * c2;
  const Real fifth = 5 * (pi / 2 - std::asin(u)) / 16 - u * (c5 / 6 + 5 * c3 / 24 + 5 * c / 16);  // ∫ c⁵ du to 1
  const Real seventh = u * c5 * c2;
  return dimensions == 2 ? 4.0 / 15 * fifth + 4.0 / 35 * seventh : pi * (3.0 / 20 * fifth + seventh / 28);
}

}  // namespace

ViscousWalls::ViscousWalls(Real nu, bool no_slip, const PointLattice& lattice, Real h, const Box& box,
                           std::shared_ptr<Obstacles> obstacles)
    : box_(box), obstacles_(std::move(obstacles)), h_(h), no_slip_(no_slip), dimensions_(lattice.dimensions) {
  const Real u = h / lattice.spacing, moment = lattice_laplacian_moment(lattice, h);
  const Real particles = u * u * (dimensions_ == 2 ? 1 : u);  // in h³, or h²
  factor_ = nu / moment * particles * (dimensions_ == 2 ? 16.0 / 105 : 2 * pi / 35);
  per_moment_ = particles * h * h / (2 * dimensions_ * moment) * (no_slip ? 1 : share_behind_frictionless);
  least_ = lattice.spacing / 8;  // a particle that is pushed against the wall does not stay there for ever
}

bool ViscousWalls::may_be_near(const Vec3& p) const {
  return obstacles_ || (p - box_.min).minCoeff() < h_ || (box_.max - p).minCoeff() < h_;
}

// Calls visit(account, distance, normal into the water, displacement in the substep of what moves with the wall at p).
template <class Visit>
void ViscousWalls::for_each_near(const Vec3& p, const Visit& visit) const {
  if (!may_be_near(p)) return;
  const auto visit_near = [&](std::size_t account, Real distance, const Vec3& normal, const Vec3& displacement) {
    if (distance < h_) visit(account, distance, normal, displacement);
  };
  const std::size_t account = obstacles_ ? obstacles_->box_account() : 0;
  for (int a = 0; a < 3; ++a) {
    visit_near(account, p[a] - box_.min[a], Vec3::Unit(a), Vec3::Zero());
    visit_near(account, box_.max[a] - p[a], -Vec3::Unit(a), Vec3::Zero());
  }
  if (obstacles_) obstacles_->for_each_near(p, visit_near);
}

bool ViscousWalls::is_near(const Vec3& p) const {
  bool any = false;
  for_each_near(p, [&](std::size_t, Real, const Vec3&, const Vec3&) { any = true; });
  return any;
}

Real ViscousWalls::moment_behind(const Vec3& p) const {
  Real sum = 0;
  for_each_near(p, [&](std::size_t, Real distance, const Vec3&, const Vec3&) {
    sum += moment_behind_plane(std::max(distance, 0.0) / h_, dimensions_);
  });
  return per_moment_ * sum;
}

// The rates, 1/s, along the normal and perpendicular to it.
Eigen::Matrix3d ViscousWalls::pull(Real distance, const Vec3& normal) const {
  const Real u = std::max(distance, least_) / h_, rest = std::max(1 - u * u, 0.0);
  const Real rate = factor_ * rest * rest * rest * std::sqrt(rest) / u;
  Eigen::Matrix3d pull = (no_slip_ ? 1 : 2) * rate * normal * normal.transpose();
  if (no_slip_) pull.diagonal().array() += rate;
  return pull;
}

Vec3 ViscousWalls::held(const Vec3& p, const Vec3& v, Real weight, Real dt) {
  Eigen::Matrix3d total = Eigen::Matrix3d::Identity();
  Vec3 sum = v;
  bool any = false;
  for_each_near(p, [&](std::size_t, Real distance, const Vec3& normal, const Vec3& displacement) {
    const Eigen::Matrix3d one = weight * pull(distance, normal);
    total += one * dt;
    sum += one * displacement;
    any = true;
  });
  if (!any) return v;
  const Vec3 after = total.inverse() * sum;
  if (obstacles_) {
    for_each_near(p, [&](std::size_t account, Real distance, const Vec3& normal, const Vec3& displacement) {
      obstacles_->record(account, weight * dt * (pull(distance, normal) * (displacement - after * dt)), p);
    });
  }
  return after;
}

}  // namespace trevi

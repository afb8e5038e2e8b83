#include "boundary/rigid_bodies/rigid_bodies.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// Sums over what bodies meet are integers, multiples of 2^-30: of speeds times dt over h, of squares of normals and of
// arms in their unit.
constexpr int fine = 30;

// h, or for a wide body large enough that no arm is longer than this many units: 64 bits hold the squares of the arms
// of as many particles as meet it at a time.
constexpr Real longest_arm = 64;
Real arm_unit_of(Real radius, Real h) { return std::ldexp(h, std::max(0, std::ilogb(radius / (longest_arm * h)) + 1)); }

// The impulse that a body gets from a drop of water, or from water that falls around it, leaves it in free fall.
RigidBody::Push push_of(const Six& given, Real by_weight) {
  constexpr Real little = 0.1;  // fraction of what its weight gives it
  if (dot(given, given) == 0) return RigidBody::Push::none;
  return along_of(given).norm() < little * by_weight ? RigidBody::Push::little : RigidBody::Push::full;
}

}  // namespace

RigidBodies::RigidBodies(const Settings& settings, const std::vector<std::unique_ptr<Body>>& all,
                         std::function<void()> placed)
    : all_(&all),
      placed_(std::move(placed)),
      first_(settings.obstacles.size()),
      water_mass_(settings.fluid.rest_density * settings.fluid.spacing * settings.fluid.spacing *
                  settings.fluid.spacing),
      h_(settings.fluid.kernel_radius),
      no_slip_(settings.no_slip),
      contacts_(settings, all) {
  for (const BodySettings& body : settings.bodies) {
    const Body& solid = *all[first_ + bodies_.size()];
    arm_unit_.push_back(arm_unit_of(solid.radius(), h_));
    is_smooth_.push_back(body.friction == 0 && !no_slip_);
    bodies_.emplace_back(body, solid.shape(), settings.gravity.value_or(Vec3::Zero()), settings.fluid.rest_density);
  }
  given_.resize(bodies_.size());
  moved_.resize(bodies_.size(), Vec3::Zero());
  spurious_.resize(bodies_.size(), Vec3::Zero());
  spun_.resize(bodies_.size(), Vec3::Zero());
  expected_.resize(bodies_.size());
  met_.for_each([&](auto& sums) { sums.assign(numbers * bodies_.size(), 0); });
  begin(0);
}

void RigidBodies::set_states(const std::vector<BodyState>& states) {
  for (std::size_t k = 0; k < std::min(bodies_.size(), states.size()); ++k) bodies_[k].set_state(states[k]);
  begin(0);
}

std::vector<BodyState> RigidBodies::states() const {
  std::vector<BodyState> states;
  for (const RigidBody& body : bodies_) states.push_back(body.state());
  return states;
}

Real RigidBodies::energy() const {
  Real sum = 0;
  for (const RigidBody& body : bodies_) sum += body.energy();
  return sum;
}

Real RigidBodies::take_driven_work() { return contacts_.take_driven_work(); }

Real RigidBodies::fastest(Real dt) const {
  Real most = 0;
  for (std::size_t k = 0; k < bodies_.size(); ++k)
    most = std::max(most, bodies_[k].fastest((*all_)[first_ + k]->radius(), dt));
  return most;
}

void RigidBodies::place() {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const RigidBody& body = bodies_[k];
    const Pose end = dt_ == 0 ? body.pose() : no_slip_ ? body.end_pose() : body.end_pose_without_spin();
    (*all_)[first_ + k]->place(body.pose(), end);
  }
  placed_();
}

void RigidBodies::begin(Real dt) {
  dt_ = dt;
  for (RigidBody& body : bodies_) {
    if (dt > 0) body.begin(dt);
  }
  std::fill(given_.begin(), given_.end(), Six{});
  std::fill(spurious_.begin(), spurious_.end(), Vec3::Zero());
  if (dt > 0) {
    contacts_.find(bodies_, dt);
    contacts_.solve(bodies_);
  }
  for (std::size_t k = 0; k < bodies_.size(); ++k) expected_[k] = bodies_[k].twist();
  place();
}

void RigidBodies::meet(std::size_t obstacle, const Vec3& p, const Vec3& normal, const Vec3& v, Real given) {
  const Vec3 arm = (p - bodies_[obstacle - first_].state().position) / arm_unit_[obstacle - first_];
  const Six g = six_of(normal, arm.cross(normal));
  const Real speed = normal.dot(v) * dt_ / h_;
  std::int64_t* sum = met_.mine().data() + numbers * (obstacle - first_);
  const auto add = [&](Real x) { *sum++ += std::llrint(std::ldexp(std::clamp(x, -0x1p20, 0x1p20), fine)); };
  for (std::size_t i = 0; i < 6; ++i) add(given * speed * g[i]);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j <= i; ++j) add(given * g[i] * g[j]);
  }
}

bool RigidBodies::settle(MPI_Comm comm) {
  const std::vector<std::int64_t> all = sum_over_threads_and_ranks(comm, met_);
  met_.for_each([](auto& sums) { std::fill(sums.begin(), sums.end(), 0); });
  bool changed = false;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const std::int64_t* sum = &all[numbers * k];
    if (std::all_of(sum, sum + numbers, [](std::int64_t n) { return n == 0; })) continue;
    changed = true;
    const auto next = [&](Real unit) { return std::ldexp(static_cast<Real>(*sum++), -fine) * unit; };
    const auto length = [&](std::size_t i) { return i < 3 ? 1 : arm_unit_[k]; };
    Six pushed{};
    for (std::size_t i = 0; i < 6; ++i) pushed[i] = next(water_mass_ * h_ / dt_ * length(i));
    Mass6 met{};
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j <= i; ++j) met[6 * i + j] = met[6 * j + i] = next(water_mass_ * length(i) * length(j));
    }
    const Six lacking = plus(pushed, times(met, expected_[k]), -1);
    RigidBody& body = bodies_[k];
    body.set_twist(plus(expected_[k], solved(plus(body.felt_inertia(), met), lacking, body.free())));
  }
  if (changed) place();
  return changed;
}

Six RigidBodies::impulse_of(const TotalImpulse& given) const {
  return plus({}, six_of(given.shift, given.moment), -water_mass_ / dt_);
}

Six RigidBodies::about_midway(std::size_t k, const Six& impulse) const {
  return six_of(along_of(impulse), about_of(impulse) - moved_[k].cross(along_of(impulse)));
}

Six RigidBodies::take_pressure(std::size_t k, const TotalImpulse& pushes) {
  const Six found = about_midway(k, impulse_of(pushes));
  spurious_[k] = bodies_[k].about_axes_of_revolution(about_of(found));
  return six_of(along_of(found), about_of(found) - spurious_[k]);
}

Vec3 RigidBodies::spin_without_friction(std::size_t k, const Vec3& moment) const {
  return is_smooth_[k] ? bodies_[k].about_axes_of_revolution(moment) : Vec3(Vec3::Zero());
}

Real RigidBodies::passed_by(std::size_t k, const TotalImpulse& push) const {
  const Vec3 moment = push.moment - moved_[k].cross(push.shift);
  const Vec3 counted = moment - bodies_[k].about_axes_of_revolution(moment);
  return dot(bodies_[k].twist(), six_of(push.shift, counted)) * dt_;
}

void RigidBodies::give(std::span<const TotalImpulse> all) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    moved_[k] = bodies_[k].midway_position() - bodies_[k].state().position;
    given_[k] = impulse_of(all[first_ + k]);
    spun_[k] = spin_without_friction(k, about_of(given_[k]));
    bodies_[k].give(plus(given_[k], six_of(Vec3::Zero(), spun_[k]), -1));
  }
}

void RigidBodies::respond(std::span<const Six> pressure) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    RigidBody& body = bodies_[k];
    body.hear(pressure[k]);
    const Six lacking = body.missing(pressure[k]);
    body.set_twist(plus(body.twist(), solved(body.felt_inertia(), lacking, body.free())));
  }
  contacts_.solve(bodies_);
  place();
}

bool RigidBodies::is_settled(std::span<const Six> pressure, Real tolerance) const {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const RigidBody& body = bodies_[k];
    const Six off = solved(body.inertia(), body.missing(pressure[k]), body.free());
    const Real speed = along_of(off).norm() + about_of(off).norm() * (*all_)[first_ + k]->radius();
    if (speed * dt_ > tolerance * h_) return false;
  }
  return true;
}

void RigidBodies::hear(std::span<const Six> pressure) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) bodies_[k].hear(pressure[k]);
}

void RigidBodies::finish(std::span<const TotalImpulse> all) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Six total = impulse_of(all[first_ + k]);
    const Six rest = about_midway(k, plus(total, given_[k], -1));
    if (is_smooth_[k]) spurious_[k] = spun_[k] + spin_without_friction(k, about_of(rest));
    bodies_[k].give(plus(rest, six_of(Vec3::Zero(), spurious_[k] - spun_[k]), -1));
    bodies_[k].finish(contacts_.touches(k) ? RigidBody::Push::full : push_of(total, bodies_[k].weight() * dt_));
  }
}

}  // namespace trevi

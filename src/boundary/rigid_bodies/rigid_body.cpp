#include "boundary/rigid_bodies/rigid_body.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace trevi {

namespace {

using Quaternion = std::array<Real, 4>;

Quaternion normalised(const Quaternion& q) {
  const Real length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

// Rotated about the axes of the world by a vector: an axis times the tangent of half the angle.
Quaternion turned(const Quaternion& q, const Vec3& t) {
  return normalised(
      {q[0] - t.x() * q[1] - t.y() * q[2] - t.z() * q[3], q[1] + t.x() * q[0] + t.y() * q[3] - t.z() * q[2],
       q[2] + t.y() * q[0] + t.z() * q[1] - t.x() * q[3], q[3] + t.z() * q[0] + t.x() * q[2] - t.y() * q[1]});
}

Mass6 mass_matrix(Real mass, const Rotation& inertia) {
  Mass6 all{};
  for (std::size_t i = 0; i < 3; ++i) {
    all[7 * i] = mass;
    for (std::size_t j = 0; j < 3; ++j)
      all[6 * (i + 3) + j + 3] = inertia(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
  return all;
}

// The water that each piece of the surface carries along is as thick as for a ball, whose added mass is half of the
// water that it displaces, or in two dimensions as for a circle, whose added mass is all of it. This is exact for a
// ball and a circle; for a disc it is 0.8 of the theoretical value. Triangles may be as large as the sides of a box;
// the mean over the midpoints of their edges is exact for squares of the arms.
Mass6 first_added_mass(const Shape& solid, const Vec3& center, Real water) {
  const Vec3 extent = solid.bounds().max - solid.bounds().min;
  const TriangleMesh mesh = solid.surface(extent.maxCoeff() / 200);
  const std::optional<Eigen::Index> along = solid.extruded_along();
  Mass6 sum{};
  Real whole = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 &a = mesh.points[static_cast<std::size_t>(i)], &b = mesh.points[static_cast<std::size_t>(j)],
               &c = mesh.points[static_cast<std::size_t>(k)];
    const Vec3 twice = (b - a).cross(c - a);
    const Real area = twice.norm() / 2;
    if (!(area > 0)) continue;
    const Vec3 normal = twice / (2 * area);
    if (along && std::abs(normal[*along]) > 0.5) continue;  // an end of what is shown of it
    for (const Vec3& middle : {Vec3((a + b) / 2), Vec3((b + c) / 2), Vec3((c + a) / 2)})
      add_square(sum, six_of(normal, (middle - center).cross(normal)), area / 3);
    whole += area;
  }
  const Real thickness =
      along ? whole / (2 * std::numbers::pi * extent[*along]) : std::sqrt(whole / (16 * std::numbers::pi));
  for (Real& one : sum) one *= water * thickness;
  return sum;
}

}  // namespace

Rotation rotation_of(const Quaternion& q) {
  const auto [w, x, y, z] = q;
  Rotation turn;
  turn << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),      //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return turn;
}

// From the largest of the four components (Shepperd, J. Guidance Control 1, 1978).
Quaternion quaternion_of(const Rotation& t) {
  const std::array<Real, 4> squares{1 + t(0, 0) + t(1, 1) + t(2, 2), 1 + t(0, 0) - t(1, 1) - t(2, 2),
                                    1 - t(0, 0) + t(1, 1) - t(2, 2), 1 - t(0, 0) - t(1, 1) + t(2, 2)};
  const auto k = std::max_element(squares.begin(), squares.end()) - squares.begin();
  const Real twice = std::sqrt(squares[static_cast<std::size_t>(k)]), part = 0.5 / twice;
  Quaternion q{};
  if (k == 0) q = {twice / 2, (t(2, 1) - t(1, 2)) * part, (t(0, 2) - t(2, 0)) * part, (t(1, 0) - t(0, 1)) * part};
  if (k == 1) q = {(t(2, 1) - t(1, 2)) * part, twice / 2, (t(0, 1) + t(1, 0)) * part, (t(0, 2) + t(2, 0)) * part};
  if (k == 2) q = {(t(0, 2) - t(2, 0)) * part, (t(0, 1) + t(1, 0)) * part, twice / 2, (t(1, 2) + t(2, 1)) * part};
  if (k == 3) q = {(t(1, 0) - t(0, 1)) * part, (t(0, 2) + t(2, 0)) * part, (t(1, 2) + t(2, 1)) * part, twice / 2};
  if (q[0] < 0) q = {-q[0], -q[1], -q[2], -q[3]};
  return normalised(q);
}

RigidBody::RigidBody(const BodySettings& settings, const Shape& solid, const Vec3& gravity, Real water)
    : free_(settings.free), gravity_(gravity), mooring_(settings.mooring) {
  const MassProperties shape = mass_properties(settings);
  const Real density = settings.mass ? *settings.mass / shape.volume : settings.density.value_or(water);
  mass_ = density * shape.volume;
  volume_ = shape.volume;
  center_ = shape.center;
  moment_ = density * shape.inertia;
  const Pose start = BodyMotion(settings).at(0);
  state_.position = start.into_world(center_);
  state_.orientation = quaternion_of(start.turn);
  const Rotation turn = rotation_of(state_.orientation), inertia = inertia_at(turn);
  state_.velocity = settings.velocity;
  state_.angular_velocity = settings.angular_velocity;
  state_.momentum = mass_ * settings.velocity;
  state_.angular_momentum = inertia * settings.angular_velocity;
  state_.last_twist = six_of(state_.velocity, state_.angular_velocity);
  first_added_ = first_added_mass(solid, center_, water);
  revolution_ = axes_of_revolution(settings);
  state_.added_mass = first_added_;
  if (!mooring_) return;
  hook_ = turn.transpose() * (mooring_->point.value_or(state_.position) - state_.position);
  rest_length_ = mooring_->length.value_or((state_.position + turn * hook_ - mooring_->anchor).norm());
}

Pose RigidBody::pose_of(const Vec3& position, const Quaternion& orientation) const {
  const Rotation turn = rotation_of(orientation);
  return {position - turn * center_, turn};
}

// ---- the mooring

struct RigidBody::Line {
  Vec3 arm, direction;  // from the centre of mass to the hook; from there to the anchor
  Real stretch;         // m
};

RigidBody::Line RigidBody::line() const {
  const Vec3 arm = rotation_of(state_.orientation) * hook_, to = mooring_->anchor - state_.position - arm;
  const Real length = to.norm();
  return {arm, length > 0 ? Vec3(to / length) : Vec3::Zero(), length - rest_length_};
}

Six RigidBody::mooring_force() const {
  const Line here = line();
  if (mooring_->slack && here.stretch <= 0) return {};
  const Vec3 velocity = state_.velocity + state_.angular_velocity.cross(here.arm);
  Real pull = mooring_->stiffness * here.stretch - mooring_->damping * velocity.dot(here.direction);
  if (mooring_->slack) pull = std::max(pull, 0.0);
  const Vec3 force = pull * here.direction;
  return six_of(force, here.arm.cross(force));
}

// The response of the hook's velocity to a pull of 1 N s is a symmetric matrix; its largest eigenvalue is 1 over this
// mass.
Real RigidBody::mass_at_mooring() const {
  const Rotation turn = rotation_of(state_.orientation);
  const Mass6 mass = mass_matrix(mass_, inertia_at(turn));
  const Vec3 arm = turn * hook_;
  Eigen::Matrix3d mobility;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Six answer = solved(mass, six_of(Vec3::Unit(i), arm.cross(Vec3(Vec3::Unit(i)))), free_);
    mobility.col(i) = along_of(answer) + about_of(answer).cross(arm);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> values(mobility, Eigen::EigenvaluesOnly);
  return 1 / std::max(values.eigenvalues().maxCoeff(), 0.0);
}

Real RigidBody::mooring_energy() const {
  if (!mooring_) return 0;
  const Real stretch = line().stretch;
  return mooring_->slack && stretch < 0 ? 0 : mooring_->stiffness * stretch * stretch / 2;
}

// ---- the substep

Six RigidBody::velocities(const Six& momentum, const Rotation& turn) const {
  return solved(mass_matrix(mass_, inertia_at(turn)), momentum, free_);
}

Real RigidBody::energy() const {
  const Six momentum = six_of(state_.momentum, state_.angular_momentum);
  return dot(momentum, velocities(momentum, rotation_of(state_.orientation))) / 2 -
         mass_ * gravity_.dot(state_.position) + mooring_energy();
}

Real RigidBody::fastest(Real radius, Real dt) const {
  return state_.velocity.norm() + gravity_.norm() * dt + state_.angular_velocity.norm() * (radius + center_.norm());
}

void RigidBody::begin(Real dt) {
  dt_ = dt;
  answers_ = 0;
  is_wet_ = state_.last_force != Six{};
  added_ = turned(state_.added_mass, rotation_of(state_.orientation));
  momentum_ = six_of(state_.momentum + dt * mass_ * gravity_, state_.angular_momentum);
  pull_ = mooring_ ? mooring_force() : Six{};
  if (mooring_) momentum_ = plus(momentum_, pull_, dt);
  const Six expected = plus(momentum_, state_.last_force, dt);
  // The twist is that at the orientation midway, to which it itself leads.
  constexpr int rounds = 6;
  Rotation middle = rotation_of(state_.orientation);
  for (int k = 0; k < rounds; ++k) {
    twist_ = velocities(expected, middle);
    middle = rotation_of(turned(state_.orientation, about_of(twist_) * (dt / 4)));
  }
  inertia_ = mass_matrix(mass_, inertia_at(middle));
  set_twist(velocities(expected, middle));
  if (!is_wet_) return;
  // Water goes on with it, and what the pressure had too much of the body in the last substep is not seen by a light
  // one.
  set_twist(state_.last_twist);
  set_twist(plus(twist_, solved(felt_inertia(), missing(plus({}, state_.last_force, dt)), free_)));
}

void RigidBody::set_twist(const Six& twist) {
  twist_ = twist;
  end_orientation_ = turned(state_.orientation, about_of(twist_) * (dt_ / 2));
}

Pose RigidBody::end_pose_without_spin() const {
  const Vec3 turning = about_of(twist_);
  return pose_of(end_position(), turned(state_.orientation, (turning - about_axes_of_revolution(turning)) * (dt_ / 2)));
}

Vec3 RigidBody::about_axes_of_revolution(const Vec3& vector) const {
  const Rotation turn = rotation_of(end_orientation_);
  return turn * (revolution_ * (turn.transpose() * vector));
}

// The fraction of the response `found` that counts; the rest is `known`, the response of the water as estimated. With
// it the response corresponds to no more than `most` times what `wide` represents. The effect of noise or of another
// body on the pressure may be perpendicular to the step, and would lead to an unbounded added mass.
Real RigidBody::part_that_counts(const Six& step, const Six& found, const Six& known, const Mass6& wide) const {
  constexpr Real most = 100;
  const auto weighed = [&](const Six& a) { return solved(wide, a, free_); };
  const Six more = plus(found, known, -1), weighed_more = weighed(more);
  // A quadratic function of this fraction, which is 0 where the response is exactly this large.
  const Real square = dot(more, weighed_more), slope = 2 * dot(known, weighed_more) - most * dot(step, more),
             none = dot(known, weighed(known)) - most * dot(step, known);
  if (square + slope + none <= 0) return 1;
  if (none >= 0) return 0;
  return (std::sqrt(slope * slope - 4 * square * none) - slope) / (2 * square);
}

// The formula of Broyden, Fletcher, Goldfarb and Shanno keeps the matrix positive. Powell's damping keeps it so where
// the response grows with the twist, and a second damping keeps it bounded (Goldfarb, Ren & Bahamou, 2020). An estimate
// is good enough if it is half of the true value.
void RigidBody::hear(const Six& pressure) {
  if (answers_ > 0) {
    const Six step = plus(twist_, asked_, -1), known = times(added_, step);
    Six resistance = plus(answer_, pressure, -1);
    const auto take = [&](Real part) {
      for (std::size_t i = 0; i < 6; ++i) resistance[i] = part * resistance[i] + (1 - part) * known[i];
    };
    const Real expected = dot(step, known), found = dot(step, resistance);
    const Real kinetic = dot(step, times(inertia_, step));
    constexpr Real least = 0.2;
    if (expected > 1e-12 * kinetic && kinetic > 0) {
      if (found < least * expected) take((1 - least) * expected / (expected - found));
      const Mass6 wide = plus(inertia_, turned(first_added_, rotation_of(state_.orientation)));
      if (const Real part = part_that_counts(step, resistance, known, wide); part < 1) take(part);
      add_square(added_, known, -1 / expected);
      add_square(added_, resistance, 1 / dot(step, resistance));
    }
  }
  is_wet_ = pressure != Six{};
  ++answers_;
  asked_ = twist_;
  answer_ = pressure;
}

// In the air: from the momentum midway between the kicks of gravity and the mooring (velocity Verlet).
Six RigidBody::mean_twist() const {
  const Six outside = plus(six_of(mass_ * gravity_, Vec3::Zero()), pull_);
  return solved(inertia_, plus(momentum_, outside, -dt_ / 2), free_);
}

void RigidBody::take_momentum() {
  for (std::size_t i = 0; i < 6; ++i)
    if (!free_[i]) momentum_[i] = 0;
  state_.momentum = along_of(momentum_);
  state_.angular_momentum = about_of(momentum_);
  const Six now = velocities(momentum_, rotation_of(state_.orientation));
  state_.velocity = along_of(now);
  state_.angular_velocity = about_of(now);
}

void RigidBody::finish(Push push) {
  const bool swings = mooring_ && push == Push::none;
  const Vec3 fall = push == Push::full || mooring_ ? Vec3(Vec3::Zero()) : Vec3(gravity_ * (dt_ * dt_ / 2));
  if (swings) set_twist(mean_twist());
  for (int a = 0; a < 3; ++a)
    state_.position[a] +=
        dt_ * twist_[static_cast<std::size_t>(a)] - (free_[static_cast<std::size_t>(a)] ? fall[a] : 0);
  // What has been learnt is slowly forgotten. Otherwise responses that noise has made small would add up to an estimate
  // that vanishes along some axis, and then to one that is not positive.
  constexpr Real forgotten = 0.02;
  state_.added_mass = turned(added_, rotation_of(state_.orientation).transpose());
  if (answers_ > 0) {
    for (std::size_t i = 0; i < 36; ++i) state_.added_mass[i] += forgotten * (first_added_[i] - state_.added_mass[i]);
  }
  state_.last_twist = twist_;
  state_.orientation = end_orientation_;
  take_momentum();
  if (swings) {
    momentum_ = plus(momentum_, plus(mooring_force(), pull_, -1), dt_ / 2);
    take_momentum();
  }
  if (answers_ > 0) {
    for (std::size_t i = 0; i < 6; ++i) state_.last_force[i] = answer_[i] / dt_;
  } else {
    state_.last_force = {};
  }
}

}  // namespace trevi

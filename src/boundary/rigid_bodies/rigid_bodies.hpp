// The rigid bodies of a scene among its obstacles: what the water sees of them is a moving obstacle, and what moves
// them are the impulses of the ledger, on all ranks the same integers and the same arithmetic.
//
// A substep: begin() takes the bodies where they would go with the pressure of the last one. settle() finds how fast
// they are when the particles that are about to bounce have done so: for a body lighter than these, its own velocity is
// decided by them. respond() answers to the pressure, between the cycles of the projection: with the added mass A that
// the answers so far have shown, (M + A) du = p + F − M u has its fixed point where the body has just the momentum that
// it was given, and converges for any mass when the estimate of A is more than half of it (Causin, Gerbeau & Nobile,
// Comput. Methods Appl. Mech. Engrg. 194, 2005, on why explicit staggering cannot). finish() hands over what the
// ledger says, but for spurious moments. Collective: settle().
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/threads.hpp"
#include "boundary/impulse_ledger.hpp"
#include "boundary/obstacles/body.hpp"
#include "boundary/rigid_bodies/contacts.hpp"
#include "boundary/rigid_bodies/rigid_body.hpp"
#include "trevi/session.hpp"

namespace trevi {

class RigidBodies {
 public:
  /// `all`: obstacles, then the bodies; they outlive this. `placed` is told when they have been moved.
  RigidBodies(const Settings& settings, const std::vector<std::unique_ptr<Body>>& all, std::function<void()> placed);

  std::size_t count() const { return bodies_.size(); }
  /// The number of the first among obstacles.
  std::size_t first() const { return first_; }
  bool holds(std::size_t obstacle) const { return obstacle >= first_ && obstacle < first_ + bodies_.size(); }
  /// About where the ledger has moments of a body: its centre of mass at the start of the substep.
  const Vec3& center(std::size_t obstacle) const { return bodies_[obstacle - first_].state().position; }
  const RigidBody& body(std::size_t k) const { return bodies_[k]; }

  void set_states(const std::vector<BodyState>& states);
  std::vector<BodyState> states() const;
  Real energy() const;
  /// What obstacles that move by themselves have done to the bodies, J since the last call.
  Real take_driven_work();
  Real fastest(Real dt) const;

  void begin(Real dt);
  /// A particle of the velocity v that meets obstacle k with this normal at p; `given`: what of its approach becomes
  /// impulse, 1 + the restitution. On any thread.
  void meet(std::size_t obstacle, const Vec3& p, const Vec3& normal, const Vec3& v, Real given);
  /// Whether what they met changes the bodies' motion; they are placed anew then.
  bool settle(MPI_Comm comm);
  /// What the ledger has had of all obstacles in this substep so far.
  void give(std::span<const TotalImpulse> all);
  /// The pressure's impulses, N s, of the bodies in their order. They move accordingly.
  void respond(std::span<const Six> pressure);
  /// Whether by that pressure each moves within the substep as far as its momentum says, by its own mass and to that
  /// part of h at its surface.
  bool is_settled(std::span<const Six> pressure, Real tolerance) const;
  /// The last of them, to which nobody moves any more.
  void hear(std::span<const Six> pressure);
  /// Of all that the ledger has of the substep.
  void finish(std::span<const TotalImpulse> all);

  /// N s and N m s, of what the pressure has in the ledger of body k, about where its centre is when cells are cut: it
  /// pushes at their faces. About the start of the substep a body that moves would turn by itself, as gravity and the
  /// pressure would not meet in one point. Its moment about axes of revolution of the shape is spurious, as the cells
  /// see stairs, and taken off; finish() takes off the last one. Light balls were spun by it until they burst the
  /// water.
  Six take_pressure(std::size_t k, const TotalImpulse& pushes);
  /// The last moment that was taken off, as the ledger has it.
  Vec3 spurious_moment(std::size_t k) const { return spurious_[k] * (-dt_ / water_mass_); }

 private:
  // Of an account of the ledger, about the centre at the start of the substep.
  Six impulse_of(const TotalImpulse& given) const;
  Six about_midway(std::size_t k, const Six& impulse) const;
  void place();

  const std::vector<std::unique_ptr<Body>>* all_;
  std::function<void()> placed_;
  std::size_t first_;
  Real water_mass_;  // of a particle, kg
  Real h_, dt_ = 0;
  bool no_slip_;  // a spin about an axis of revolution takes water along only where walls hold it
  std::vector<RigidBody> bodies_;
  std::vector<Real> arm_unit_;  // m, in which arms of what they meet are counted
  std::vector<Six> given_;      // by the ledger before the projection
  std::vector<Vec3> moved_;     // of the centres to where cells are cut, m
  std::vector<Vec3> spurious_;  // moments of the last pressure about axes of revolution, N m s
  std::vector<Six> expected_;   // twists without the particles that bounce
  Contacts contacts_;
  static constexpr std::size_t numbers = 27;  // of what a body meets: 6 sums, and 21 of a symmetric matrix
  PerThread<std::vector<std::int64_t>> met_;
};

}  // namespace trevi

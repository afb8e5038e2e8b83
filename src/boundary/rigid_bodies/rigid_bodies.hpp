// The rigid bodies of a scene among its obstacles. For the water they are moving obstacles; they are moved by the
// impulses of the ledger, on all ranks with the same integers and the same arithmetic.
//
// A substep: begin() takes the bodies to where they would go with the pressure of the last one. settle() finds how fast
// they are when the particles that are about to bounce off them have done so; the velocity of a body lighter than these
// is determined by them. respond() reacts to the pressure, between the cycles of the projection: with the added mass A
// that the responses so far have shown, (M + A) du = p + F − M u has its fixed point where the body has exactly the
// momentum that it was given, and converges for any mass if the estimate of A is more than half of its value (Causin,
// Gerbeau & Nobile, Comput. Methods Appl. Mech. Engrg. 194, 2005, on why explicit staggering cannot). finish() hands
// over what the ledger contains, except for spurious moments. Collective: settle().
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
  /// `all`: obstacles, then the bodies; they outlive this object. `placed` is called when they have been moved.
  RigidBodies(const Settings& settings, const std::vector<std::unique_ptr<Body>>& all, std::function<void()> placed);

  std::size_t count() const { return bodies_.size(); }
  /// The number of the first body among the obstacles.
  std::size_t first() const { return first_; }
  bool holds(std::size_t obstacle) const { return obstacle >= first_ && obstacle < first_ + bodies_.size(); }
  /// The reference point of a body's moments in the ledger: its centre of mass at the start of the substep.
  const Vec3& center(std::size_t obstacle) const { return bodies_[obstacle - first_].state().position; }
  const RigidBody& body(std::size_t k) const { return bodies_[k]; }

  void set_states(const std::vector<BodyState>& states);
  std::vector<BodyState> states() const;
  Real energy() const;
  /// The work that obstacles moving by themselves have done on the bodies, J, since the last call.
  Real take_driven_work();
  Real fastest(Real dt) const;

  void begin(Real dt);
  /// A particle of velocity v meets obstacle k with this normal at p; `given`: the fraction of its approach speed that
  /// becomes impulse, 1 + the restitution. On any thread.
  void meet(std::size_t obstacle, const Vec3& p, const Vec3& normal, const Vec3& v, Real given);
  /// Whether what the bodies met changes their motion; if so, they are placed anew.
  bool settle(MPI_Comm comm);
  /// What the ledger holds for all obstacles in this substep so far.
  void give(std::span<const TotalImpulse> all);
  /// The impulses of the pressure, N s, for the bodies in their order. They move accordingly.
  void respond(std::span<const Six> pressure);
  /// Whether with this pressure each body moves within the substep as far as its momentum requires, judged by its own
  /// mass, to within this fraction of h at its surface.
  bool is_settled(std::span<const Six> pressure, Real tolerance) const;
  /// The last pressure, to which no body responds by moving any more.
  void hear(std::span<const Six> pressure);
  /// From all that the ledger holds for the substep.
  void finish(std::span<const TotalImpulse> all);

  /// The impulse of the pressure on body k from the ledger, N s and N m s, about the position of its centre when cells
  /// are cut, because pressure acts on their faces. About its position at the start of the substep a moving body would
  /// rotate by itself, as gravity and pressure would not act at one point. The moment about axes of revolution of the
  /// shape is spurious, because the cells see a staircase, and is removed; finish() removes the last one. Such moments
  /// spun light balls until they burst the water.
  Six take_pressure(std::size_t k, const TotalImpulse& pushes);
  /// The work of a uniform pressure of 1 on a part of the surface of body k, by its present twist in the substep;
  /// `push` is what the pressure would give to the body, about the same point and in any unit. This is the transpose of
  /// take_pressure(): the moment about axes of revolution does no work.
  Real passed_by(std::size_t k, const TotalImpulse& push) const;
  /// The moments that were removed in the substep, as the ledger holds them.
  Vec3 spurious_moment(std::size_t k) const { return spurious_[k] * (-dt_ / water_mass_); }

 private:
  // The impulse of an account of the ledger, about the centre at the start of the substep.
  Six impulse_of(const TotalImpulse& given) const;
  Six about_midway(std::size_t k, const Six& impulse) const;
  // The part of a moment of the water, N m s, that would spin a body without friction about an axis of revolution. The
  // impulses act where the centre is on its way, which their moments do not know.
  Vec3 spin_without_friction(std::size_t k, const Vec3& moment) const;
  void place();

  const std::vector<std::unique_ptr<Body>>* all_;
  std::function<void()> placed_;
  std::size_t first_;
  Real water_mass_;  // of a particle, kg
  Real h_, dt_ = 0;
  bool no_slip_;  // a spin about an axis of revolution takes water along only where walls hold it
  std::vector<RigidBody> bodies_;
  std::vector<Real> arm_unit_;   // m, in which arms of what they meet are counted
  std::vector<Six> given_;       // by the ledger before the projection
  std::vector<Vec3> moved_;      // displacements of the centres to where cells are cut, m
  std::vector<Vec3> spurious_;   // moments of the last pressure about axes of revolution, N m s
  std::vector<Vec3> spun_;       // the same of what particles gave that bounced before
  std::vector<Six> expected_;    // twists without the particles that bounce
  std::vector<bool> is_smooth_;  // without friction
  Contacts contacts_;
  static constexpr std::size_t numbers = 27;  // of what a body meets: 6 sums, and 21 of a symmetric matrix
  PerThread<std::vector<std::int64_t>> met_;
};

}  // namespace trevi

// Water in the air flies exactly on the parabola. Where nothing but gravity acts on a particle in a substep, it moves
// by the mean of its two velocities, x_{n+1} = x_n + (v_n + v_{n+1}) Δt/2. This is the leapfrog path by the new
// velocity alone, plus the lift −g Δt²/2. Water that is supported by pressure remains with leapfrog, which alone is
// stable for waves. In between, the lift fades with the square of the share of the pressure, so that it never raises
// the sum of kinetic and potential energy. A pump that holds a particle against gravity for τ of the substep leaves −g
// (Δt² − τ²)/2 of the lift. Not collective.
#pragma once

#include <functional>
#include <span>

#include "base/scratch.hpp"
#include "boundary/boundary.hpp"
#include "particles/packed.hpp"

namespace trevi {

template <class T>
class FreeFlight {
 public:
  /// `gravity` in m/s², h in m.
  FreeFlight(const Vec3& gravity, Real h, Boundary& boundary) : gravity_(gravity), h_(h), boundary_(boundary) {}

  /// Starts a substep of dt, s. `held`: for how long something other than gravity determines the motion of a particle,
  /// s; may be empty.
  void start(Real dt, std::function<Real(std::size_t)> held) {
    dt_ = dt;
    most_ = static_cast<T>((gravity_ / 2).squaredNorm() * dt * dt * dt * dt);
    held_ = std::move(held);
  }
  /// Whether a particle with this displacement by the pressure, m, may fly: if it is less than half of that by gravity.
  bool may_fly(const Vec4<T>& d) const { return d.x * d.x + d.y * d.y + d.z * d.z < most_; }
  /// Finds which of all particles fly, by these displacements to the positions p*. Needed only if one may fly.
  void find(Range all, std::span<const Vec4<T>> displacements, std::span<const Vec3> p, Scratch& scratch);
  /// `some` belong to pieces of water that touch nothing: all of these that nothing holds fly, whatever the pressure.
  void let_fly(Range all, std::span<const Range> some, Scratch& scratch);
  /// Particles with multipliers, which are pressed by what they meet, do not fly, except for those of let_fly().
  void land(Range all, std::span<const T> multipliers);
  /// Lifts the positions p* of all particles as far as walls allow.
  void lift(Range all, std::span<Vec3> p) const;
  /// The lift of particle i at the end, m.
  Vec3 lift_of(std::size_t i) const { return flies_.empty() ? Vec3(Vec3::Zero()) : Vec3(share(i) * lift_in_full()); }
  void give_back() { flies_.give_back(); }

 private:
  static constexpr T let = 2;  // added to the share of particles of let_fly()
  Real share(std::size_t i) const { return flies_[i] >= let ? flies_[i] - let : flies_[i]; }
  Vec3 lift_in_full() const { return -gravity_ * (dt_ * dt_ / 2); }
  // The share of the lift that pumps leave.
  Real left_by_pumps(std::size_t i) const {
    const Real held = held_ ? held_(i) / dt_ : 0;
    return 1 - held * held;
  }
  // Whether there is nothing so close below that water may rest on it.
  bool is_clear(const Vec3& p) const;
  void borrow(Range all, Scratch& scratch);

  Vec3 gravity_;
  Real h_;
  Boundary& boundary_;
  Real dt_ = 0;
  T most_ = 0;  // square of half of the displacement by gravity, m²
  std::function<Real(std::size_t)> held_;
  Borrowed<T> flies_;  // share of its lift that each particle gets; empty if none flies
};

extern template class FreeFlight<float>;
extern template class FreeFlight<double>;

}  // namespace trevi

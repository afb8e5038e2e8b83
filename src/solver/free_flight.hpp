// Water in the air flies on the parabola itself: where nothing but gravity acts on a particle in a substep, it moves by
// the mean of its two velocities, x_{n+1} = x_n + (v_n + v_{n+1}) Δt/2, which is the path by the new one alone, as
// leapfrog has it, and the lift −g Δt²/2 besides. What a pressure carries stays with leapfrog, which alone is stable
// for waves; in between the lift fades with the square of the pressure's share, so that kinetic and potential energy
// together never rise by it. A pump that holds a particle for τ of the substep, against gravity, leaves
// −g (Δt² − τ²)/2 of the lift. Not collective.
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

  /// Starts a substep of dt, s. `held`: for how long not gravity but something else decides how a particle moves, s;
  /// may be empty.
  void start(Real dt, std::function<Real(std::size_t)> held) {
    dt_ = dt;
    most_ = static_cast<T>((gravity_ / 2).squaredNorm() * dt * dt * dt * dt);
    held_ = std::move(held);
  }
  /// Whether a particle may that the pressure has displaced so, m: by less than half of what gravity does.
  bool may_fly(const Vec4<T>& d) const { return d.x * d.x + d.y * d.y + d.z * d.z < most_; }
  /// Finds which particles of all fly, by these displacements, to places p*. Needed only where one may.
  void find(Range all, std::span<const Vec4<T>> displacements, std::span<const Vec3> p, Scratch& scratch);
  /// Some of them are of pieces of water that touch nothing: all fly that nothing holds, whatever presses them.
  void let_fly(Range all, std::span<const Range> some, Scratch& scratch);
  /// Water that is pressed by what it meets, with multipliers, does not fly, but for what is let fly.
  void land(Range all, std::span<const T> multipliers);
  /// Lifts the places p* of all as far as walls allow.
  void lift(Range all, std::span<Vec3> p) const;
  /// What it is lifted by at the end, m.
  Vec3 lift_of(std::size_t i) const { return flies_.empty() ? Vec3(Vec3::Zero()) : Vec3(share(i) * lift_in_full()); }
  void give_back() { flies_.give_back(); }

 private:
  static constexpr T let = 2;  // more of what is let fly
  Real share(std::size_t i) const { return flies_[i] >= let ? flies_[i] - let : flies_[i]; }
  Vec3 lift_in_full() const { return -gravity_ * (dt_ * dt_ / 2); }
  // Of the lift.
  Real left_by_pumps(std::size_t i) const {
    const Real held = held_ ? held_(i) / dt_ : 0;
    return 1 - held * held;
  }
  // Whether there is nothing so near below that water may rest on it.
  bool is_clear(const Vec3& p) const;
  void borrow(Range all, Scratch& scratch);

  Vec3 gravity_;
  Real h_;
  Boundary& boundary_;
  Real dt_ = 0;
  T most_ = 0;  // square of half of what gravity displaces, m²
  std::function<Real(std::size_t)> held_;
  Borrowed<T> flies_;  // share of its lift that each particle gets; empty where none flies
};

extern template class FreeFlight<float>;
extern template class FreeFlight<double>;

}  // namespace trevi

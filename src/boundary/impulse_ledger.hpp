// The impulse that the box and the obstacles receive from the water: sums of the displacements, m, and of their
// moments, m², that they give to particles. Sums are integers, multiples of a length far below the rounding of
// positions, so that they depend neither on the order of the particles nor on the number of ranks or threads. add() may
// be called in loops that threads share. Collective: total().
#pragma once

#include <span>
#include <vector>

#include "base/threads.hpp"
#include "trevi/session.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// The sum over all particles.
struct TotalImpulse {
  Vec3 shift = Vec3::Zero();   ///< m
  Vec3 moment = Vec3::Zero();  ///< m², about the reference point of the account

  TotalImpulse& operator+=(const TotalImpulse& other) {
    shift += other.shift;
    moment += other.moment;
    return *this;
  }
  TotalImpulse& operator-=(const TotalImpulse& other) {
    shift -= other.shift;
    moment -= other.moment;
    return *this;
  }
};

/// What an obstacle or the box gives to a particle.
struct Impulse {
  Vec3 shift;  ///< m
  Vec3 arm;    ///< m, from the reference point of moments to the particle
};

class ImpulseLedger {
 public:
  ImpulseLedger(std::size_t accounts, Real h);
  void add(std::size_t account, std::span<const Impulse> impulses);
  void add(std::size_t account, const TotalImpulse& impulse);
  /// In the order of the accounts, since clear().
  std::vector<TotalImpulse> total(MPI_Comm comm);
  void clear();

 private:
  static constexpr std::size_t numbers = 6;  // per account
  void count(const Vec3& shift, const Vec3& moment, std::int64_t* sums) const;

  std::size_t columns_;
  Real unit_, arm_;              // m
  Real per_shift_, per_moment_;  // units, 1/m and 1/m²
  PerThread<std::vector<std::int64_t>> sums_;
};

}  // namespace trevi

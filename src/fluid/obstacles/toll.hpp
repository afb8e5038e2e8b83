// What the box and the obstacles take of the water's momentum: sums of displacements, m, and of their moments, m², that
// they give to particles. Sums are integers, multiples of a length far below rounding of the positions' own, so that no
// order of the particles, and no number of ranks or threads, is seen in them. add() may be called in loops that threads
// share. Collective: total().
#pragma once

#include <vector>

#include "base/threads.hpp"
#include "trevi/session.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// Of all particles together.
struct Taken {
  Vec3 shift = Vec3::Zero();   ///< m
  Vec3 moment = Vec3::Zero();  ///< m², about a point of the taker's choice
};

class Toll {
 public:
  Toll(std::size_t takers, Real h);
  void add(std::size_t taker, const Vec3& shift, const Vec3& arm);
  /// In the order of the takers, since clear().
  std::vector<Taken> total(MPI_Comm comm);
  void clear();

 private:
  std::size_t columns_;
  Real unit_, arm_;  // m
  PerThread<std::vector<std::int64_t>> sums_;
};

}  // namespace trevi

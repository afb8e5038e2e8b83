// Which particles are worth drawing. A particle is taken to be hidden when its cell and all 26 cells around it contain
// water: it is then at least a cell (h) below the surface of the water. Cells beyond the box count as empty, because
// one looks through the walls. The others are thinned to a budget: at level k every 2^k-th particle is drawn, chosen by
// a hash of its id, so that the choice is the same in each frame, and a higher level only leaves out more. Invariant:
// the same on any rank count once the marks of all ranks are merged. Rank-local, no communication.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "trevi/box.hpp"

namespace trevi {

class VisibleCells {
 public:
  /// Cells of `size` m, or larger if the box would have more than two million of them.
  VisibleCells(const Box& box, Real size);

  void mark(const Vec3& p);
  /// 1 where a cell contains water: to be merged over ranks by a bitwise or.
  std::span<std::uint8_t> marks() { return marks_; }
  /// To be called when all particles have been marked and the marks merged.
  void find_hidden();
  bool hidden(const Vec3& p) const { return hidden_[cell_of(p)] != 0; }

 private:
  std::size_t cell_of(const Vec3& p) const;

  Vec3 min_;
  Real per_metre_;
  std::array<std::ptrdiff_t, 3> count_;  // x fastest
  std::vector<std::uint8_t> marks_, hidden_;
};

/// The lowest level that leaves at most about `budget` of `count` particles.
int thinning_level(std::int64_t count, std::int64_t budget);

/// Whether a particle is drawn at a level.
bool drawn_at(GlobalId id, int level);

}  // namespace trevi

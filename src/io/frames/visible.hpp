// Which particles are worth drawing. A particle is taken to be hidden when its cell and all 26 cells around it hold
// water: it then lies at least a cell (h) below the surface of the water. Cells beyond the box count as empty, as one
// looks through the walls. What is left is thinned to a budget: of level k every 2^k-th particle is drawn, chosen by a
// hash of its id, so the choice is the same in each frame, and a higher level only leaves out more.
// Invariant: the same on any rank count once the marks of all ranks are merged. Rank-local, no communication.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "trevi/box.hpp"

namespace trevi {

class VisibleCells {
 public:
  /// Cells of `size` m, or larger where the box would have more than two million of them.
  VisibleCells(const Box& box, Real size);

  void mark(const Vec3& p);
  /// 1 where a cell holds water: to be merged over ranks by a bitwise or.
  std::span<std::uint8_t> marks() { return marks_; }
  /// Once all is marked and merged.
  void find_hidden();
  bool hidden(const Vec3& p) const { return hidden_[cell_of(p)] != 0; }

 private:
  std::size_t cell_of(const Vec3& p) const;

  Vec3 min_;
  Real per_metre_;
  std::array<std::ptrdiff_t, 3> count_;  // x fastest
  std::vector<std::uint8_t> marks_, hidden_;
};

/// The lowest level that leaves at most `budget` of `count` particles, about.
int thinning_level(std::int64_t count, std::int64_t budget);

/// Whether a particle is drawn at a level.
bool drawn_at(GlobalId id, int level);

}  // namespace trevi

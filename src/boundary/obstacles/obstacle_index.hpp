// Which obstacles are relevant at a position: a grid of cells with one bit for each obstacle whose reach, where it is
// in the substep, comes within a cell of them. Most positions have none and need no further tests; among many bodies
// the few near a position are found at once. Bits may be set unnecessarily but are never missing, so that the result is
// the same as if all obstacles had been examined. Not collective.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "boundary/obstacles/body.hpp"

namespace trevi {

class ObstacleIndex {
 public:
  using Bits = std::uint64_t;

  ObstacleIndex(const Box& box, Real h, const std::vector<std::unique_ptr<Body>>& bodies);

  /// To be called when bodies have moved. Outside of loops that threads share.
  void update();
  /// Changes whenever the bits change.
  std::uint64_t version() const { return version_; }
  /// Bits of the obstacles that reach p, or that a path from p of at most longest_path() along each axis may approach.
  Bits at(const Vec3& p) const { return cells_[cell_of(p)] | everywhere_; }
  Real longest_path() const { return edge_; }
  /// Bits of those that come closer than that to a box; of all if the box covers many cells.
  Bits in(const Box& box) const;
  static bool is_path_short(const Vec3& from, const Vec3& to, Real longest) {
    return ((to - from).array().abs() <= longest).all();
  }
  Bits all() const { return ~Bits{0}; }
  /// Whether test(k) holds for one of the obstacles whose bits are set. It may also be called for others; in their
  /// order.
  template <class Test>
  bool any(Bits bits, const Test& test) const {
    const std::size_t count = bodies_.size();
    if (count > width) {
      for (std::size_t k = 0; k < count; ++k)
        if ((bits >> (k % width) & 1U) != 0 && test(k)) return true;
      return false;
    }
    for (bits &= ~Bits{0} >> (width - count); bits != 0; bits &= bits - 1)
      if (test(static_cast<std::size_t>(std::countr_zero(bits)))) return true;
    return false;
  }
  template <class Visit>
  void for_each(Bits bits, const Visit& visit) const {
    any(bits, [&](std::size_t k) {
      visit(k);
      return false;
    });
  }
  std::size_t bytes() const { return (cells_.capacity() + standing_.capacity()) * sizeof(Bits); }

 private:
  static constexpr std::size_t width = 64;
  struct Block {
    std::array<std::size_t, 3> low{}, high{};
    bool operator==(const Block&) const = default;
  };
  Block block_of(const Box& box) const;
  static Bits bit_of(std::size_t k) { return Bits{1} << (k % width); }
  std::size_t along(Real x, Eigen::Index a) const {
    const Real cells = (x - low_[a]) * per_edge_, last = last_[a];
    const Real within = cells > 0 ? (cells < last ? cells : last) : 0;  // also if it is not a number
    return static_cast<std::size_t>(static_cast<std::int64_t>(within));
  }
  std::size_t cell_of(const Vec3& p) const {
    return (along(p.x(), 0) * count_[1] + along(p.y(), 1)) * count_[2] + along(p.z(), 2);
  }
  // The cells in which it is marked.
  Block block_of(const Body& body) const;
  template <class Visit>
  void for_each_cell(const Block& block, const Visit& visit) const;

  const std::vector<std::unique_ptr<Body>>& bodies_;
  Vec3 low_, last_;  // last_: the number of the last cell along each axis
  Real edge_, per_edge_;
  std::array<std::size_t, 3> count_{};
  Bits everywhere_ = 0, always_ = 0;    // always_: of those that do not move
  std::vector<Bits> standing_, cells_;  // of those that do not move, and of all
  std::vector<std::size_t> moving_;
  struct Marked {
    std::size_t body;
    Block block;
    bool operator==(const Marked&) const = default;
  };
  std::vector<Marked> marked_;  // those that move
  std::uint64_t version_ = 0;
};

}  // namespace trevi

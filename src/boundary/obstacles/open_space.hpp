// Where some particles cannot be affected by obstacles: a box around them, minus what nearby obstacles may reach, each
// enclosed in the intersection of a box and a ball. It may be too small but never too large, so that examining the
// other particles one by one gives the same result as examining all of them. Not collective, on this thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "trevi/box.hpp"

namespace trevi {

/// All of space by default.
struct Ball {
  Vec3 center = Vec3::Zero();
  Real radius = INFINITY;
};

/// The intersection of a box and a ball.
struct ClosedPart {
  Box box;
  Ball ball;
};

class OpenSpace {
 public:
  OpenSpace() = default;  ///< no place at all
  explicit OpenSpace(const Box& box) : box_(box) {}

  /// Removes `part`, which must stay in place as long as this object is used. If there are more than a few of them, the
  /// others are merged into one.
  void close(const ClosedPart& part) {
    const Box& closed = part.box;
    if (!box_.meets(closed)) return;
    lowest_ = std::min(lowest_, closed.min.z());
    if (count_ < closed_.size()) {
      closed_[count_++] = &part;
    } else if (!has_rest_) {
      rest_.box = closed;
      has_rest_ = true;
    } else {
      rest_.box = {rest_.box.min.cwiseMin(closed.min), rest_.box.max.cwiseMax(closed.max)};
    }
  }
  /// Removes what is outside of a box.
  void confine(const Box& box) { box_ = {box_.min.cwiseMax(box.min), box_.max.cwiseMin(box.max)}; }

  /// Which obstacles come near to it, as bits of an index; all of them if this was not set.
  void set_near(std::uint64_t near) { near_ = near; }
  std::uint64_t near() const { return near_; }

  /// Whether a straight path is in it, judged by the box around the path; false for a NaN.
  bool contains(const Vec3& from, const Vec3& to) const {
    return box_.contains(from) && box_.contains(to) && !closes(from, to);
  }
  bool contains(const Vec3& p) const { return box_.contains(p) && !closes(p, p); }
  /// Whether the box around a path extends into a removed part.
  bool closes(const Vec3& from, const Vec3& to) const {
    const Vec3 low = from.cwiseMin(to), high = from.cwiseMax(to);
    for (std::size_t k = 0; k < closed_parts(); ++k) {
      const auto& [box, ball] = closed(k);
      if (!(high.array() >= box.min.array()).all() || !(low.array() <= box.max.array()).all()) continue;
      const Vec3 gap = (ball.center - high).cwiseMax(low - ball.center).cwiseMax(0.0);
      const Real in_plane = gap.x() * gap.x() + gap.y() * gap.y();
      if (in_plane + gap.z() * gap.z() <= ball.radius * ball.radius) return true;
    }
    return false;
  }

  /// A box and a few parts of it, for loops over vectors.
  const Box& box() const { return box_; }
  std::size_t closed_parts() const { return count_ + (has_rest_ ? 1 : 0); }
  const ClosedPart& closed(std::size_t k) const { return k < count_ ? *closed_[k] : rest_; }
  Real lowest_closed() const { return lowest_; }  ///< height below which there is none of them

 private:
  Box box_{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  std::array<const ClosedPart*, 8> closed_;
  std::size_t count_ = 0;
  ClosedPart rest_;
  bool has_rest_ = false;
  Real lowest_ = INFINITY;
  std::uint64_t near_ = ~std::uint64_t{0};
};

/// The box around every `each`-th of the positions, from the first on, and the last.
Box box_around(std::span<const Vec3> p, std::size_t each);

/// The number of a position, and whether it is outside of a space.
struct OutsideOf {
  LocalId which;
  bool space;
};

/// Writes which of the positions are outside of a space, in their order, and returns how many; `found` has room for
/// all. A NaN is not outside.
std::size_t find_outside(const OpenSpace& open, std::span<const Vec3> p, LocalId* found);

/// Writes which of the positions are outside of a space or of a box, in their order, and for each whether it is outside
/// of the space; returns how many.
std::size_t find_outside(const OpenSpace& open, const Box& box, std::span<const Vec3> p, OutsideOf* found);

/// Positions with as many velocities, and a time, s.
struct Straight {
  std::span<const Vec3> p, v;
  Real dt;
};
/// Writes the ends of straight paths, and which of them are not in the open space, in their order; returns how many;
/// `found` has room for all.
std::size_t go_straight(const OpenSpace& open, const Straight& way, Vec3* end, LocalId* found);

}  // namespace trevi

// Where some particles have nothing to do with obstacles: a box around them less what the obstacles beside it may
// reach, each in a box and in a ball. Says too little rather than too much, so that whoever asks for the rest of the
// particles one by one finds what asking for all would have found. Not collective, on this thread.
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

/// What is in a box and in a ball.
struct ClosedPart {
  Box box;
  Ball ball;
};

class OpenSpace {
 public:
  OpenSpace() = default;  ///< no place at all
  explicit OpenSpace(const Box& box) : box_(box) {}

  /// Takes away what is in `closed`. More of these than are kept apart are taken together.
  void close(const Box& closed, const Ball& ball = {}) {
    if ((closed.max.array() < box_.min.array()).any() || (closed.min.array() > box_.max.array()).any()) return;
    lowest_ = std::min(lowest_, closed.min.z());
    if (count_ < closed_.size()) {
      closed_[count_++] = {closed, ball};
      return;
    }
    ClosedPart& last = closed_.back();
    last = {{last.box.min.cwiseMin(closed.min), last.box.max.cwiseMax(closed.max)}, {}};
  }
  /// Takes away what is outside of a box.
  void confine(const Box& box) { box_ = {box_.min.cwiseMax(box.min), box_.max.cwiseMin(box.max)}; }

  /// Which obstacles come near to it, as an index of them has it; all where nobody has told.
  void set_near(std::uint64_t near) { near_ = near; }
  std::uint64_t near() const { return near_; }

  /// Whether a straight path is in it, by the box around that; false for a NaN.
  bool contains(const Vec3& from, const Vec3& to) const {
    return box_.contains(from) && box_.contains(to) && !closes(from, to);
  }
  bool contains(const Vec3& p) const { return box_.contains(p) && !closes(p, p); }
  /// Whether the box around a path comes into what is taken away.
  bool closes(const Vec3& from, const Vec3& to) const {
    const Vec3 low = from.cwiseMin(to), high = from.cwiseMax(to);
    return std::any_of(closed().begin(), closed().end(), [&](const ClosedPart& one) {
      if (!(high.array() >= one.box.min.array()).all() || !(low.array() <= one.box.max.array()).all()) return false;
      const Vec3 gap = (one.ball.center - high).cwiseMax(low - one.ball.center).cwiseMax(0.0);
      return gap.squaredNorm() <= one.ball.radius * one.ball.radius;
    });
  }

  /// Of a box and a few parts of it, for loops in vectors.
  const Box& box() const { return box_; }
  std::span<const ClosedPart> closed() const { return {closed_.data(), count_}; }
  Real lowest_closed() const { return lowest_; }  ///< height below which none of these is

 private:
  Box box_{Vec3::Constant(INFINITY), Vec3::Constant(-INFINITY)};
  std::array<ClosedPart, 8> closed_;
  std::size_t count_ = 0;
  Real lowest_ = INFINITY;
  std::uint64_t near_ = ~std::uint64_t{0};
};

/// Around every so many of the positions, from the first on, and the last.
Box box_around(std::span<const Vec3> p, std::size_t each);

/// The number of a position, and whether it is outside of a space.
struct OutsideOf {
  LocalId which;
  bool space;
};

/// Writes which of the positions are outside of a space, in their order, and returns how many; `found` has room for
/// all. A NaN is not outside.
std::size_t find_outside(const OpenSpace& open, std::span<const Vec3> p, LocalId* found);

/// Writes which of the positions are outside of a space or of a box, in their order, and of each whether it is outside
/// of the space; returns how many.
std::size_t find_outside(const OpenSpace& open, const Box& box, std::span<const Vec3> p, OutsideOf* found);

/// From positions with as many velocities, for a time, s.
struct Straight {
  std::span<const Vec3> p, v;
  Real dt;
};
/// Writes where straight paths end, and which of them are not in the open, in their order; returns how many; `found`
/// has room for all.
std::size_t go_straight(const OpenSpace& open, const Straight& way, Vec3* end, LocalId* found);

}  // namespace trevi

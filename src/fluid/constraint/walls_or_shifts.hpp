// What the pair loops of the density constraint pass to one another: for each particle first the gradient of what walls
// and obstacles contribute to its density, then its shift. **Both use the same memory**, four numbers per particle: the
// loop that finds a shift reads the gradient and writes the shift in its place, and a caller that asks for one of them
// must know that it is the one stored. Not collective; different particles may be written by different threads.
#pragma once

#include <algorithm>
#include <span>

#include "base/range.hpp"
#include "base/scratch.hpp"
#include "particles/packed.hpp"

namespace trevi {

/// Contributions to the density of a particle other than those of particles.
enum class Wall { none, box, obstacle };

template <class T>
class WallsOrShifts {
 public:
  /// Memory for this many particles, which holds nothing yet.
  void borrow(Scratch& scratch, std::size_t particles) { memory_ = scratch.borrow<Vec4<T>>(particles); }
  void give_back() { memory_.give_back(); }
  std::size_t size() const { return memory_.size(); }
  /// The data of the particles of a range, to be prefetched.
  std::span<const Vec4<T>> memory(Range range) const {
    return {memory_.data() + range.begin, static_cast<std::size_t>(range.size())};
  }

  /// Sets no wall near the particles of the range, or no shift of them.
  void clear(Range range) { std::fill(memory_.begin() + range.begin, memory_.begin() + range.end, Vec4<T>{}); }

  // ---- while it holds gradients

  /// `gradient` in 1/m.
  void set_wall(std::size_t i, const Vec3& gradient, Wall wall) {
    memory_[i] = {static_cast<T>(gradient.x()), static_cast<T>(gradient.y()), static_cast<T>(gradient.z()),
                  static_cast<T>(static_cast<int>(wall))};
  }
  bool has_wall(std::size_t i) const { return memory_[i].w != 0; }
  Wall wall(std::size_t i) const { return static_cast<Wall>(static_cast<int>(memory_[i].w)); }
  Vec3 gradient(std::size_t i) const { return vector_of(memory_[i]); }
  /// From here on this is the shift of the particle, m: factor · sum + multiplier · gradient; 0 without a sign.
  void make_shift(std::size_t i, const Vec4<T>& sum, T factor, T multiplier) {
    Vec4<T>& out = memory_[i];
    out = {sum.x * factor + multiplier * out.x + T{0}, sum.y * factor + multiplier * out.y + T{0},
           sum.z * factor + multiplier * out.z + T{0}, 0};
  }

  // ---- while it holds shifts, m

  /// The fourth numbers are free; the projection stores in them how far the grid acts.
  std::span<Vec4<T>> shifts() { return {memory_.data(), memory_.size()}; }
  Vec3 shift(std::size_t i) const { return vector_of(memory_[i]); }
  void add_to_shift(std::size_t i, const Vec3& more) {
    memory_[i].x += static_cast<T>(more.x());
    memory_[i].y += static_cast<T>(more.y());
    memory_[i].z += static_cast<T>(more.z());
  }

 private:
  Borrowed<Vec4<T>> memory_;
};

}  // namespace trevi

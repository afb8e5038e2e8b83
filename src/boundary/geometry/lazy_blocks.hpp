// A grid of blocks that are made when they are first asked for, by whichever thread asks: only what the water of this
// rank approaches is computed and takes memory. A block is a pure function of its place, so it does not matter who
// makes it, nor whether two threads do so at the same time (the second copy is discarded). Not collective.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

using BlockPlace = std::array<std::int32_t, 3>;

/// The place of a point in a grid of blocks with this edge, m.
inline BlockPlace block_place(const Vec3& p, Real edge) {
  return {static_cast<std::int32_t>(std::floor(p.x() / edge)), static_cast<std::int32_t>(std::floor(p.y() / edge)),
          static_cast<std::int32_t>(std::floor(p.z() / edge))};
}
inline BlockPlace shifted_place(const BlockPlace& place, std::int32_t by) {
  return {place[0] + by, place[1] + by, place[2] + by};
}
inline Vec3 corner_of(const BlockPlace& place, Real edge) { return edge * Vec3(place[0], place[1], place[2]); }
/// Half the diagonal of a cube, in units of its edge, rounded up.
constexpr Real half_diagonal = 0.8661;

template <class Block>
class LazyBlocks {
 public:
  /// Blocks at places from `low` to below `high`.
  LazyBlocks(const BlockPlace& low, const BlockPlace& high) : low_(low) {
    std::size_t all = 1;
    for (std::size_t a = 0; a < 3; ++a) all *= bricks_[a] = static_cast<std::size_t>((high[a] - low[a]) / edge + 1);
    top_ = std::vector<std::atomic<Brick*>>(all);
    for (auto& brick : top_) brick.store(nullptr, std::memory_order_relaxed);
  }
  ~LazyBlocks() {
    for (auto& brick : top_) delete brick.load();
  }
  LazyBlocks(const LazyBlocks&) = delete;
  LazyBlocks& operator=(const LazyBlocks&) = delete;

  /// make() returns the block as a unique_ptr.
  template <class Make>
  const Block& at(const BlockPlace& place, const Make& make) const {
    std::size_t top = 0, within = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const auto k = static_cast<std::size_t>(place[a] - low_[a]);
      top = top * bricks_[a] + k / edge;
      within = within * edge + k % edge;
    }
    Brick* brick = top_[top].load(std::memory_order_acquire);
    if (brick == nullptr) brick = install(top_[top], std::make_unique<Brick>());
    std::atomic<Block*>& slot = brick->block[within];
    const Block* block = slot.load(std::memory_order_acquire);
    return block != nullptr ? *block : *install(slot, make());
  }

  std::size_t bytes() const { return bytes_.load(std::memory_order_relaxed) + top_.size() * sizeof(top_[0]); }

  /// Blocks per brick in each direction; a brick that has not been made takes one pointer.
  static constexpr std::int32_t edge = 8;

 private:
  struct Brick {
    std::array<std::atomic<Block*>, edge * edge * edge> block{};
    ~Brick() {
      for (auto& one : block) delete one.load();
    }
  };
  template <class T>
  T* install(std::atomic<T*>& slot, std::unique_ptr<T> made) const {
    T* expected = nullptr;
    if (!slot.compare_exchange_strong(expected, made.get(), std::memory_order_acq_rel)) return expected;
    bytes_.fetch_add(sizeof(T), std::memory_order_relaxed);
    return made.release();
  }

  BlockPlace low_;
  std::array<std::size_t, 3> bricks_{};
  mutable std::vector<std::atomic<Brick*>> top_;
  mutable std::atomic<std::size_t> bytes_ = 0;
};

}  // namespace trevi

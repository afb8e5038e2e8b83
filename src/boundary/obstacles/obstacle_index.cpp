#include "boundary/obstacles/obstacle_index.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace trevi {

ObstacleIndex::ObstacleIndex(const Box& box, Real h, const std::vector<std::unique_ptr<Body>>& bodies)
    : bodies_(bodies), low_(box.min), edge_(h) {
  constexpr Real most = 1U << 18U;
  const Vec3 extent = box.max - box.min;
  while ((extent.array() / edge_).ceil().max(1.0).prod() > most) edge_ *= 2;
  per_edge_ = 1 / edge_;
  std::size_t all = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const Real count = std::max(std::ceil(extent[static_cast<Eigen::Index>(a)] / edge_), 1.0);
    all *= count_[a] = static_cast<std::size_t>(count);
    last_[static_cast<Eigen::Index>(a)] = count - 1;
  }
  standing_.assign(all, 0);
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    if (bodies_[k]->moves()) {
      moving_.push_back(k);
    } else if (!bodies_[k]->has_bounds(edge_)) {
      always_ |= bit_of(k);
    } else {
      for_each_cell(block_of(*bodies_[k]), [&](std::size_t cell) { standing_[cell] |= bit_of(k); });
    }
  }
  cells_ = standing_;
  everywhere_ = always_;
  update();
}

// Visits the cells of a block by their numbers.
template <class Visit>
void ObstacleIndex::for_each_cell(const Block& block, const Visit& visit) const {
  for (std::size_t x = block.low[0]; x <= block.high[0]; ++x) {
    for (std::size_t y = block.low[1]; y <= block.high[1]; ++y) {
      for (std::size_t z = block.low[2]; z <= block.high[2]; ++z) visit((x * count_[1] + y) * count_[2] + z);
    }
  }
}

ObstacleIndex::Block ObstacleIndex::block_of(const Body& body) const {
  const Vec3 margin = Vec3::Constant(edge_);
  return block_of(Box{body.reach().min - margin, body.reach().max + margin});
}

ObstacleIndex::Block ObstacleIndex::block_of(const Box& box) const {
  Block block;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    block.low[a] = along(box.min[b], b);
    block.high[a] = along(box.max[b], b);
  }
  return block;
}

ObstacleIndex::Bits ObstacleIndex::in(const Box& box) const {
  constexpr std::size_t few = 512;
  const Block block = block_of(box);
  std::size_t cells = 1;
  for (std::size_t a = 0; a < 3; ++a) cells *= block.high[a] - block.low[a] + 1;
  if (cells > few) return all();
  Bits found = everywhere_;
  const std::size_t columns = block.high[2] - block.low[2] + 1;
  for (std::size_t x = block.low[0]; x <= block.high[0]; ++x) {
    for (std::size_t y = block.low[1]; y <= block.high[1]; ++y) {
      const Bits* const column = &cells_[(x * count_[1] + y) * count_[2] + block.low[2]];
      for (std::size_t z = 0; z < columns; ++z) found |= column[z];
    }
  }
  return found;
}

// Most bodies move less than a cell in a substep.
void ObstacleIndex::update() {
  std::vector<Marked> now;
  Bits everywhere = always_;
  for (const std::size_t k : moving_) {
    if (bodies_[k]->has_bounds(edge_)) {
      now.push_back({k, block_of(*bodies_[k])});
    } else {
      everywhere |= bit_of(k);
    }
  }
  if (now == marked_ && everywhere == everywhere_) return;
  ++version_;
  for (const Marked& one : marked_) for_each_cell(one.block, [&](std::size_t cell) { cells_[cell] = standing_[cell]; });
  marked_ = std::move(now);
  everywhere_ = everywhere;
  for (const Marked& one : marked_)
    for_each_cell(one.block, [&](std::size_t cell) { cells_[cell] |= bit_of(one.body); });
}

}  // namespace trevi

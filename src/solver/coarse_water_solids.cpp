// The surface of the water among obstacles: the same rules as without (coarse_water.cpp), for the open part of each
// cell. A solid cell counts as wet where the cell below it is: water under it has no surface. What a cell holds of
// which little is open says hardly anything, so it follows the cell beyond its widest face.
#include "solver/coarse_water.hpp"

#include "base/threads.hpp"

namespace trevi {

namespace {

constexpr Real small_cell = 0.5;  // open share of a cell that follows another one

}  // namespace

void CoarseWater::fill_open_parts() {
  for_each_part({0, grid_.planes() + 2}, 1, [&](Range k) {
    const std::size_t begin = static_cast<std::size_t>(k.begin) * grid_.step(0);
    for (std::size_t at = begin; at < begin + grid_.step(0); ++at) {
      const Real open = solids_->open(at);
      fill_[at] = open > 0 ? fill_[at] / open : 1;
    }
  });
}

void CoarseWater::find_surface_among_solids(Halo& halo) {
  const Range all{0, grid_.planes() + 2}, own{1, grid_.planes() + 1};
  fill_open_parts();
  for_each_row(grid_.rows_of(all), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid_.columns(); ++c) {
      const std::size_t at = grid_.index(k, r, c);
      wet_[at] = !is_solid(at) && is_full_enough(at, c, c == 0 || solids_->face(2, at) == 0) ? 1 : 0;
    }
  });
  grid_.repeat(wet_);
  std::vector<char> joined = wet_;
  for_each_row(grid_.rows_of(own), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid_.columns(); ++c) {
      const std::size_t at = grid_.index(k, r, c);
      if (is_small(at) && !is_wet(at)) joined[at] = wet_[widest_neighbour(at)];
    }
  });
  halo.start_planes(joined, grid_.step(0));
  halo.finish();
  wet_.swap(joined);
  for_each_row(grid_.rows_of(all), [&](LocalId k, LocalId r) {
    for (LocalId c = 1; c < grid_.columns(); ++c) {
      const std::size_t at = grid_.index(k, r, c);
      if (is_solid(at)) wet_[at] = wet_[at - 1];
    }
    close_ceiling(k, r);
    find_tops(k, r);
  });
  grid_.repeat(wet_);
  grid_.repeat(height_);
  level_small_cells(halo);
}

// The surface in a small cell is that beside it.
void CoarseWater::level_small_cells(Halo& halo) {
  std::vector<Real> level = height_;
  for_each_row(grid_.rows_of({1, grid_.planes() + 1}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid_.columns(); ++c) {
      const std::size_t at = grid_.index(k, r, c);
      if (!is_small(at) || !is_top(at)) continue;
      const std::size_t beside = widest_neighbour(at);
      if (beside != at + 1 && beside != at - 1 && is_wet(beside)) level[at] = is_top(beside) ? height_[beside] : 1;
    }
  });
  halo.start_planes(level, grid_.step(0));
  halo.finish();
  grid_.repeat(level);
  height_.swap(level);
}

bool CoarseWater::is_small(std::size_t at) const { return solids_->open(at) > 0 && solids_->open(at) < small_cell; }

// The first of the six with the widest face.
std::size_t CoarseWater::widest_neighbour(std::size_t at) const {
  std::size_t beside = at;
  Real widest = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t step = grid_.step(a);
    const Real low = solids_->face(a, at), high = solids_->face(a, at + step);
    if (low > widest) beside = at - step;
    widest = std::max(widest, low);
    if (high > widest) beside = at + step;
    widest = std::max(widest, high);
  }
  return beside;
}

}  // namespace trevi

#include "projection/free_surface.hpp"

#include <algorithm>
#include <cmath>

#include "base/threads.hpp"

namespace trevi {

using namespace projection;

void FreeSurface::borrow() {
  Scratch& scratch = grid().scratch();
  wet_ = scratch.borrow<char>(grid().cells());
  wet_.fill(0);
  fill_ = scratch.borrow_briefly<Real>(grid().cells());
  fill_.fill(0);
  height_ = scratch.borrow_briefly<Real>(grid().cells());
  height_.fill(1);
  mass_ = scratch.borrow_briefly<Real>(grid().cells());
  mass_.fill(1);
}

void FreeSurface::keep_wet() {
  height_.give_back();
  mass_.give_back();
  enclosed_.give_back();
}

Real FreeSurface::resistance_to_air(std::size_t a, std::size_t wet, std::size_t dry) const {
  if (!upright()) return mass_[wet];
  if (a == 2) return mass_[wet] * (wet < dry ? above_middle(wet) : 1);
  if (is_cut(wet)) return mass_[wet] * part_down_slope(a, wet, dry);
  if (is_cut(dry) || is_emptied(dry)) return mass_[wet];
  return is_top(dry - 1) ? mass_[wet] * part_in_water(wet, dry) : weight_at_side(a, wet, dry);
}

// The fraction of the distance from the centre of a wet cell to that of a dry one beside it that lies in water, where
// the surface steps down by a cell between them. The levels of cut cells are too uneven for a slope to follow from
// them.
Real FreeSurface::part_in_water(std::size_t wet, std::size_t dry) const {
  if (is_solid(wet) || is_cut(dry - 1)) return 1;
  const Real in = is_top(wet) ? above_middle(wet) : 1 + above_middle(wet + 1);
  return in / std::max(in + 1.5 - height_[dry - 1], min_rise);
}

// The fraction of the distance from the centre of a wet cell on a slope to that of a dry one beside it, down the slope,
// up to the surface, where the surface is as steep as the slope: the pressure of a sheet acts along the normal of the
// solid. Where the surface is less steep, water lies against the slope, as in a vessel. The fall of the slope across
// the cell follows from the open parts of the face to the dry cell, of the cell and of its floor: the face on the other
// side may be beyond the ghost cells.
Real FreeSurface::part_down_slope(std::size_t a, std::size_t wet, std::size_t dry) const {
  if (!is_top(wet) || cuts()->floats(wet) || is_emptied(dry)) return 1;
  const Real up = cuts()->face(2, wet + 1) - cuts()->face(2, wet), side = cuts()->face(a, std::max(wet, dry));
  if (up <= 0 || side <= open(wet)) return 1;
  const Real down = std::min(2 * (side - open(wet)) / up, side), above = above_middle(wet);
  const bool falls_less = is_top(dry - 1) && (above + 1.5 - height_[dry - 1]) * up < down;
  return falls_less ? 1 : std::clamp(above * up / down, min_height, 1.0);
}

// The weight at this face of the particles of the wet cell, which are displaced, over that in full water: a particle
// counts 1 in the plane of the face and 0 a cell away.
Real FreeSurface::weight_at_side(std::size_t a, std::size_t wet, std::size_t dry) const {
  const ParticlesToGrid::Means held = water().means(wet);
  const Real from_low = held.y[grid().axis(a)], weight = wet > dry ? held.n - from_low : from_low;
  return std::clamp(weight * water().frame().per_full, min_side, 1.0);
}

void FreeSurface::classify(Halo& halo) {
  for_each_row(grid().rows_of({1, grid().planes() + 1}), [&](LocalId k, LocalId r) {
    water().find_volumes(k, r, {&fill_[grid().index(k, r, 0)], static_cast<std::size_t>(grid().columns(k, r))});
  });
  if (cuts() != nullptr) fill_open_parts();
  halo.start_planes(fill_, grid().step(0));
  halo.finish();
  const bool inflow = openings_ != nullptr && openings_->has_sources();
  // Cells at solids depend on their neighbours, and water that comes out of an opening on the cell behind it.
  if (inflow || cuts() != nullptr) grid().complete(halo, fill_);
  classify_cells(halo);
  if (cuts() == nullptr) {
    enclosed_.find_whole(*this, halo);
    if (enclosed_.any() && openings_ != nullptr) fill_crossed();
  }
  find_masses(halo);
  if (openings_ != nullptr) openings_->close_sides(grid(), wet_);
}

// Cells at openings in water without a surface are wet.
void FreeSurface::fill_crossed() {
  for (const std::size_t at : openings_->crossed_cells()) {
    wet_[at] = wet_cell;
    const std::array<LocalId, 3> cell = grid().cell_at(at);
    close_ceiling(cell[0], cell[1]);
  }
}

void FreeSurface::classify_cells(Halo& halo) {
  if (cuts() != nullptr) return classify_among_solids(halo);
  for_each_row(grid().rows_of({0, grid().planes() + 2}), [&](LocalId k, LocalId r) {
    const LocalId highest = grid().repeats()[2] ? grid().columns() : from_.rows.wet_columns(k, r);
    for (LocalId c = 0; c < std::min(highest, grid().columns()); ++c) {
      const std::size_t at = grid().index(k, r, c);
      wet_[at] = is_full_enough({k, r, c}, upright() && c == 0 ? floor_fill : wet_fill) ? 1 : 0;
    }
    if (grid().columns(k, r) == grid().columns()) close_ceiling(k, r);
    find_tops(k, r);
  });
  grid().complete(halo, wet_);
  grid().complete(halo, height_);
}

bool FreeSurface::is_full_enough(const Place& place, Real least) const {
  const auto [k, r, c] = place;
  const std::size_t at = grid().index(k, r, c);
  if (is_drained(at) || is_beside_water(place, at)) return false;
  if (fill_[at] >= least) return true;
  return upright() && c + 1 < grid().columns() && fill_[at] >= submerged_fill && fill_[at + 1] >= submerged_fill &&
         !is_under_lid(at);
}

// Such a cell is air: nothing determines the motion of its outer faces, and if they stood still, water that moves as a
// whole would run against them.
bool FreeSurface::is_beside_water(const Place& place, std::size_t at) const {
  return !(cuts() != nullptr && cuts()->is_near(at)) && is_reached_into(place, fill_[at]);
}

// Whether a cell has no particles, and its water, `volume` in cells, is no more than the particles on one side of it
// can contribute.
bool FreeSurface::is_reached_into(const Place& place, Real volume) const {
  return volume <= (1 + told_rounding) * water().told_from_one_side() && !water().holds_any(place.k, place.r, place.c);
}

// Water that reaches the ceiling has no surface: the cell past the last one counts as wet.
void FreeSurface::close_ceiling(LocalId k, LocalId r) {
  const std::size_t end = grid().index(k, r, grid().columns());
  if (grid().columns() == grid().count(2) && !grid().repeats()[2]) wet_[end] = wet_[end - 1];
}

void FreeSurface::find_tops(LocalId k, LocalId r) {
  if (!upright()) return;
  std::size_t base = grid().index(k, r, 0);  // what the water stands on ends below it
  const std::size_t floor = base;
  bool standing = true;
  Real excess = 0;  // volume beyond one cell each in the wet cells below the top one, in cells
  for (LocalId c = 0; c < grid().columns(k, r); ++c) {
    const std::size_t at = floor + static_cast<std::size_t>(c);
    if (!is_wet(at) || is_solid(at)) {
      standing = is_solid(at) || (standing && is_drained(at));
      base = at + 1;
      excess = 0;
    } else if (is_top(at)) {
      const bool beside_body = cuts() != nullptr && cuts()->floats(at);
      const Real area = beside_body ? open(at) : 1;  // of the base of the water
      const std::optional<Real> share = standing ? share_below(base, at) : std::nullopt;
      const Real counted = (share ? excess_of_cut : 1) * excess;
      const Real more = standing ? std::clamp(counted / area, -max_excess, max_excess) : 0;
      const Real midway = (fill_[at] + fill_[at + 1]) / share.value_or(1) + more;
      height_[at] = std::max(midway - half_rise(at, midway), floor_fill);
    } else {
      const Real off = fill_[at] - 1;
      const bool near_solid = cuts() != nullptr && cuts()->is_near(at);
      excess += open(at) * off * (near_solid ? 1 : std::clamp(2 - std::abs(off) / torn, 0.0, 1.0));
    }
  }
}

// How far the surface in a top cell, `height` above its lower face, has risen in the first half of the paths of its
// water as they would be without gravity, in cells. The pressure of the water's weight acts from where the paths begin.
// If the surface were left where it is midway, waves would lose ω² dt/4 of their amplitude a second.
Real FreeSurface::half_rise(std::size_t at, Real height) const {
  const AffineMap motion = water().fit(at);
  if (motion.weight == 0) return 0;
  const Real rise = motion.at(2, {0.5, 0.5, height}) * water().frame().per_length[2] / 2 + water().frame().by_gravity;
  const bool at_solid = is_cut(at) && !cuts()->floats(at);
  return std::clamp(rise, -max_half_rise, max_half_rise) * (at_solid ? rise_of_cut : 1);
}

// The fill of a cell beside a solid (CutCells::capacity()) is known only for owned cells.
void FreeSurface::find_masses(Halo& halo) {
  const LocalId planes = grid().planes();
  for_each_row(grid().rows_of(cuts() == nullptr ? Range{0, planes + 2} : Range{1, planes + 1}),
               [&](LocalId k, LocalId r) {
                 for (LocalId c = 0; c < grid().columns(k, r); ++c) {
                   const std::size_t at = grid().index(k, r, c);
                   if (is_wet(at)) mass_[at] = mass_of({k, r, c});
                 }
               });
  if (cuts() == nullptr) return grid().complete(halo, mass_);
  grid().exchange(halo, mass_);
}

// Water that stands on water that is not thin has a level rather than a fill. The fill of cells beside solids is noisy,
// and some of these cells are wet only because their neighbours are, whatever they hold. Full water that reaches a wall
// is stopped by the few particles ahead of it as if there were as many of them as in full water.
Real FreeSurface::mass_of(const Place& place) const {
  const std::size_t at = grid().index(place.k, place.r, place.c);
  if (grid().is_at_wall(place.k, place.r, place.c)) return 1;
  if (cuts() != nullptr && (cuts()->is_near(at) || is_at_solid(at))) return 1;
  Real fill = fill_[at];
  if (is_top(at)) {
    fill += std::max(fill_[at + 1], 0.0);
    if (is_wet(at - 1)) fill = std::max(fill, fill_[at - 1]);
  }
  const Real thin = std::clamp((thin_begins - fill) / (thin_begins - thin_full), 0.0, 1.0);
  return 1 - thin * (1 - fill);
}

}  // namespace trevi

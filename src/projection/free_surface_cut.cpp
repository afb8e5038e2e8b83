// The surface of the water among obstacles: the same rules as without (free_surface.cpp), for the open part of each
// cell. A solid cell counts as wet where the cell below it is: water under it has no surface. A cell whose lower face a
// solid closes more than its upper one counts as one on the floor: its water lies on a slope. As others such cells were
// dry at the rim of the water, where no pressure held what fell there, and shallow water in a ball never came to rest
// (2e-2 m²/s², 1e-4 so). Not at upright walls: there cells wet from a fifth on pushed the water off, and a tank made of
// an obstacle lost two thirds of each swing. What a cell holds of which little is open says hardly anything, so it
// follows the cell beyond its widest face; beside a body that floats those beyond its sides, whether it is full or not:
// a small cell above the surface that followed the one below it pressed the body aside, and shallow bodies sailed.
// Deep in the water there is no surface at a solid, though particles may be too far from it to fill a cell that it has
// just left: as long as such cells were dry, pressure fell to that of the air in them, and what moved under water felt
// 0.7 of its buoyancy less in one step and as much more in the next.
#include "projection/free_surface.hpp"

#include <algorithm>
#include <cmath>

#include "base/threads.hpp"

namespace trevi {

using namespace projection;

void FreeSurface::fill_open_parts() {
  for_each_row(grid().rows_of({1, grid().planes() + 1}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid().columns(); ++c) {
      const std::size_t at = grid().index(k, r, c);
      fill_[at] = is_solid(at) ? 1 : fill_[at] / cuts()->capacity(at);
    }
  });
}

void FreeSurface::classify_among_solids(Halo& halo) {
  const Range own{1, grid().planes() + 1}, all{0, grid().planes() + 2};
  const Real surely =
      openings_ != nullptr ? INFINITY : std::max(wet_fill, (1 + told_rounding) * water().told_from_one_side());
  for_each_row(grid().rows_of(own), [&](LocalId k, LocalId r) {
    const Range near = cuts()->columns_near_cut(k, r);
    for (LocalId c = 0; c < grid().columns(); ++c) {
      const std::size_t at = grid().index(k, r, c);
      const bool is_near = c >= near.begin && c < near.end;  // elsewhere what is full enough stands there
      const bool wet =
          is_near ? !is_solid(at) && is_full_enough({k, r, c}, min_wet_fill(at, c)) && stands_in(at, c)
                  : fill_[at] > surely || is_full_enough({k, r, c}, upright() && c == 0 ? floor_fill : wet_fill);
      wet_[at] = wet ? wet_cell : dry_cell;
    }
  });
  join_cells_at_solids(halo);
  for_each_row(grid().rows_of(all), [&](LocalId k, LocalId r) {
    for (LocalId c = 1; c < grid().columns(); ++c) {
      const std::size_t at = grid().index(k, r, c);
      if (is_solid(at)) wet_[at] = wet_[at - 1];
    }
    close_ceiling(k, r);
  });
  grid().complete(halo, wet_);
  for_each_row(grid().rows_of(own), [&](LocalId k, LocalId r) { find_tops(k, r); });
  grid().exchange(halo, height_);
  // At the walls of a cylinder of R = 10 spacings the level is that at the mean place of the water in a cut cell, but
  // acts at its middle: as it was the paraboloid was a quarter too steep.
  level_cut_cells(halo, [&](const Place& place, std::size_t at) {
    return is_small(at) || cuts()->floats(at) ? height_[at] : level_at_middle(place);
  });
  level_cut_cells(halo, [&](const Place& place, std::size_t at) {
    return !is_small(at) ? height_[at] : cuts()->floats(at) ? level_beside(place) : level_beyond_widest(place);
  });
}

// level(place, at) is the next level of a cut top cell, as the present ones say.
template <class Level>
void FreeSurface::level_cut_cells(Halo& halo, const Level& level) {
  Borrowed<Real> next = grid().scratch().borrow_briefly<Real>(height_.size());
  std::copy(height_.begin(), height_.end(), next.begin());
  for_each_row(grid().rows_of({1, grid().planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cuts()->cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid().columns()); ++c) {
      const std::size_t at = grid().index(k, r, c);
      if (is_cut(at) && is_top(at)) next[at] = level({k, r, c}, at);
    }
  });
  grid().exchange(halo, next);
  height_.swap(next);
}

void FreeSurface::join_cells_at_solids(Halo& halo) {
  const CellRows own = grid().rows_of({1, grid().planes() + 1});
  const auto for_each_near = [&](const auto& visit) {
    for_each_row(own, [&](LocalId k, LocalId r) {
      const Range near = cuts()->columns_near_cut(k, r);
      for (LocalId c = std::max(near.begin, 0); c < std::min(near.end, grid().columns()); ++c)
        visit(Place{k, r, c}, grid().index(k, r, c));
    });
  };
  for_each_near([&](const Place&, std::size_t at) {
    if (!is_wet(at) && !is_emptied(at) && is_at_solid(at)) wet_[at] = dry_at_solid;
  });
  halo.start_planes(wet_, grid().step(0));
  halo.finish();
  grid().complete(halo, wet_);
  Borrowed<char> joined = grid().scratch().borrow<char>(wet_.size());  // the next wet_
  std::copy(wet_.begin(), wet_.end(), joined.begin());
  for_each_near([&](const Place& place, std::size_t at) {
    if (wet_[at] == dry_at_solid || is_small(at)) joined[at] = joins(place) ? wet_cell : dry_cell;
  });
  halo.start_planes(joined, grid().step(0));
  halo.finish();
  std::copy(joined.begin(), joined.end(), wet_.begin());
}

// Whether a cell that is dry or small counts as wet all the same.
bool FreeSurface::joins(const Place& place) const {
  const std::size_t at = grid().index(place.k, place.r, place.c);
  if (is_emptied(at)) return false;
  if (is_pocket(place)) return true;
  if (!is_small(at)) return false;
  if (cuts()->floats(at)) {
    if (const std::optional<Real> fill = fill_beside(place)) return *fill >= wet_fill;
  } else if (is_wet(at)) {
    return true;
  }
  bool any = false;
  for_widest(place, [&](std::size_t beside) { any = any || is_wet(beside); });
  return any;
}

bool FreeSurface::is_at_solid(std::size_t at) const {
  const auto is_beside = [&](std::size_t step) { return open(at - step) < 1 || open(at + step) < 1; };
  return cuts()->closes_any(grid(), at) || is_beside(grid().step(0)) || is_beside(grid().step(1)) ||
         is_beside(grid().step(2));
}

// A cell at a solid among water that is deeper than it: no air is there, whatever the cell holds. Water stands above
// it, or above the cells beside it, and none around it is dry but such as are at the solid, too. Beside solids that do
// not float that water is two cells deep at least: what falls on a solid has air beneath it.
bool FreeSurface::is_pocket(const Place& place) const {
  const auto [k, r, c] = place;
  const std::size_t at = grid().index(k, r, c);
  const int deep_enough = cuts()->floats(at) ? 1 : 2;  // cells
  if (!upright() && is_run_into(place)) return false;
  bool deep = upright() && is_under(at, c, deep_enough, [&](std::size_t above) { return wet_[above] == dry_at_solid; });
  for (std::size_t a = 0; a < 3; ++a) {
    for (const bool upper : {false, true}) {
      if (cuts()->face(a, upper ? at + grid().step(a) : at) == 0) continue;
      if (grid().is_wall(a, k + (upper && a == 0), r + (upper && a == 1), c + (upper && a == 2))) continue;
      const std::size_t beside = upper ? at + grid().step(a) : at - grid().step(a);
      if (wet_[beside] == dry_cell) return false;
      if (deep || !is_wet(beside) || (upright() && (a == 2 || open(at) == 1))) continue;
      deep = !upright() || is_under(beside, c, deep_enough, [&](std::size_t above) { return is_cut(above); });
    }
  }
  return deep;
}

// Whether water runs into a cell without particles at a solid that moves, faster than that gives way: a gap that
// closes, which holds no more than what the particles on one side of it reach into it.
bool FreeSurface::is_run_into(const Place& place) const {
  const std::size_t at = grid().index(place.k, place.r, place.c);
  if (!cuts()->is_driven(at) || is_small(at) || water().holds_any(place.k, place.r, place.c)) return false;
  if (fill_[at] * cuts()->capacity(at) > (1 + told_rounding) * water().told_from_one_side()) return false;
  Real closing = 0;  // m, by the open parts of faces
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t below = at - grid().step(a), above = at + grid().step(a);
    if (is_wet(below)) closing += cuts()->face(a, at) * (water().displacement(a, at) - cuts()->moved(a, above));
    if (is_wet(above)) closing -= cuts()->face(a, above) * (water().displacement(a, above) - cuts()->moved(a, at));
  }
  return closing > 0;
}

// Whether the first of the cells above that one of which this does not hold is water of one or two cells, or a solid
// that lies on it. Water in the last cell reaches the ceiling.
template <class Passes>
bool FreeSurface::is_under(std::size_t at, LocalId c, int cells, const Passes& passes) const {
  while (++c < grid().columns() && !is_wet(++at) && passes(at)) {
  }
  if (c == grid().columns()) return false;
  if (is_solid(at) || !is_wet(at)) return is_solid(at);
  return cells == 1 || c + 1 == grid().columns() || is_wet(at + 1) || is_solid(at + 1);
}

// Whether a cell holds more than what the particles of the water below it reach up there.
bool FreeSurface::stands_in(std::size_t at, LocalId c) const {
  if (!upright() || c == 0 || is_solid(at - 1) || cuts()->face(2, at) == 0) return true;
  return water().height_of(fill_[at] * cuts()->capacity(at) / cuts()->capacity(at - 1)) > 0;
}

// What a cell under water and those beyond its open sides hold, of what they can.
Real FreeSurface::fill_around(std::size_t at) const {
  if (is_solid(at) || !cuts()->is_near(at)) return fill_[at];
  Real held = open(at) * fill_[at], room = open(at);
  for (std::size_t a = 0; a < 2; ++a) {
    for (const bool upper : {false, true}) {
      const std::size_t step = grid().step(a), beside = upper ? at + step : at - step;
      if (cuts()->face(a, upper ? beside : at) == 0 || !is_wet(beside) || is_top(beside)) continue;
      held += open(beside) * fill_[beside];
      room += open(beside);
    }
  }
  return held / room;
}

// Few particles tell what a cut cell holds: layers at a wall fill 0.7 of it or 1.05, and what it lacks the cells beside
// have. Its level would rise by as much less or more than the water does: a tank turned by 45° was 4 % too slow, or 3 %
// too fast where it stood elsewhere. So its fill counts over what the cells below that are cut as it is hold, of what
// they and those beside them do: compression, which those share, stays in it. None where no cell is.
std::optional<Real> FreeSurface::share_below(std::size_t floor, std::size_t top) const {
  if (cuts() == nullptr || !cuts()->is_near(top) || cuts()->floats(top) || cuts()->is_driven(top)) return std::nullopt;
  const Real capacity = cuts()->capacity(top);
  Real held = 0, around = 0;
  for (std::size_t at = floor; at < top; ++at) {
    if (!is_wet(at) || is_solid(at) || std::abs(cuts()->capacity(at) - capacity) > alike * capacity) continue;
    held += fill_[at];
    around += fill_around(at);
  }
  if (around == 0) return std::nullopt;
  return std::clamp(held / around, 1 - max_uneven, 1 + max_uneven);
}

// Continued by the slope from the cell beside that the water is nearer to.
Real FreeSurface::level_at_middle(const Place& place) const {
  const auto [k, r, c] = place;
  const std::size_t at = grid().index(k, r, c);
  Real more = 0;
  for (std::size_t a = 0; a < 2; ++a) {
    const Real aside = cuts()->aside(a, at), way = std::abs(aside);
    const bool upper = aside < 0;  // where the cell is that the water is nearer to
    const std::size_t step = grid().step(a), beside = upper ? at + step : at - step;
    if (way < min_aside || cuts()->face(a, upper ? beside : at) == 0 || is_solid(beside)) continue;
    if (grid().is_wall(a, k + (upper && a == 0), r + (upper && a == 1), c)) continue;
    Real level = 0;
    if (is_top(beside)) {
      level = height_[beside];
    } else if (is_wet(beside) && c + 1 < grid().columns() && is_top(beside + 1)) {
      level = height_[beside + 1] + 1;
    } else if (!is_wet(beside) && c > 0 && is_top(beside - 1)) {
      level = height_[beside - 1] - 1;
    } else {
      continue;
    }
    more += std::min(way / (1 - std::min(way, max_continued)), max_continued) * (height_[at] - level);
  }
  return std::max(height_[at] + std::clamp(more, -max_continued, max_continued), floor_fill);
}

// A body that floats turns, and its sides are upright but for a little: the mark falls with their slope.
Real FreeSurface::min_wet_fill(std::size_t at, LocalId c) const {
  if (!upright()) return wet_fill;
  if (c == 0) return floor_fill;
  const Real slope = std::max(cuts()->face(2, at + 1) - cuts()->face(2, at), 0.0);
  if (slope == 0) return wet_fill;
  return cuts()->floats(at) ? wet_fill + slope * (floor_fill - wet_fill) : floor_fill;
}

// The surface in a small cell is that beside it, the mean of both where two faces are equally wide.
Real FreeSurface::level_beyond_widest(const Place& place) const {
  const std::size_t at = grid().index(place.k, place.r, place.c);
  Real sum = 0, count = 0;
  for_widest(place, [&](std::size_t beside) {
    if (beside == at + 1 || beside == at - 1 || !is_wet(beside)) return;
    sum += is_top(beside) ? height_[beside] : 1;
    ++count;
  });
  return count > 0 ? sum / count : height_[at];
}

// Beside a small cell at a body that floats: what the cells beyond its sides hold, of what they can; none where all of
// them are small, too. The cell under it holds water long before the surface is as high as its own floor.
std::optional<Real> FreeSurface::fill_beside(const Place& place) const {
  Real sum = 0, weight = 0;
  for_each_side(place, [&](std::size_t beside, Real wide) {
    sum += wide * std::min(fill_[beside], 1.0);
    weight += wide;
  });
  return weight > 0 ? std::optional(sum / weight) : std::nullopt;
}

// In a small cell beside a body that floats: that of the columns beyond its sides, wherever their top cells are.
Real FreeSurface::level_beside(const Place& place) const {
  Real sum = 0, weight = 0;
  for_each_side(place, [&](std::size_t beside, Real wide) {
    const bool wet = is_wet(beside), below = !wet && place.c > 0 && is_top(beside - 1);
    if (!wet && !below) return;
    sum += wide * (below ? height_[beside - 1] - 1 : height(beside));
    weight += wide;
  });
  return weight > 0 ? std::clamp(sum / weight, min_height, 1.0) : height_[grid().index(place.k, place.r, place.c)];
}

// visit(cell, width of the open face to it) for the cells beyond the sides of a cell that are not small.
template <class Visit>
void FreeSurface::for_each_side(const Place& place, const Visit& visit) const {
  const auto [k, r, c] = place;
  const std::size_t at = grid().index(k, r, c);
  for (std::size_t a = 0; a < 2; ++a) {
    for (const bool upper : {false, true}) {
      const Real wide = cuts()->face(a, upper ? at + grid().step(a) : at);
      if (wide == 0 || grid().is_wall(a, k + (upper && a == 0), r + (upper && a == 1), c)) continue;
      const std::size_t beside = upper ? at + grid().step(a) : at - grid().step(a);
      if (!is_small(beside)) visit(beside, wide);
    }
  }
}

bool FreeSurface::is_small(std::size_t at) const {
  const Real open = cuts()->open(at);
  if (open == 0 || open >= small_cell_at_driven) return false;
  if (open < small_cell) return true;
  const Real slope = std::abs(cuts()->face(2, at + 1) - cuts()->face(2, at));
  return cuts()->is_driven(at) && open < small_cell_at_driven - slope * (small_cell_at_driven - small_cell);
}

// The cells beyond the widest faces, which are as good as equal where obstacles lie evenly to the cells.
template <class Visit>
void FreeSurface::for_widest(const Place& place, const Visit& visit) const {
  constexpr Real equal = 0.999;
  const LocalId k = place.k, r = place.r, c = place.c;
  const std::size_t at = grid().index(k, r, c);
  const auto widths = [&](std::size_t a) {
    const bool low = !grid().is_wall(a, k, r, c), high = !grid().is_wall(a, k + (a == 0), r + (a == 1), c + (a == 2));
    return std::pair(low ? cuts()->face(a, at) : 0, high ? cuts()->face(a, at + grid().step(a)) : 0);
  };
  Real widest = 0;
  for (std::size_t a = 0; a < 3; ++a) widest = std::max({widest, widths(a).first, widths(a).second});
  for (std::size_t a = 0; a < 3 && widest > 0; ++a) {
    if (widths(a).first >= equal * widest) visit(at - grid().step(a));
    if (widths(a).second >= equal * widest) visit(at + grid().step(a));
  }
}

}  // namespace trevi

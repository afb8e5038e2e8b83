// The free surface among obstacles: the same rules as without obstacles (free_surface.cpp), applied to the open part of
// each cell. A solid cell counts as wet where the cell below it is wet: water under it has no surface. A cell whose
// lower face is closed by a solid more than its upper one counts as a cell on the floor, because its water lies on a
// slope. Treated like other cells, such cells were dry at the rim of the water, where no pressure held the water that
// fell there, and shallow water in a ball never came to rest (2e-2 m²/s², now 1e-4). This does not apply at upright
// walls: there, cells that are wet from a fill of a fifth on pushed the water away, and a tank made of an obstacle lost
// two thirds of each swing. The fill of a cell with a small open part says hardly anything, so the cell follows the
// cell beyond its widest face. Beside a floating body it follows those beyond its sides, whether it is full or not: a
// small cell above the surface that followed the cell below it pressed the body aside, and shallow bodies sailed. Deep
// in the water there is no surface at a solid, although particles may be too far from it to fill a cell that it has
// just left. As long as such cells were dry, the pressure fell to that of the air in them, and a body moving under
// water lost 0.7 of its buoyancy in one step and gained as much in the next.
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
      const bool is_near = c >= near.begin && c < near.end;  // elsewhere a full enough cell has water of its own
      const bool wet =
          is_near ? !is_solid(at) && is_full_enough({k, r, c}, min_wet_fill(at, c)) && stands_in(at, c)
                  : fill_[at] > surely || is_full_enough({k, r, c}, upright() && c == 0 ? floor_fill : wet_fill);
      wet_[at] = wet ? wet_cell : dry_cell;
    }
  });
  join_cells_at_solids(halo);
  fill_vessels(halo);
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
  // At the walls of a cylinder of R = 10 spacings, the level is that at the mean position of the water in a cut cell,
  // but it acts at the centre of the cell: without the correction the paraboloid was a quarter too steep.
  level_cut_cells(halo, [&](const Place& place, std::size_t at) {
    return is_small(at) || cuts()->floats(at) ? height_[at] : level_at_middle(place);
  });
  level_cut_cells(halo, [&](const Place& place, std::size_t at) {
    return !is_small(at) ? height_[at] : cuts()->floats(at) ? level_beside(place) : level_beyond_widest(place);
  });
}

// level(place, at) is the new level of a cut top cell, computed from the present ones.
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
  Borrowed<char> joined = grid().scratch().borrow<char>(wet_.size());  // the new wet_
  std::copy(wet_.begin(), wet_.end(), joined.begin());
  for_each_near([&](const Place& place, std::size_t at) {
    if (wet_[at] == dry_at_solid || is_small(at)) joined[at] = joins(place) ? wet_cell : dry_cell;
  });
  halo.start_planes(joined, grid().step(0));
  halo.finish();
  std::copy(joined.begin(), joined.end(), wet_.begin());
}

// Small cells that are dry beside water without a surface are wet.
void FreeSurface::fill_vessels(Halo& halo) {
  grid().complete(halo, wet_);
  enclosed_.find(*this, halo);
  if (!enclosed_.any()) return;
  for (const std::size_t at : enclosed_.cells()) wet_[at] = wet_cell;
  halo.start_planes(wet_, grid().step(0));
  halo.finish();
}

// Whether a cell that is dry or small nevertheless counts as wet.
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

// Whether a solid that does not float closes a cell from above, and nothing from below: water that does not reach the
// lid has a surface. This does not apply under walls that lean over it, where cells follow those beside them.
bool FreeSurface::is_under_lid(std::size_t at) const {
  return cuts() != nullptr && is_solid(at + 1) && cuts()->face(2, at) == 1 && !cuts()->floats(at);
}

bool FreeSurface::is_at_solid(std::size_t at) const {
  const auto is_beside = [&](std::size_t step) { return open(at - step) < 1 || open(at + step) < 1; };
  return cuts()->closes_any(grid(), at) || is_beside(grid().step(0)) || is_beside(grid().step(1)) ||
         is_beside(grid().step(2));
}

// A cell at a solid among water that is deeper than the cell: it contains no air, whatever it holds. Water stands above
// it, or above its neighbours, and all dry cells around it are at the solid, too. Beside solids that do not float, that
// water is at least two cells deep: there is air beneath water that falls on a solid.
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

// Whether water moves into a cell without particles at a moving solid faster than the solid recedes. This is a closing
// gap, which holds no more than what the particles on one side of it contribute.
bool FreeSurface::is_run_into(const Place& place) const {
  const std::size_t at = grid().index(place.k, place.r, place.c);
  if (!cuts()->is_driven(at) || is_small(at) || !is_reached_into(place, fill_[at] * cuts()->capacity(at))) return false;
  Real closing = 0;  // m, by the open parts of faces
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t below = at - grid().step(a), above = at + grid().step(a);
    if (is_wet(below)) closing += cuts()->face(a, at) * (water().displacement(a, at) - cuts()->moved(a, above));
    if (is_wet(above)) closing -= cuts()->face(a, above) * (water().displacement(a, above) - cuts()->moved(a, at));
  }
  return closing > 0;
}

// Goes up through the dry cells above for which `passes` holds: whether the next one is water one or two `cells` deep,
// or a solid that lies on the cell. Water in the last cell reaches the ceiling.
template <class Passes>
bool FreeSurface::is_under(std::size_t at, LocalId c, int cells, const Passes& passes) const {
  while (++c < grid().columns() && !is_wet(++at) && passes(at)) {
  }
  if (c == grid().columns()) return false;
  if (is_solid(at) || !is_wet(at)) return is_solid(at);
  return cells == 1 || c + 1 == grid().columns() || is_wet(at + 1) || is_solid(at + 1);
}

// Whether a cell holds more than what the particles of the water below it contribute to it.
bool FreeSurface::stands_in(std::size_t at, LocalId c) const {
  if (!upright() || c == 0 || is_solid(at - 1) || cuts()->face(2, at) == 0) return true;
  return water().height_of(fill_[at] * cuts()->capacity(at) / cuts()->capacity(at - 1)) > 0;
}

// The fill of a cell under water together with the cells beyond its open sides: what they hold over what they can hold.
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

// The fill of a cut cell depends on few particles: layers at a wall fill it to 0.7 or to 1.05, and the neighbouring
// cells hold the difference. Its level would rise by as much less, or more, than the water does: a tank rotated by 45°
// was 4 % too slow, or 3 % too fast in another position. Its fill is therefore divided by the ratio of what the cells
// below that are cut alike hold to what they and their neighbours hold. Compression, which is common to these, is kept.
// None if there is no such cell.
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

// Extrapolated with the slope from the neighbouring cell to which the water is closer.
Real FreeSurface::level_at_middle(const Place& place) const {
  const auto [k, r, c] = place;
  const std::size_t at = grid().index(k, r, c);
  Real more = 0;
  for (std::size_t a = 0; a < 2; ++a) {
    const Real aside = cuts()->aside(a, at), way = std::abs(aside);
    const bool upper = aside < 0;  // on which side that cell is
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

// A floating body turns, and its sides are nearly upright: the threshold decreases with their slope.
Real FreeSurface::min_wet_fill(std::size_t at, LocalId c) const {
  if (!upright()) return wet_fill;
  if (c == 0) return floor_fill;
  const Real slope = std::max(cuts()->face(2, at + 1) - cuts()->face(2, at), 0.0);
  if (slope == 0) return wet_fill;
  return cuts()->floats(at) ? wet_fill + slope * (floor_fill - wet_fill) : floor_fill;
}

// The surface in a small cell is that of its neighbour, or the mean of both where two faces are equally wide.
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

// Beside a small cell at a floating body: the fill of the cells beyond its sides; none if all of these are small, too.
// The cell below it holds water long before the surface is as high as the floor of the small cell.
std::optional<Real> FreeSurface::fill_beside(const Place& place) const {
  Real sum = 0, weight = 0;
  for_each_side(place, [&](std::size_t beside, Real wide) {
    sum += wide * std::min(fill_[beside], 1.0);
    weight += wide;
  });
  return weight > 0 ? std::optional(sum / weight) : std::nullopt;
}

// In a small cell beside a floating body: the level of the columns beyond its sides, wherever their top cells are.
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

// Calls visit(cell, width of the open face to it) for the cells beyond the sides of a cell that are not small.
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

// The cells beyond the widest faces. Faces are treated as equal where obstacles are aligned with the cells up to
// rounding.
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

// Second stage of the projection: it determines which cells hold water, and where the free surface is.
//
// The surface of a column that stands on the floor, or on a solid, lies at the height that its whole volume reaches.
// Otherwise noise in the fill of lower cells would count as missing weight, and waves would be 2 % too slow. Volumes
// are placed in the middle of paths, and the surface is lowered by half of its rise to where the paths begin. Without
// gravity there is no upward direction: cells are wet or dry, and the surface is where the wet ones end. Collective:
// classify().
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "domain/halo.hpp"
#include "projection/active_rows.hpp"
#include "projection/enclosed_water.hpp"
#include "projection/openings.hpp"
#include "projection/parameters.hpp"
#include "projection/particles_to_grid.hpp"

namespace trevi {

class FreeSurface {
 public:
  /// The input; `cuts` may be null. `upright`: whether gravity points down.
  struct Sources {
    const ProjectionGrid& grid;
    const ActiveRows& rows;
    const ParticlesToGrid& water;
    const CutCells* cuts;
    bool upright;
  };
  explicit FreeSurface(const Sources& sources) : from_(sources) {}

  /// Borrows memory for the present grid. The other three give it back step by step: when fill() is no longer needed,
  /// when only is_wet() is still needed, and when nothing is.
  void borrow();
  void give_back_fill() { fill_.give_back(); }
  void keep_wet();
  void give_back() { wet_.give_back(); }
  /// From now on the cells that `openings` drain are dry.
  void open_to(Openings* openings) { openings_ = openings; }
  void classify(Halo& halo);

  const ProjectionGrid& grid() const { return from_.grid; }
  const ParticlesToGrid& water() const { return from_.water; }
  /// Null if there are no obstacles.
  const CutCells* cuts() const { return from_.cuts; }
  bool upright() const { return from_.upright; }
  /// Null if water neither enters nor leaves.
  const Openings* openings() const { return openings_; }
  /// Whether a drain takes the water that enters the cell, which is then dry.
  bool is_drained(std::size_t at) const { return openings_ != nullptr && openings_->is_drained(at); }
  /// Whether a drain keeps the cell empty. This includes a drain that takes all of the cell.
  bool is_emptied(std::size_t at) const { return openings_ != nullptr && openings_->is_emptied(at); }
  /// Open fraction of face (a, at): the part that is closed neither by a solid nor as the side of a drain.
  Real face(std::size_t a, std::size_t at) const {
    if (openings_ != nullptr && openings_->closes(a, at)) return 0;
    return from_.cuts != nullptr ? from_.cuts->face(a, at) : 1;
  }
  /// Whether nothing passes a face of cell (k, r, c), because it lies in a wall of the box or is closed by solids.
  bool is_closed(const CellFace& of, LocalId k, LocalId r, LocalId c) const {
    return grid().is_wall(of, k, r, c) || face(of.a, grid().index_of(of, grid().index(k, r, c))) == 0;
  }
  /// Whether the cell is solid. Such a cell is wet where the water below it has no surface under it.
  bool is_solid(std::size_t at) const { return from_.cuts != nullptr && from_.cuts->open(at) == 0; }
  /// Whether a solid closes a part of the cell.
  bool is_cut(std::size_t at) const { return from_.cuts != nullptr && from_.cuts->is_cut(at); }
  /// Fraction of the cell that is not solid. The fill is a fraction of this.
  Real open(std::size_t at) const { return from_.cuts != nullptr ? from_.cuts->open(at) : 1; }
  Real fill(std::size_t at) const { return fill_[at]; }
  bool is_wet(std::size_t at) const { return wet_[at] == wet_cell; }
  /// Whether a cell is wet, or what it holds says nothing: it is small, or water enters or leaves it.
  bool may_hold_water(std::size_t at) const {
    if (is_solid(at) || is_wet(at)) return !is_solid(at);
    if (openings_ != nullptr && openings_->is_crossed(at)) return !is_emptied(at);
    return from_.cuts != nullptr && is_small(at) && !is_emptied(at);
  }
  /// Whether any particle is in an owned cell.
  bool holds_particles(std::size_t at) const {
    const auto [k, r, c] = grid().cell_at(at);
    return water().holds_any(k, r, c);
  }
  /// The pieces of water that have no surface.
  const EnclosedWater& enclosed() const { return enclosed_; }
  /// A wet cell with a dry one above it, under gravity. The few particles in that dry cell follow the wet one.
  bool is_top(std::size_t at) const { return from_.upright && is_wet(at) && !is_wet(at + 1) && !is_solid(at); }
  /// Height of the water above the lower face of a wet cell where paths begin, in cells; 1 except in top cells.
  Real height(std::size_t at) const { return is_top(at) ? height_[at] : 1; }
  /// Height up to which water fills a cell, 0 to 1; also for the dry cell over a top cell, into which water may rise.
  Real filled_height(std::size_t at) const {
    return is_wet(at) ? std::min(height(at), 1.0) : std::clamp(height(at - 1) - 1, 0.0, 1.0);
  }
  /// Height of the surface above the middle of a top cell, in cells, at least projection::min_height.
  Real above_middle(std::size_t at) const { return std::max(height_[at] - 0.5, projection::min_height); }
  /// Mass of the water of a cell over that of a full cell; 1 except where the water is thin.
  Real mass(std::size_t at) const { return mass_[at]; }
  /// The divisor of the difference of phi across face (a, at), beside which at least one cell is wet. It is the mass of
  /// the water there over that in full cells, 1 except where the water is thin (projection::thin_begins), times the
  /// distance, in cells, between the points where phi is given. These are the centre of a wet cell and either the
  /// centre of the other cell or the point where the surface lies on the way to it (ghost-fluid method, Gibou et al.
  /// 2002). At the side of the water mass and distance are replaced by the weight of the wet cell's particles there
  /// over that in full water, so that these get the impulse that the pressure gives.
  Real resistance(std::size_t a, std::size_t at) const {
    const std::size_t below = at - grid().step(a);
    const bool low = is_wet(below), high = is_wet(at);
    if (low && high) return (mass_[below] + mass_[at]) / 2;
    return high ? resistance_to_air(a, at, below) : resistance_to_air(a, below, at);
  }

 private:
  // In wet_; the last one only while cells are classified.
  enum : char { dry_cell, wet_cell, dry_at_solid };
  // Cell (r, c) of plane k.
  struct Place {
    LocalId k, r, c;
  };
  void classify_cells(Halo& halo);
  void find_tops(LocalId k, LocalId r);
  Real half_rise(std::size_t at, Real height) const;
  void find_masses(Halo& halo);
  Real mass_of(const Place& place) const;
  void close_ceiling(LocalId k, LocalId r);
  void fill_crossed();
  bool is_full_enough(const Place& place, Real least) const;
  bool is_beside_water(const Place& place, std::size_t at) const;
  bool is_reached_into(const Place& place, Real volume) const;
  // Among obstacles; see free_surface_cut.cpp.
  Real min_wet_fill(std::size_t at, LocalId c) const;
  void classify_among_solids(Halo& halo);
  void fill_open_parts();
  void join_cells_at_solids(Halo& halo);
  void fill_vessels(Halo& halo);
  bool joins(const Place& place) const;
  bool is_under_lid(std::size_t at) const;
  bool is_at_solid(std::size_t at) const;
  bool is_run_into(const Place& place) const;
  bool is_pocket(const Place& place) const;
  template <class Passes>
  bool is_under(std::size_t at, LocalId c, int cells, const Passes& passes) const;
  Real resistance_to_air(std::size_t a, std::size_t wet, std::size_t dry) const;
  Real part_down_slope(std::size_t a, std::size_t wet, std::size_t dry) const;
  Real weight_at_side(std::size_t a, std::size_t wet, std::size_t dry) const;
  Real part_in_water(std::size_t wet, std::size_t dry) const;
  template <class Level>
  void level_cut_cells(Halo& halo, const Level& level);
  std::optional<Real> share_below(std::size_t floor, std::size_t top) const;
  bool stands_in(std::size_t at, LocalId c) const;
  Real fill_around(std::size_t at) const;
  Real level_at_middle(const Place& place) const;
  Real level_beyond_widest(const Place& place) const;
  bool is_small(std::size_t at) const;
  std::optional<Real> fill_beside(const Place& place) const;
  Real level_beside(const Place& place) const;
  template <class Visit>
  void for_each_side(const Place& place, const Visit& visit) const;
  template <class Visit>
  void for_widest(const Place& place, const Visit& visit) const;

  Openings* openings_ = nullptr;
  EnclosedWater enclosed_;
  Sources from_;
  Borrowed<Real> fill_, height_, mass_;
  Borrowed<char> wet_;
};

}  // namespace trevi

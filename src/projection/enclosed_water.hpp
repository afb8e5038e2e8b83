// Water without a surface: pieces of it that fill their vessels, or the box, and so touch no air. Their pressure has no
// origin; with one by chance, where phi ≤ 0 is demanded (pressure.hpp), parts of a full vessel had no pressure at all.
//
// A piece is what open faces connect of wet cells and of small ones, which say nothing of their own: at the edges of a
// full vessel some count as dry. Where these are all the air that a piece touches, it fills its vessel, and they are
// wet as well. Pieces with particles in less than the volume of one cell do not count: nothing moves in wedges between
// solids, and sealed gaps without particles are air. Ranks join the parts of a piece by the names that the parts have.
// Collective, except any(), holds() and cells().
#pragma once

#include <compare>
#include <span>
#include <vector>

#include "domain/halo.hpp"
#include "projection/grid.hpp"

namespace trevi {

class FreeSurface;

class EnclosedWater {
 public:
  /// Finds it among obstacles, in cells that are already wet or dry, also ghost cells.
  void find(const FreeSurface& surface, Halo& halo);
  /// The same without obstacles, where either none of the water has a surface or all of it.
  void find_whole(const FreeSurface& surface, Halo& halo);
  /// Whether there is any, on any rank.
  bool any() const { return all_ || !marks_.empty(); }
  /// Whether a cell, which may be a ghost cell, holds such water.
  bool holds(std::size_t at) const { return all_ || (!marks_.empty() && marks_[at] != 0); }
  /// The cells of this rank that hold it, among obstacles.
  std::span<const std::size_t> cells() const { return cells_; }
  /// What inlets bring to a cell of this rank that holds it, and what leaves the cell through walls, as shares of a
  /// cell.
  struct Flow {
    std::size_t cell;
    Real brought, leaving;
  };
  /// For each of these flows, the sums of the flows of all ranks in the same piece.
  std::vector<Flow> sums_over_pieces(MPI_Comm comm, const std::vector<Flow>& flows) const;
  /// The phi, m², that the pieces on this rank are to have: at most `largest`, or beside a floating body the mean of
  /// water at rest, of which `phi` is a guess.
  std::vector<Real> origins(const FreeSurface& surface, MPI_Comm comm, const Borrowed<Real>& phi, Real largest) const;
  /// Beside floating bodies, which may open and close such water: takes off from the right-hand side of each piece what
  /// it has no room for, the same from each of its cells. Real contacts leak as much.
  void balance(const FreeSurface& surface, MPI_Comm comm, Borrowed<Real>& rhs) const;
  /// Shifts phi of each piece to its origin, also in ghost cells. The mean beside a body has the weights of balance(),
  /// so that the pressure never drives a body on: with the largest value, two bodies that came apart pushed each other.
  void set_origins(const FreeSurface& surface, Halo& halo, Borrowed<Real>& phi, std::span<const Real> origins) const;
  void give_back() { marks_.give_back(); }

 private:
  // What one rank has of a piece.
  struct Part {
    GlobalId name;    // unique over all ranks, from 1
    GlobalId volume;  // of its cells with particles, as far as they are open, in millionths of a cell
    GlobalId has_surface;
    GlobalId has_body;  // whether a cell of it pushes a floating body
  };
  struct Edge {
    GlobalId from, to;  // names of parts that touch
    auto operator<=>(const Edge&) const = default;
  };
  template <class Visit>
  void for_each_beside(const FreeSurface& surface, std::size_t at, const Visit& visit) const;
  bool is_at_air(const FreeSurface& surface, std::size_t at) const;
  template <class Visit>
  void for_each_run(const FreeSurface& surface, const Visit& visit) const;
  void join_cells(const FreeSurface& surface, MPI_Comm comm, const Borrowed<GlobalId>& names);
  std::vector<Edge> edges_between(const FreeSurface& surface, const Borrowed<GlobalId>& names);
  void join_parts(MPI_Comm comm, const std::vector<Edge>& edges);
  void keep_enclosed(const FreeSurface& surface, Halo& halo);
  std::vector<Real> largest_of_parts(MPI_Comm comm, const Borrowed<Real>& phi) const;
  std::vector<Real> means_of_parts(const FreeSurface& surface, MPI_Comm comm, const Borrowed<Real>& field, Real unit,
                                   Real below) const;
  bool has_body(std::size_t part) const { return parts_[part].has_body != 0; }
  static void set_common_origin(const FreeSurface& surface, MPI_Comm comm, Borrowed<Real>& phi, Real largest);

  bool all_ = false;                  // whether none of the water has a surface, without obstacles
  std::vector<std::size_t> cells_;    // that may hold it; from keep_enclosed() on, that hold it
  std::vector<std::size_t> part_of_;  // for each of these cells, its number in parts_
  std::vector<Part> parts_;
  std::vector<std::size_t> shared_;  // for each part, the number of its piece among those on several ranks; 0: none
  std::size_t shared_pieces_ = 0;    // how many of these there are, the same on all ranks
  Borrowed<char> marks_;             // whether a cell holds it; empty if none does on any rank
};

}  // namespace trevi

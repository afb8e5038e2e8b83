// The height that the water of the coarse grid can reach in each row of cells. Above it, air and spray cost nothing:
// water in flight needs no pressure, and a drop that is thrown up must not cause work in all cells below it. The same
// on any rank count. Collective.
#pragma once

#include <vector>

#include "domain/halo.hpp"
#include "multigrid/cell_rows.hpp"

namespace trevi {

class ActiveRows {
 public:
  /// The smallest number of particles for a cell to count for the depth, and to have a free surface in or above it.
  struct Least {
    LocalId depth, surface;
  };
  ActiveRows(MPI_Comm comm, const Least& least) : comm_(comm), least_(least) {}

  /// Measures the rows from the particles of `order`, ghosts included.
  void measure(const CellOrder& order, Halo& halo);

  /// The largest number of cells directly above one another that may hold water, over all ranks.
  int depth() const { return depth_; }
  /// The largest columns() of all ranks.
  LocalId max_columns() const { return max_columns_; }
  /// Number of cells of row r of plane k that can be water, up to the cell above the highest surrounding cell that has
  /// a surface. Planes are counted from 0, the low ghost plane.
  LocalId wet_columns(LocalId k, LocalId r) const { return wet_[index(k, r)]; }
  /// Number of cells to be visited: those next to a cell that can be water. Incomplete for ghost planes and ghost rows.
  LocalId columns(LocalId k, LocalId r) const { return near_[index(k, r)]; }
  std::size_t bytes() const { return (surface_.capacity() + wet_.capacity() + near_.capacity()) * sizeof(LocalId); }

 private:
  std::size_t index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * (static_cast<std::size_t>(rows_) + 2) + static_cast<std::size_t>(r + 1);
  }
  void look_at_row(const CellOrder& order, LocalId k, LocalId r, int& depth);
  LocalId find_max_columns() const;
  // With this many cells per row, a loop that threads share is divided into parts of 64 rows.
  CellRows rows_of(Range planes) const { return {planes, rows_, 62}; }
  CellRows rows_and_ghosts_of(Range planes) const {
    return rows_are_cut_ ? CellRows{planes, rows_ + 2, 62, -1} : rows_of(planes);
  }
  void spread(const std::vector<LocalId>& from, const CellRows& rows, std::vector<LocalId>& to) const;

  MPI_Comm comm_;
  Least least_;
  LocalId planes_ = 0, rows_ = 0, max_columns_ = 0;
  bool rows_wrap_ = false, rows_are_cut_ = false;
  int depth_ = 0;
  std::vector<LocalId> surface_, wet_, near_;  // of each row, ghosts included
};

}  // namespace trevi

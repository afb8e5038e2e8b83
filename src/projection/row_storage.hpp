// Where CellFields keep the cells of rows, counted in eights of cells. The two planes at either end, which neighbours
// exchange, have whole rows and a ring of rows around them, so that ranks agree on them without a word. A row of any
// other plane has as many cells as loops over it and over the rows around it look at: under air it has few. The rows of
// the ring of those planes are that of the first plane, in which there is never anything. Not collective.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "multigrid/cell_rows.hpp"

namespace trevi {

class RowStorage {
 public:
  /// `cells`: all planes, ghost planes included. `reach`: cells of each row of each plane that loops look at. False
  /// where all stays as it is.
  bool lay_out(const CellRows& cells, bool rows_repeat, std::span<const LocalId> reach);

  /// The first eight of row (k, r); −1 and rows() are the rows of the ring.
  std::size_t begin(LocalId k, LocalId r) const { return begin_[index(k, r)]; }
  /// Cells of a row that there is memory for.
  LocalId cells(LocalId k, LocalId r) const { return 8 * eights_[index(k, r)]; }
  /// Eights of a whole row, of a whole plane, and of all.
  std::size_t per_row() const { return static_cast<std::size_t>(whole_); }
  std::size_t per_plane() const { return static_cast<std::size_t>(shape_.rows + 2) * per_row(); }
  std::size_t size() const { return size_; }
  bool is_whole(LocalId k) const { return k <= 1 || k + 2 >= shape_.planes.end; }
  const CellRows& shape() const { return shape_; }
  std::size_t bytes() const {
    return begin_.capacity() * sizeof(std::size_t) + (eights_.capacity() + next_.capacity()) * sizeof(LocalId);
  }

 private:
  std::size_t index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(shape_.rows + 2) + static_cast<std::size_t>(r + 1);
  }
  LocalId eights_of(LocalId k, LocalId r, bool rows_repeat, std::span<const LocalId> reach) const;

  CellRows shape_{{0, 0}, 0, 0};
  LocalId whole_ = 0;
  std::size_t size_ = 0;
  std::vector<std::size_t> begin_;
  std::vector<LocalId> eights_, next_;  // of each row, as it is and as it shall be
};

}  // namespace trevi

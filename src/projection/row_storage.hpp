// The places at which CellFields store the cells of rows, in groups of four cells ("fours"). There is memory for groups
// that contain a cell with particles; for some fields also for groups beside such a cell in its plane. All other groups
// share one and the same group, which is 0 and never written. Planes that are exchanged, the last owned plane and the
// ghost plane at an end with a neighbouring rank, come first, one after another, and also have memory for the groups
// beside cells with particles. Ranks agree on these without communication, because both know the particles of all cells
// of these planes. Where slabs are cut inside, this does not hold at the corners. These planes then have memory for all
// of their cells and for a ring of rows around them; of the other planes, the rows that are exchanged, the last owned
// row and the ghost row, are stored whole. Not collective.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "multigrid/cell_rows.hpp"
#include "particles/cell_order.hpp"

namespace trevi {

/// One number of four cells of a row.
struct alignas(32) FourCells {
  static constexpr std::size_t count = 4;
  Real of[count];
};

class RowStorage {
 public:
  /// Planes of the grid, ghost planes included; the ends at which planes are exchanged; the periodic directions; the
  /// ends at which rows are exchanged.
  struct Shape {
    CellRows cells;
    std::array<bool, 2> exchanged;
    Repeats repeats;
    std::array<bool, 2> rows_exchanged;
    bool beside = false;  // whether there is memory for the cells beside those with particles
    /// Where planes are processed one after the other: the number of planes needed at a time. Each plane reuses the
    /// memory of the plane this many before it, except exchanged planes and those beside them. 0: planes share none.
    LocalId window = 0;
  };
  /// `columns`: number of columns in use in each row of each plane, including one row before and one after the owned
  /// ones. Particles above them do not count.
  void lay_out(const Shape& shape, const CellOrder& order, std::span<const LocalId> columns);

  /// The places of the groups of row (k, r) in memory; −1 and rows() are the rows of the ring.
  const std::uint32_t* places(LocalId k, LocalId r) const { return &places_[row_index(k, r) * whole_]; }
  /// Whether there is memory for group f of the row.
  bool has(LocalId k, LocalId r, std::size_t f) const { return places(k, r)[f] != nowhere_; }
  /// The place of the group that stands for all groups without memory.
  std::uint32_t nowhere() const { return nowhere_; }
  /// Number of groups of a whole row, of all exchanged planes and rows, and in total.
  std::size_t per_row() const { return whole_; }
  std::size_t exchanged() const { return nowhere_; }
  std::size_t size() const { return size_; }
  /// Consecutive groups.
  struct Run {
    std::size_t first = 0, count = 0;
  };
  /// The groups of an exchanged plane; where rows are cut, those of these rows of it.
  Run exchanged_plane(LocalId k, const Range& rows) const {
    if (!are_cut()) return planes_[static_cast<std::size_t>(k)];
    return {places(k, rows.begin)[0], static_cast<std::size_t>(rows.size()) * whole_};
  }
  bool is_exchanged(LocalId k) const {
    return (shape_.exchanged[0] && k <= 1) || (shape_.exchanged[1] && k + 2 >= shape_.cells.planes.end);
  }
  bool is_exchanged(LocalId k, LocalId r) const {
    return is_exchanged(k) || (shape_.rows_exchanged[0] && r <= 0) ||
           (shape_.rows_exchanged[1] && r + 1 >= shape_.cells.rows);
  }
  const Shape& shape() const { return shape_; }
  std::size_t bytes() const {
    return planes_.capacity() * sizeof(Run) + places_.capacity() * sizeof(std::uint32_t) + held_.capacity() +
           begin_.capacity() * sizeof(begin_[0]);
  }

 private:
  std::size_t row_index(LocalId k, LocalId r) const {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(shape_.cells.rows + 2) +
           static_cast<std::size_t>(r + 1);
  }
  bool are_cut() const { return shape_.rows_exchanged[0] || shape_.rows_exchanged[1]; }
  void find_held(const CellOrder& order, LocalId k, LocalId r, LocalId columns);
  bool is_held(LocalId k, LocalId r, std::size_t f, bool beside) const;
  bool is_needed(LocalId k, LocalId r, std::size_t f) const {
    return !is_exchanged(k, r) && is_held(k, r, f, shape_.beside);
  }
  void place_exchanged();
  void place_exchanged_plane(LocalId k);
  void place_whole_rows(LocalId k);
  void place_row(LocalId k, LocalId r);
  void find_begins();
  // Whether the plane shares memory with others.
  bool is_shared(LocalId k) const {
    const LocalId last = shape_.cells.planes.end - 1;
    return shape_.window > 0 && !(shape_.exchanged[0] && k <= 2) && !(shape_.exchanged[1] && k + 2 >= last);
  }

  Shape shape_{};
  std::size_t whole_ = 0, size_ = 0;
  std::uint32_t nowhere_ = 0;
  std::vector<std::uint32_t> places_;
  std::vector<char> held_;            // for each group, whether its row has particles in it or beside it
  std::vector<std::uint32_t> begin_;  // the first place of each row
  std::vector<Run> planes_;           // the groups of each exchanged plane, where rows are not cut
};

}  // namespace trevi

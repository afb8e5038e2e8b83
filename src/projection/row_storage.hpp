// Where CellFields keep the cells of rows, counted in fours of cells: there is memory for fours that hold a cell with
// particles, or for some fields also one beside such a cell in its plane, and all others are one and the same four,
// which is 0 and never written. Planes at ends beyond which other ranks go on, the last own one and the ghost plane,
// which neighbours exchange, come first, one after another, and have memory for the fours beside cells with particles,
// too. Ranks agree on them without a word, as both know the particles of all cells of these planes. Where slabs are cut
// inside, that is not so at the corners: there those planes have memory for all of their cells and for a ring of rows
// around them, and of the other planes the rows that are exchanged, the last own one and the ghost row. Not collective.
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
  /// Planes of the grid, ghost planes included; at which ends planes are exchanged; where the grid repeats; at which
  /// ends rows are exchanged.
  struct Shape {
    CellRows cells;
    std::array<bool, 2> exchanged;
    Repeats repeats;
    std::array<bool, 2> rows_exchanged;
    bool beside = false;  // whether there is memory for the cells beside those with particles
    /// Where planes are worked on one after the other: this many of them are needed at a time, and each has the memory
    /// of the one so many before. Not those at ends that are exchanged, nor those beside these. 0: none shares memory.
    LocalId window = 0;
  };
  /// `columns` of each row of each plane, with one row before and one after the own ones, that are looked at: particles
  /// above them do not count.
  void lay_out(const Shape& shape, const CellOrder& order, std::span<const LocalId> columns);

  /// Of row (k, r) the places of its fours in the memory; −1 and rows() are the rows of the ring.
  const std::uint32_t* places(LocalId k, LocalId r) const { return &places_[row_index(k, r) * whole_]; }
  /// Whether there is memory for a four of it.
  bool has(LocalId k, LocalId r, std::size_t f) const { return places(k, r)[f] != nowhere_; }
  /// The place of the four that stands for all that there is no memory for.
  std::uint32_t nowhere() const { return nowhere_; }
  /// Fours of a whole row, of all planes and rows that are exchanged, and of all.
  std::size_t per_row() const { return whole_; }
  std::size_t exchanged() const { return nowhere_; }
  std::size_t size() const { return size_; }
  /// Fours one after another.
  struct Run {
    std::size_t first = 0, count = 0;
  };
  /// Those of an exchanged plane; where rows are cut, of these rows of it.
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
  // Whether the plane has the memory of others.
  bool is_shared(LocalId k) const {
    const LocalId last = shape_.cells.planes.end - 1;
    return shape_.window > 0 && !(shape_.exchanged[0] && k <= 2) && !(shape_.exchanged[1] && k + 2 >= last);
  }

  Shape shape_{};
  std::size_t whole_ = 0, size_ = 0;
  std::uint32_t nowhere_ = 0;
  std::vector<std::uint32_t> places_;
  std::vector<char> held_;            // of each four, whether particles in or beside it are in its row
  std::vector<std::uint32_t> begin_;  // of each row, the first place
  std::vector<Run> planes_;           // of each plane that is exchanged, where rows are not cut
};

}  // namespace trevi

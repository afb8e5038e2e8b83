// Numbers of the cells of the projection's grid, several of each cell, laid out for loops over the cells of a row: of a
// row eight cells after another, of these first the first number of all, then the second of all. Planes, and the ring
// of rows around each, are those of ProjectionGrid, the memory of rows that of RowStorage. What lies beyond a row's own
// columns is 0: whoever writes a row writes all of its cells, and clears all others that there is memory for. Not
// collective.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <span>

#include "domain/halo.hpp"
#include "projection/affine.hpp"
#include "projection/grid.hpp"

namespace trevi {

/// One number of eight cells of a row.
struct alignas(64) EightCells {
  static constexpr std::size_t count = 8;
  Real of[count];
};

/// A struct that is nothing but numbers, as these in their order.
template <class T>
using NumbersOf = std::array<Real, sizeof(T) / sizeof(Real)>;

/// The first numbers of a cell of a row, of `numbers` each, as those of a T.
template <class T>
T cell_of(const EightCells* row, std::size_t numbers, LocalId c) {
  constexpr LocalId eight = EightCells::count;
  NumbersOf<T> value;
  const EightCells* const from = row + static_cast<std::size_t>(c / eight) * numbers;
  for (std::size_t q = 0; q < value.size(); ++q) value[q] = from[q].of[c % eight];
  return std::bit_cast<T>(value);
}

class CellFields {
 public:
  /// `numbers` of each cell.
  explicit CellFields(std::size_t numbers) : numbers_(numbers) {}

  /// Memory for the grid as it is now: 0 in planes at the ends, which neighbours exchange; else not yet written.
  void resize(const ProjectionGrid& grid) {
    storage_ = &grid.storage();
    const std::size_t size = storage_->size() * numbers_;
    if (size > capacity_) {
      values_.reset();
      capacity_ = capacity_ == 0 ? size : size + size / 16;
      values_.reset(new EightCells[capacity_]);  // the threads that work on it write to it first
    }
    const CellRows& all = storage_->shape();
    for_each_row({all.planes, all.rows + 2, all.columns}, [&](LocalId k, LocalId r) {
      if (storage_->is_whole(k)) std::fill_n(row(k, r - 1)->of, per_row() * EightCells::count, 0.0);
    });
  }

  /// The first number of the lowest cells of row (k, r); −1 and rows() are the rows of the ring.
  EightCells* row(LocalId k, LocalId r) { return &values_[storage_->begin(k, r) * numbers_]; }
  const EightCells* row(LocalId k, LocalId r) const { return &values_[storage_->begin(k, r) * numbers_]; }
  /// Number q of a cell.
  Real& number(std::size_t q, LocalId k, LocalId r, LocalId c) { return (row(k, r) + eight(c) + q)->of[lane(c)]; }
  Real number(std::size_t q, LocalId k, LocalId r, LocalId c) const { return (row(k, r) + eight(c) + q)->of[lane(c)]; }
  /// From the lowest eight cells of a row to those of cell c.
  std::size_t eight(LocalId c) const { return static_cast<std::size_t>(c / eight_cells) * numbers_; }
  /// Clears the cells of a row but for `kept`.
  void clear_around(LocalId k, LocalId r, Range kept) {
    clear(k, r, {0, kept.begin});
    clear(k, r, {kept.end, storage_->cells(k, r)});
  }
  /// Clears a row.
  void clear(LocalId k, LocalId r) { clear(k, r, {0, storage_->cells(k, r)}); }
  /// The first numbers of a cell as those of a T.
  template <class T>
  T cell(LocalId k, LocalId r, LocalId c) const {
    return cell_of<T>(row(k, r), numbers_, c);
  }
  template <class T>
  void set(LocalId k, LocalId r, LocalId c, const T& value) {
    EightCells* const to = row(k, r) + eight(c);
    const auto all = std::bit_cast<NumbersOf<T>>(value);
    for (std::size_t q = 0; q < all.size(); ++q) to[q].of[lane(c)] = all[q];
  }

  /// Memory of one whole row.
  std::size_t per_row() const { return storage_->per_row() * numbers_; }
  /// To exchange planes.
  std::span<EightCells> values() { return {values_.get(), storage_->size() * numbers_}; }
  std::size_t per_plane() const { return storage_->per_plane() * numbers_; }
  std::size_t numbers() const { return numbers_; }
  std::size_t bytes() const { return capacity_ * sizeof(EightCells); }

 private:
  static constexpr LocalId eight_cells = EightCells::count;
  static std::size_t lane(LocalId c) { return static_cast<std::size_t>(c % eight_cells); }
  // The cells [columns) of a row; there may be none.
  void clear(LocalId k, LocalId r, Range columns) {
    for (LocalId c = columns.begin; c < columns.end;) {
      EightCells* const from = row(k, r) + eight(c);
      if (c % eight_cells == 0 && c + eight_cells <= columns.end) {  // all numbers of as many as there are
        const LocalId whole = (columns.end - c) / eight_cells;
        std::fill_n(from->of, static_cast<std::size_t>(whole * eight_cells) * numbers_, 0.0);
        c += whole * eight_cells;
      } else {
        const LocalId end = std::min(columns.end, (c / eight_cells + 1) * eight_cells);
        for (std::size_t q = 0; q < numbers_; ++q)
          for (LocalId i = c; i < end; ++i) from[q].of[lane(i)] = 0;
        c = end;
      }
    }
  }

  std::size_t numbers_, capacity_ = 0;
  const RowStorage* storage_ = nullptr;
  std::unique_ptr<EightCells[]> values_;
};

/// work(state, k, r) for the rows of all own planes, those of the planes at either end first: send() then lets these
/// travel to the neighbours while the others are worked on. A State as for_each_row_with() has it.
template <class State, class Work, class Send>
void for_each_row_and_send(const ProjectionGrid& grid, Halo& halo, const Work& work, const Send& send) {
  const LocalId rows = grid.rows(), last = grid.planes();
  if (!halo.has_neighbours()) return for_each_row_with<State>(grid.rows_of({1, last + 1}), work);
  constexpr LocalId part_size = 16;  // a plane has few rows for all threads
  for_each_part({0, std::min(last, 2) * rows}, part_size, [&](Range part) {
    State state;
    for (LocalId i = part.begin; i < part.end; ++i) work(state, i < rows ? 1 : last, i % rows);
  });
  send();
  if (last > 2) for_each_row_with<State>(grid.rows_of({2, last}), work);
  halo.finish();
}
template <class State, class Work>
void for_each_row_and_send(const ProjectionGrid& grid, Halo& halo, CellFields& field, const Work& work) {
  for_each_row_and_send<State>(grid, halo, work, [&] { halo.start_planes(field.values(), field.per_plane()); });
}

}  // namespace trevi

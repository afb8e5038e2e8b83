// Loops of threads over the rows of cells of planes. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "base/threads.hpp"

namespace trevi {

/// Rows that a thread works on at a time: some 4096 cells.
inline LocalId rows_at_a_time(LocalId columns) { return std::max(4096 / (columns + 2), 1); }

/// Whether a grid goes on at its other end beyond the last plane, row and column.
using Repeats = std::array<bool, 3>;

/// Planes of `rows` rows of `columns` cells, from row number `first_row` on.
struct CellRows {
  Range planes;
  LocalId rows, columns;
  LocalId first_row = 0;
};

/// work(k, r) for each row r of each plane k.
template <class Work>
void for_each_row(const CellRows& cells, const Work& work) {
  const LocalId rows = cells.rows, first_row = cells.first_row;
  const Range all{cells.planes.begin * rows, cells.planes.end * rows};
  for_each_part(all, rows_at_a_time(cells.columns), [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) work(i / rows, first_row + i % rows);
  });
}

/// work(state, k, r) likewise, with a State of its own for rows that come one after the other.
template <class State, class Work>
void for_each_row_with(const CellRows& cells, const Work& work) {
  const LocalId rows = cells.rows, first_row = cells.first_row;
  const Range all{cells.planes.begin * rows, cells.planes.end * rows};
  for_each_part(all, rows_at_a_time(cells.columns), [&](Range part) {
    State state;
    for (LocalId i = part.begin; i < part.end; ++i) work(state, i / rows, first_row + i % rows);
  });
}

/// Where rows repeat, beyond those at the ends of each plane: copies of those at its other end. `field`: planes of
/// `rows` rows of `columns` cells with a ring of one around each.
template <class Field>
void repeat_rows(Field& field, LocalId rows, LocalId columns) {
  const auto row = static_cast<std::ptrdiff_t>(columns) + 2, plane = (static_cast<std::ptrdiff_t>(rows) + 2) * row;
  for (auto first = field.begin(); first != field.end(); first += plane) {
    std::copy_n(first + rows * row, row, first);
    std::copy_n(first + row, row, first + (rows + std::ptrdiff_t{1}) * row);
  }
}

/// The same beyond the ends of the columns, of all rows that the field has.
template <class Field>
void repeat_columns(Field& field, LocalId columns) {
  const auto row = static_cast<std::ptrdiff_t>(columns) + 2;
  for (auto first = field.begin(); first != field.end(); first += row) {
    *first = *(first + columns);
    *(first + columns + 1) = *(first + 1);
  }
}

}  // namespace trevi

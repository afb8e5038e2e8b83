// Loops over the rows of cells of planes, shared by threads. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "base/threads.hpp"

namespace trevi {

/// Number of rows that a thread processes at a time: about 4096 cells.
inline LocalId rows_at_a_time(LocalId columns) { return std::max(4096 / (columns + 2), 1); }

/// Whether a grid is periodic along planes, rows and columns.
using Repeats = std::array<bool, 3>;

/// Planes of `rows` rows of `columns` cells, from row number `first_row` on.
struct CellRows {
  Range planes;
  LocalId rows, columns;
  LocalId first_row = 0;
};

/// Calls work(k, r) for each row r of each plane k.
template <class Work>
void for_each_row(const CellRows& cells, const Work& work) {
  const LocalId rows = cells.rows, first_row = cells.first_row;
  const Range all{cells.planes.begin * rows, cells.planes.end * rows};
  for_each_part(all, rows_at_a_time(cells.columns), [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) work(i / rows, first_row + i % rows);
  });
}

/// Calls work(state, k, r) likewise, where consecutive rows share a State.
template <class State, class Work>
void for_each_row_with(const CellRows& cells, const Work& work) {
  const LocalId rows = cells.rows, first_row = cells.first_row;
  const Range all{cells.planes.begin * rows, cells.planes.end * rows};
  for_each_part(all, rows_at_a_time(cells.columns), [&](Range part) {
    State state;
    for (LocalId i = part.begin; i < part.end; ++i) work(state, i / rows, first_row + i % rows);
  });
}

/// Where rows are periodic: fills the rows beyond the ends of each plane with copies of those at its other end.
/// `field`: planes of `rows` rows of `columns` cells with a ring of one cell around each.
template <class Field>
void repeat_rows(Field& field, LocalId rows, LocalId columns) {
  const auto row = static_cast<std::ptrdiff_t>(columns) + 2, plane = (static_cast<std::ptrdiff_t>(rows) + 2) * row;
  for (auto first = field.begin(); first != field.end(); first += plane) {
    std::copy_n(first + rows * row, row, first);
    std::copy_n(first + row, row, first + (rows + std::ptrdiff_t{1}) * row);
  }
}

/// The same beyond the ends of the columns, for all rows of the field.
template <class Field>
void repeat_columns(Field& field, LocalId columns) {
  const auto row = static_cast<std::ptrdiff_t>(columns) + 2;
  for (auto first = field.begin(); first != field.end(); first += row) {
    *first = *(first + columns);
    *(first + columns + 1) = *(first + 1);
  }
}

}  // namespace trevi

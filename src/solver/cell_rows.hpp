// Loops of threads over the rows of cells of planes. Not collective.
#pragma once

#include <algorithm>

#include "base/threads.hpp"

namespace trevi {

/// Rows that a thread works on at a time: some 4096 cells.
inline LocalId rows_at_a_time(LocalId columns) { return std::max(4096 / (columns + 2), 1); }

/// Planes of `rows` rows of `columns` cells.
struct CellRows {
  Range planes;
  LocalId rows, columns;
};

/// work(k, r) for each row r of each plane k.
template <class Work>
void for_each_row(const CellRows& cells, const Work& work) {
  const LocalId rows = cells.rows;
  const Range all{cells.planes.begin * rows, cells.planes.end * rows};
  for_each_part(all, rows_at_a_time(cells.columns), [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) work(i / rows, i % rows);
  });
}

}  // namespace trevi

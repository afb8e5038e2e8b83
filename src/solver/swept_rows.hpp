// The rows of cells that a sweep has to process. These are the rows in which something may move, because a particle in
// the row or in an adjacent one has a multiplier; and the rows whose densities may have changed, because something has
// moved in the row or in an adjacent one. Water in flight, or at rest on its lattice, is not compressed, and its rows
// are skipped. The results are those of sweeps over all rows, bit by bit. Not collective.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "particles/cell_order.hpp"
#include "particles/packed.hpp"

namespace trevi {

class SweptRows {
 public:
  /// Begins with all rows marked as possibly moved. `order` must not change until the next start().
  void start(const CellOrder& order);
  /// Finds the rows of ghosts that have moved since the last call.
  template <class T>
  void find_moved_ghosts(const std::vector<Packed<T>>& records);

  /// Finds the rows where a multiplier, the scalar of the records, is not 0, including those of ghosts.
  template <class T>
  void find_multipliers(const std::vector<Packed<T>>& records);
  /// Marks the owned rows that have a multiplier in or beside them as moved, and no others.
  void move();
  /// Marks all rows as moved.
  void move_all();
  /// Marks the row of owned particle i as moved; may be called by several threads at once.
  void move(LocalId i);

  /// Owned particles of rows that have a multiplier in or beside them. With `bridged`, short gaps between them are
  /// included, so that there are few ranges.
  std::vector<Range> with_multipliers(bool bridged) const { return beside(held_, bridged); }
  /// Owned particles of rows that have moved since move(), or are beside such ones.
  std::vector<Range> moved() const { return beside(moved_, true); }
  /// For each owned row, plane by plane: whether a row within three of it has moved since start(), or has particles of
  /// other ranks; valid until the next call.
  std::span<const char> find_near_shifts();

 private:
  std::size_t index(LocalId k, LocalId r) const;
  bool is_own(LocalId k, LocalId r) const { return k >= 1 && k <= planes_ && r >= 0 && r < rows_; }
  // Calls visit(k, r) for all rows, including those of ghosts, by several threads.
  template <class Visit>
  void for_each_row(const Visit& visit) const;
  bool is_beside(const std::vector<char>& marked, LocalId k, LocalId r) const;
  std::vector<Range> beside(const std::vector<char>& marked, bool bridged) const;

  const CellOrder* order_ = nullptr;
  LocalId planes_ = 0, rows_ = 0;
  // By row, for all planes and rows including those beside them.
  std::vector<char> held_, moved_, shifted_;
  std::vector<char> near_;             // by owned row
  std::vector<std::uint64_t> digest_;  // hash of the positions of ghosts
};

/// Calls visit(range, whether it is in one of the ranges) for all of `part`, piece by piece; the ranges are in order.
template <class Visit>
void for_each_piece(Range part, const std::vector<Range>& ranges, const Visit& visit) {
  LocalId at = part.begin;
  for (const Range& range : ranges) {
    const Range inside{std::max(range.begin, at), std::min(range.end, part.end)};
    if (inside.size() <= 0) continue;
    if (inside.begin > at) visit(Range{at, inside.begin}, false);
    visit(inside, true);
    at = inside.end;
  }
  if (at < part.end) visit(Range{at, part.end}, false);
}

}  // namespace trevi

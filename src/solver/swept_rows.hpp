// Where a sweep has work: the rows of cells in which something may move, which is where a particle in a row, or in one
// beside it, has a multiplier; and those whose densities may have changed, which is where something has moved in a row
// or beside it. Water that flies, or rests as its lattice does, is not compressed, and its rows are left out; the
// results are those of sweeps over all rows, bit by bit. Not collective.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "particles/cell_order.hpp"
#include "particles/packed.hpp"

namespace trevi {

class SweptRows {
 public:
  /// All rows may have moved. `order` stays as it is until the next start().
  void start(const CellOrder& order);
  /// Finds the rows of ghosts that have moved since the last call of it.
  template <class T>
  void find_moved_ghosts(const std::vector<Packed<T>>& records);

  /// Finds the rows where a multiplier, the scalar of the records, is not 0; those of ghosts are known, too.
  template <class T>
  void find_multipliers(const std::vector<Packed<T>>& records);
  /// The own rows that have one in or beside them move, and no others.
  void move();
  /// All rows move.
  void move_all();
  /// So does the row of owned particle i; may be called by several threads at once.
  void move(LocalId i);

  /// Owned particles of rows that have a multiplier in or beside them. With `bridged` short gaps between them are
  /// taken in, so that there are few ranges.
  std::vector<Range> with_multipliers(bool bridged) const { return beside(held_, bridged); }
  /// Owned particles of rows that have moved since move(), or are beside such ones.
  std::vector<Range> moved() const { return beside(moved_, true); }
  /// Of each own row, plane by plane, whether a row within three of it has moved since start(), or has particles of
  /// other ranks; until the next call.
  std::span<const char> find_near_shifts();

 private:
  std::size_t index(LocalId k, LocalId r) const;
  bool is_own(LocalId k, LocalId r) const { return k >= 1 && k <= planes_ && r >= 0 && r < rows_; }
  // visit(k, r) for all rows, those of ghosts included, by several threads.
  template <class Visit>
  void for_each_row(const Visit& visit) const;
  bool is_beside(const std::vector<char>& marked, LocalId k, LocalId r) const;
  std::vector<Range> beside(const std::vector<char>& marked, bool bridged) const;

  const CellOrder* order_ = nullptr;
  LocalId planes_ = 0, rows_ = 0;
  // By row, of planes and rows with those beside them.
  std::vector<char> held_, moved_, shifted_;
  std::vector<char> near_;             // by own row
  std::vector<std::uint64_t> digest_;  // of where ghosts are
};

/// visit(range, whether it is in one of the ranges) for all of `part`, piece by piece; the ranges are in their order.
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

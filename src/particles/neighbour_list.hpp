// Neighbours of each owned particle: all others, ghosts included, with |p*_i − p*_j| < h at the time of the search,
// which is once a substep. Stored as compressed rows; within a row in storage order, which is the same on any rank
// count. Indices count from the first low ghost. Not collective.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "particles/cell_order.hpp"
#include "particles/packed.hpp"

namespace trevi {

/// Compressed rows: the neighbours of owned particle i are index[first[i]] to index[first[i + 1]].
struct NeighbourRows {
  std::vector<std::int64_t> first = {0};
  std::vector<LocalId> index;  ///< longer than the last row, so that whole vectors can be read and written past any end
  LocalId crowded = -1;        ///< a particle with too many neighbours; the search stopped there

  static constexpr std::size_t slack = 64;

  void reserve(std::int64_t n) {
    const auto wanted = static_cast<std::size_t>(n) + slack;
    if (wanted <= index.size()) return;
    // Without reserve(), resize() would double the capacity of what is the largest array of all.
    index.reserve(wanted + wanted / 16);
    index.resize(index.capacity());
  }
};

class NeighbourList {
 public:
  /// More neighbours than this end the run: it means that all the water within a few h has collapsed into one place,
  /// and the length of the lists grows as the square of the particles there.
  static constexpr LocalId most_neighbours = 4096;

  /// `records` are those of all particles of `order`, ghosts included. O(n).
  template <class T>
  void rebuild(const CellOrder& order, const std::vector<Packed<T>>& records);

  LocalId size() const { return static_cast<LocalId>(rows_.first.size()) - 1; }
  std::int64_t pairs() const { return rows_.first.back(); }
  LocalId count(LocalId i) const { return static_cast<LocalId>(first(i + 1) - first(i)); }
  std::span<const LocalId> operator[](LocalId i) const { return {row(i), static_cast<std::size_t>(count(i))}; }
  /// Where the row of owned particle i starts; a full vector may be read from any index of it.
  const LocalId* row(LocalId i) const { return rows_.index.data() + first(i); }
  /// Pairs of the particles before owned particle i.
  std::int64_t first(LocalId i) const { return rows_.first[static_cast<std::size_t>(i)]; }
  /// Owned particle with more than most_neighbours, −1 if there is none; it and those after it then have empty rows.
  LocalId crowded() const { return rows_.crowded; }
  std::size_t bytes() const {
    return rows_.first.capacity() * sizeof(rows_.first[0]) + rows_.index.capacity() * sizeof(rows_.index[0]);
  }

 private:
  NeighbourRows rows_;
};

}  // namespace trevi

// Neighbours of each owned particle: all others, ghosts included, with |p*_i − p*_j| < h at the time of the search,
// which is once a substep. Each particle has a row, in storage order, which is the same on any rank count. Indices
// count from the first low ghost. The rows of particles one after the other lie one after the other for the most part,
// but not always: each thread of the search writes its rows to pages of its own. Not collective.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "particles/cell_order.hpp"
#include "particles/packed.hpp"

namespace trevi {

/// Memory for the rows. It grows by pages and so never has to be copied; pages are kept for the next search.
class RowPages {
 public:
  static constexpr std::size_t page_size = std::size_t{1} << 16;  ///< indices; 256 kB

  /// An unused page of page_size; may be called by several threads at once.
  LocalId* take();
  /// All pages are unused again.
  void clear() { used_ = 0; }
  std::size_t bytes() const { return pages_.size() * page_size * sizeof(LocalId); }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<LocalId[]>> pages_;
  std::size_t used_ = 0;
};

/// The page to which one thread writes.
class RowWriter {
 public:
  /// Pair loops read whole vectors, past the end of a row.
  static constexpr std::size_t slack = 64;

  /// Where the next row begins; `longest` indices, at most page_size − slack, may be written there.
  LocalId* begin_row(RowPages& pages, std::size_t longest) {
    if (static_cast<std::size_t>(end_ - next_) < longest + slack) {
      close();
      next_ = pages.take();
      end_ = next_ + RowPages::page_size;
    }
    return next_;
  }
  void end_row(std::size_t length) { next_ += length; }
  /// Indices behind the last row are set to 0: others, left by an earlier search, may refer to records that are gone.
  void close() {
    if (next_ != nullptr) std::fill_n(next_, std::min<std::ptrdiff_t>(slack, end_ - next_), 0);
  }

 private:
  LocalId *next_ = nullptr, *end_ = nullptr;
};

/// The row of each owned particle.
struct NeighbourRows {
  std::vector<const LocalId*> begin;
  std::vector<LocalId> count;
};

class NeighbourList {
 public:
  /// More neighbours than this end the run: it means that all the water within a few h has collapsed into one place,
  /// and the length of the lists grows as the square of the particles there.
  static constexpr LocalId max_neighbours = 4096;

  /// `records` are those of all particles of `order`, ghosts included. O(n).
  template <class T>
  void rebuild(const CellOrder& order, const std::vector<Packed<T>>& records);

  LocalId size() const { return static_cast<LocalId>(rows_.count.size()); }
  LocalId count(LocalId i) const { return rows_.count[static_cast<std::size_t>(i)]; }
  std::span<const LocalId> operator[](LocalId i) const { return {row(i), static_cast<std::size_t>(count(i))}; }
  /// Where the row of owned particle i starts; a full vector may be read from any index of it.
  const LocalId* row(LocalId i) const { return rows_.begin[static_cast<std::size_t>(i)]; }
  /// Pairs of the particles of a range; quick where it begins and ends with rows of cells.
  std::int64_t pairs(Range range) const { return pairs_before(range.end) - pairs_before(range.begin); }
  std::int64_t pairs() const { return pairs({0, size()}); }
  /// Owned particle with more than max_neighbours, −1 if there is none; it and those after it then have empty rows.
  LocalId first_overfull_particle() const { return first_overfull_; }
  std::size_t bytes() const {
    return rows_.begin.capacity() * sizeof(rows_.begin[0]) + rows_.count.capacity() * sizeof(rows_.count[0]) +
           pages_.bytes() + pairs_of_row_.capacity() * sizeof(pairs_of_row_[0]) +
           first_of_row_.capacity() * sizeof(LocalId);
  }

 private:
  std::int64_t pairs_before(LocalId i) const;

  NeighbourRows rows_;
  RowPages pages_;
  // Of each row of cells its first particle, and the pairs of all rows before it; and of all rows.
  std::vector<LocalId> first_of_row_;
  std::vector<std::int64_t> pairs_of_row_;
  LocalId first_overfull_ = -1;
};

}  // namespace trevi

// Neighbours of each owned particle: all others, ghosts included, with |p*_i − p*_j| < h at the time of the search,
// which takes place once per substep. Each particle has a row, in storage order, which is the same on any rank count.
// Indices count from the first low ghost. The rows of consecutive particles are mostly, but not always, consecutive in
// memory: each thread of the search writes its rows to pages of its own. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "particles/cell_order.hpp"
#include "particles/packed.hpp"

namespace trevi {

/// Memory for the rows, which is borrowed. It grows by pages and so never has to be copied.
class RowPages {
 public:
  explicit RowPages(Scratch& scratch) : scratch_(scratch) {}

  static constexpr std::size_t page_size = std::size_t{1} << 17;  ///< entries; 256 kB

  struct Page {
    std::uint16_t* entries;
    std::uint64_t first;  ///< number of its first entry
  };
  /// A new page of page_size; may be called by several threads at once.
  Page take();
  const std::uint16_t* entry(std::uint64_t at) const { return pages_[at / page_size].data() + at % page_size; }
  std::size_t bytes() const { return pages_.size() * page_size * sizeof(std::uint16_t); }
  /// Gives all pages back, the last one first.
  void clear() {
    while (!pages_.empty()) pages_.pop_back();
  }

 private:
  Scratch& scratch_;
  std::mutex mutex_;
  std::vector<Borrowed<std::uint16_t>> pages_;
};

/// A row of the list as it is stored. The particles around a cell are in a few windows of consecutive particles. The
/// code of a neighbour is the number of its window, in the highest 2 bits, and its number within the window. For each
/// window, `shift` holds what must be added to a code to obtain an index. If the particles around a cell are in more
/// windows, `wide` holds the neighbours' indices.
struct NeighbourRow {
  static constexpr int bits_of_number = 14;
  static constexpr LocalId windows = 4, window_size = 1 << bits_of_number;

  const LocalId* shift;
  const std::uint16_t* coded;  ///< null if `wide` is used
  const LocalId* wide;
  LocalId count;

  LocalId operator[](LocalId k) const {
    return coded == nullptr ? wide[k] : coded[k] + shift[coded[k] >> bits_of_number];
  }
};

/// The page to which one thread writes. A row begins at an even entry with the distance back to the shifts of its cell,
/// in units of two entries, followed by its coded neighbours; or with two zeros, followed by its indices.
class RowWriter {
 public:
  /// Pair loops read whole vectors, past the end of a row.
  static constexpr std::size_t slack = 64;

  /// The shifts of the cell whose rows come next; null if its rows are wide.
  void begin_cell(const std::array<LocalId, NeighbourRow::windows>* shifts) {
    shifts_ = shifts;
    shifts_place_ = nullptr;
  }
  /// Memory for the next row, in which `longest` neighbours, at most 3/8 page_size, may be written.
  std::uint16_t* begin_row(RowPages& pages, std::size_t longest) {
    const bool wide = shifts_ == nullptr;
    const std::size_t entries = 2 + 2 * NeighbourRow::windows + (wide ? 2 : 1) * longest + slack;
    if (static_cast<std::size_t>(end_ - next_) < entries) begin_page(pages.take());
    if (!wide && shifts_place_ == nullptr) write_shifts();
    place_ = first_of_page_ + static_cast<std::uint64_t>(next_ - page_);
    next_[0] = static_cast<std::uint16_t>(wide ? 0 : (next_ - shifts_place_) / 2);
    return next_ + (wide ? 2 : 1);
  }
  void end_row(std::size_t length) { next_ += (shifts_ == nullptr ? 2 + 2 * length : 1 + length + 1) / 2 * 2; }
  /// The place of the row that was begun last.
  std::uint64_t place() const { return place_; }

 private:
  void begin_page(const RowPages::Page& page);
  void write_shifts();

  const std::array<LocalId, NeighbourRow::windows>* shifts_ = nullptr;
  std::uint16_t *next_ = nullptr, *end_ = nullptr, *page_ = nullptr, *shifts_place_ = nullptr;
  std::uint64_t first_of_page_ = 0, place_ = 0;
};

/// The place of a particle's row in the pages, and its length.
struct StoredRow {
  static constexpr std::uint64_t max_at = (std::uint64_t{1} << 48U) - 1;
  std::uint64_t at : 48, count : 16;
};

class NeighbourList {
 public:
  /// More neighbours than this end the run: they mean that all the water within a few h has collapsed into one place,
  /// and the length of the lists grows as the square of the number of particles there.
  static constexpr LocalId max_neighbours = 4096;

  /// The list is borrowed from `scratch` until give_back().
  explicit NeighbourList(std::shared_ptr<Scratch> scratch = std::make_shared<Scratch>())
      : scratch_(std::move(scratch)), pages_(*scratch_) {}

  /// `records` are those of all particles of `order`, ghosts included. O(n).
  template <class T>
  void rebuild(const CellOrder& order, const std::vector<Packed<T>>& records);

  /// Discards all rows.
  void give_back();

  LocalId size() const { return static_cast<LocalId>(rows_.size()); }
  LocalId count(LocalId i) const { return static_cast<LocalId>(rows_[static_cast<std::size_t>(i)].count); }
  /// The row of owned particle i; a full vector may be read from any entry of it.
  NeighbourRow row(LocalId i) const {
    const StoredRow place = rows_[static_cast<std::size_t>(i)];
    const std::uint16_t* const begin = pages_.entry(place.at);
    const auto count = static_cast<LocalId>(place.count);
    const auto index = [](const std::uint16_t* at) { return reinterpret_cast<const LocalId*>(at); };
    if (begin[0] == 0) return {nullptr, nullptr, index(begin + 2), count};
    return {index(begin - 2 * std::ptrdiff_t{begin[0]}), begin + 1, nullptr, count};
  }
  /// Its neighbours.
  std::vector<LocalId> operator[](LocalId i) const;
  /// Number of pairs of the particles of a range; fast if it begins and ends with rows of cells.
  std::int64_t pairs(Range range) const { return pairs_before(range.end) - pairs_before(range.begin); }
  std::int64_t pairs() const { return pairs({0, size()}); }
  /// Bytes of the list that a pass over the particles of a range reads, if it reads each row once.
  double bytes_read(Range range) const {
    const double each = sizeof(StoredRow) + sizeof(std::uint16_t);
    return static_cast<double>(pairs(range)) * sizeof(std::uint16_t) + each * range.size();
  }
  /// Owned particle with more than max_neighbours, −1 if there is none; it and those after it then have empty rows.
  LocalId first_overfull_particle() const { return first_overfull_; }
  /// Without borrowed memory; and the borrowed memory alone.
  std::size_t bytes() const {
    return pairs_of_row_.capacity() * sizeof(pairs_of_row_[0]) + first_of_row_.capacity() * sizeof(LocalId);
  }
  std::size_t borrowed_bytes() const { return rows_.size() * sizeof(rows_[0]) + pages_.bytes(); }

 private:
  std::int64_t pairs_before(LocalId i) const;

  std::shared_ptr<Scratch> scratch_;
  Borrowed<StoredRow> rows_;
  RowPages pages_;
  // For each row of cells its first particle, and the number of pairs of all rows before it; and of all rows.
  std::vector<LocalId> first_of_row_;
  std::vector<std::int64_t> pairs_of_row_;
  LocalId first_overfull_ = -1;
};

}  // namespace trevi

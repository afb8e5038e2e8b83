// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "particles/neighbour_list.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "particles/candidates-inl.hpp"
#include "particles/near-inl.hpp"
#include "particles/neighbour_list.hpp"

#if !defined(TREVI_PARTICLES_SEARCH)
#define TREVI_PARTICLES_SEARCH
namespace trevi {

template <class T>
struct SearchInput {
  const CellOrder& order;
  const std::vector<Packed<T>>& records;
  std::span<typename Packed<T>::Coordinate> memory;  // for Coordinates
};

struct SearchResult {
  Borrowed<StoredRow>& rows;
  RowPages& pages;
  std::int64_t* pairs_of_row;  // of cells
  // The first particle with too many neighbours; the number of particles if there is none.
  std::atomic<LocalId> first_overfull_particle;

  void note_overfull(LocalId i) {
    LocalId known = first_overfull_particle;
    while (i < known && !first_overfull_particle.compare_exchange_weak(known, i)) {
    }
  }
};

// `sum` and the pairs of the particles of a range.
inline std::int64_t count_pairs(const Borrowed<StoredRow>& rows, Range range, std::int64_t sum) {
  for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i)
    sum += static_cast<std::int64_t>(rows[i].count);
  return sum;
}

}  // namespace trevi
#endif

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Contiguous runs of particles that may be neighbours of those of a cell.
class Runs {
 public:
  void add(LocalId begin, LocalId end) {
    if (begin == end) return;
    if (count_ > 0 && runs_[count_ - 1].end == begin) {
      runs_[count_ - 1].end = end;
    } else {
      runs_[count_++] = {begin, end};
    }
  }
  std::span<const Range> all() const { return {runs_.data(), count_}; }

 private:
  std::array<Range, 27> runs_;
  std::size_t count_ = 0;
};

// If rows or columns are periodic: cell by cell, because those beyond the last are elsewhere.
inline Runs cells_around(const CellOrder& order, LocalId k, LocalId c) {
  const CellGrid& grid = order.grid();
  const LocalId row = c / grid.columns(), column = c % grid.columns();
  const auto near = [](bool go_on, LocalId at, LocalId count) {
    return Range{go_on ? at - 1 : std::max(at - 1, 0), go_on ? at + 2 : std::min(at + 2, count)};
  };
  const Range rows = near(grid.is_periodic(1) || order.rows_are_cut(), row, order.rows());
  const Range columns = near(grid.is_periodic(2), column, grid.columns());
  Runs runs;
  for (LocalId plane = k - 1; plane <= k + 1; ++plane) {
    for (LocalId r = rows.begin; r < rows.end; ++r) {
      for (LocalId a = columns.begin; a < columns.end; ++a)
        runs.add(order.cell(plane, r, a).begin, order.cell(plane, r, a).end);
    }
  }
  return runs;
}

// The rows of cells around cell c of plane k (0 is the low ghost plane).
inline Runs runs_around(const CellOrder& order, LocalId k, LocalId c) {
  if (order.has_copies()) return cells_around(order, k, c);
  const LocalId columns = order.grid().columns(), row = c / columns, column = c % columns;
  const Range of_row{std::max(column - 1, 0), std::min(column + 2, columns)}, rows = order.rows_beside(row);
  Runs runs;
  for (LocalId plane = k - 1; plane <= k + 1; ++plane) {
    for (LocalId r = rows.begin; r < rows.end; ++r) {
      const Range run = order.run(plane, r, of_row);
      runs.add(run.begin, run.end);
    }
  }
  return runs;
}

// Codes of the particles around a cell (NeighbourRow), run by run in their order.
class Coding {
 public:
  explicit Coding(std::span<const Range> runs) {
    shifts_.fill(0);
    LocalId begin = 0;  // of the last window
    std::size_t number = 0;
    for (const Range& run : runs) {
      // If the box is periodic, runs of copies come before runs with lower indices.
      if (windows_ == 0 || run.begin < begin || run.end - begin > NeighbourRow::window_size) {
        begin = run.begin;
        if (windows_ == NeighbourRow::windows || run.size() > NeighbourRow::window_size) {
          possible_ = false;
          return;
        }
        const LocalId first_code = windows_ << NeighbourRow::bits_of_number;
        shifts_[static_cast<std::size_t>(windows_++)] = begin - first_code;
      }
      windows_of_runs_[number++] = windows_ - 1;
    }
  }
  bool possible() const { return possible_; }
  const std::array<LocalId, NeighbourRow::windows>* shifts() const { return possible_ ? &shifts_ : nullptr; }
  // The code of the first particle of a run.
  LocalId code_of(std::size_t number, const Range& run) const {
    return possible_ ? run.begin - shifts_[static_cast<std::size_t>(windows_of_runs_[number])] : run.begin;
  }

 private:
  std::array<LocalId, NeighbourRow::windows> shifts_;
  std::array<LocalId, 27> windows_of_runs_;
  LocalId windows_ = 0;
  bool possible_ = true;
};

// What a thread needs for its part of the search.
template <class T>
struct Worker {
  Candidates<T> candidates;
  RowWriter writer;
  std::vector<std::uint16_t> next_row;
};

// Stores the rows of the particles from `self` to `end`, two at a time, and returns the first that is left.
template <class T>
LocalId search_pairs(const SearchInput<T>& in, SearchResult& result, Worker<T>& worker, const Bounds<T>& bounds,
                     Range of_cell, LocalId code) {
  const std::size_t longest = worker.candidates.size() + Candidates<T>::padding;
  worker.next_row.resize(std::max(longest, worker.next_row.size()));
  const auto position = [&](LocalId i) { return bounds.relative(in.records[static_cast<std::size_t>(i)]); };
  const auto end_row = [&](LocalId self, std::size_t found) {
    worker.writer.end_row(found);
    result.rows[static_cast<std::size_t>(self - in.order.low_ghosts())] = {worker.writer.place() & StoredRow::max_at,
                                                                           static_cast<std::uint16_t>(found)};
  };
  LocalId self = of_cell.begin;
  for (; self + 1 < of_cell.end; self += 2) {
    std::uint16_t* const row = worker.writer.begin_row(result.pages, longest);
    const std::array<std::size_t, 2> found =
        near_two<T>(worker.candidates, code + (self - of_cell.begin), {position(self), position(self + 1)},
                    {row, worker.next_row.data()});
    end_row(self, found[0]);
    copy_codes(worker.next_row.data(), found[1], worker.writer.begin_row(result.pages, longest));
    end_row(self + 1, found[1]);
  }
  return self;
}

// Finds the neighbours of the particles of cell c of plane k. Returns false if one of them,
// result.first_overfull_particle, has too many.
template <class T>
bool search_cell(const SearchInput<T>& in, const Coordinates<T>& all, SearchResult& result, Worker<T>& worker,
                 LocalId k, LocalId c) {
  const LocalId begin = in.order.start(k, c), end = in.order.start(k, c + 1);
  if (begin == end) return true;
  Candidates<T>& candidates = worker.candidates;
  const Bounds<T> bounds(in.records.data(), begin, end);
  const Runs runs = runs_around(in.order, k, c);
  const Coding coding(runs.all());
  candidates.clear();
  LocalId self_code = 0;  // of the particle at `begin`
  std::size_t number = 0;
  for (const Range& run : runs.all()) {
    const LocalId code = coding.code_of(number++, run);
    candidates.append(all, run, code, bounds);
    if (run.begin <= begin && begin < run.end) self_code = code + (begin - run.begin);
  }
  candidates.close();
  worker.writer.begin_cell(coding.shifts());
  constexpr auto most = static_cast<std::size_t>(NeighbourList::max_neighbours);
  LocalId self = begin;
  if (coding.possible() && candidates.size() <= most)
    self = search_pairs(in, result, worker, bounds, {begin, end}, self_code);
  for (; self < end; ++self) {
    std::uint16_t* const row =
        worker.writer.begin_row(result.pages, std::min(candidates.size(), most) + Candidates<T>::padding);
    const auto position = bounds.relative(in.records[static_cast<std::size_t>(self)]);
    const LocalId code = self_code + (self - begin);
    const std::size_t found = coding.possible() ? near(candidates, code, position, row)
                                                : near(candidates, code, position, reinterpret_cast<LocalId*>(row));
    const LocalId i = self - in.order.low_ghosts();
    if (found > most) {
      result.note_overfull(i);
      return false;
    }
    worker.writer.end_row(found);
    result.rows[static_cast<std::size_t>(i)] = {worker.writer.place() & StoredRow::max_at,
                                                static_cast<std::uint16_t>(found)};
  }
  return true;
}

template <class T>
void search(const SearchInput<T>& in, SearchResult& result) {
  const LocalId rows = in.order.rows(), columns = in.order.grid().columns();
  const Coordinates<T> all(in.records, in.memory);
  PerThread<Worker<T>> workers;
  for_each_part(in.order.planes() * rows, [&](LocalId part) {
    const LocalId k = part / rows + 1, first = part % rows * columns;
    if (result.first_overfull_particle < in.order.start(k, first) - in.order.low_ghosts()) return;
    for (LocalId c = first; c < first + columns; ++c) {
      if (!search_cell(in, all, result, workers.mine(), k, c)) return;
    }
    const LocalId begin = in.order.start(k, first), end = in.order.start(k, first + columns);
    const LocalId low = in.order.low_ghosts();
    result.pairs_of_row[part] = count_pairs(result.rows, {begin - low, end - low}, 0);
  });
}

void search_single(const SearchInput<float>& in, SearchResult& result) { search(in, result); }
void search_double(const SearchInput<double>& in, SearchResult& result) { search(in, result); }

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(search_single);
HWY_EXPORT(search_double);

RowPages::Page RowPages::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  pages_.push_back(scratch_.borrow<std::uint16_t>(page_size));
  return {pages_.back().data(), (pages_.size() - 1) * page_size};
}

void RowWriter::begin_page(const RowPages::Page& page) {
  page_ = next_ = page.entries;
  end_ = next_ + RowPages::page_size;
  first_of_page_ = page.first;
  shifts_place_ = nullptr;
}

void RowWriter::write_shifts() {
  shifts_place_ = next_;
  std::copy(shifts_->begin(), shifts_->end(), reinterpret_cast<LocalId*>(next_));
  next_ += 2 * shifts_->size();
}

std::vector<LocalId> NeighbourList::operator[](LocalId i) const {
  const NeighbourRow stored = row(i);
  std::vector<LocalId> neighbours;
  for (LocalId k = 0; k < stored.count; ++k) neighbours.push_back(stored[k]);
  return neighbours;
}

template <class T>
void NeighbourList::rebuild(const CellOrder& order, const std::vector<Packed<T>>& records) {
  const auto owned = static_cast<std::size_t>(order.owned());
  give_back();
  rows_ = scratch_->borrow<StoredRow>(owned);
  first_of_row_.assign(order.row_starts().begin(), order.row_starts().end());
  pairs_of_row_.assign(first_of_row_.size(), 0);
  SearchResult result{rows_, pages_, pairs_of_row_.data(), order.owned()};
  constexpr std::size_t lanes = 16;  // of a vector, at most
  const auto memory = scratch_->borrow_briefly<typename Packed<T>::Coordinate>(3 * (records.size() + lanes));
  if constexpr (std::is_same_v<T, float>) {
    HWY_DYNAMIC_DISPATCH(search_single)({order, records, {memory.data(), memory.size()}}, result);
  } else {
    HWY_DYNAMIC_DISPATCH(search_double)({order, records, {memory.data(), memory.size()}}, result);
  }
  first_overfull_ = result.first_overfull_particle < order.owned() ? result.first_overfull_particle.load() : -1;
  if (first_overfull_ >= 0) {
    for (auto i = static_cast<std::size_t>(first_overfull_); i < rows_.size(); ++i) rows_[i] = {0, 0};
    for (std::size_t row = 0; row + 1 < first_of_row_.size(); ++row)
      pairs_of_row_[row] = count_pairs(rows_, {first_of_row_[row], first_of_row_[row + 1]}, 0);
  }
  std::exclusive_scan(pairs_of_row_.begin(), pairs_of_row_.end(), pairs_of_row_.begin(), std::int64_t{0});
}

void NeighbourList::give_back() {
  pages_.clear();
  rows_.give_back();
}

// Number of pairs of the particles before this one.
std::int64_t NeighbourList::pairs_before(LocalId i) const {
  if (i == 0) return 0;
  if (i == size() && !pairs_of_row_.empty()) return pairs_of_row_.back();
  const auto after = std::upper_bound(first_of_row_.begin(), first_of_row_.end(), i);
  if (after == first_of_row_.begin()) return 0;  // no list yet
  const auto row = static_cast<std::size_t>(after - first_of_row_.begin() - 1);
  return count_pairs(rows_, {first_of_row_[row], i}, pairs_of_row_[row]);
}

template void NeighbourList::rebuild(const CellOrder&, const std::vector<Packed<float>>&);
template void NeighbourList::rebuild(const CellOrder&, const std::vector<Packed<double>>&);

}  // namespace trevi
#endif

// Fields with several numbers per cell of the projection's grid, laid out for loops over the cells of a row. A row is
// divided into groups of four cells ("fours"); each group stores the first number of its four cells, then the second,
// and so on. Planes, and the ring of rows around each, are those of ProjectionGrid. The memory of the groups is that of
// RowStorage, which has none where there is no water: the cells there are 0. Code that writes a row writes or clears
// all of its cells that have memory. Not collective.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <span>

#include "domain/halo.hpp"
#include "projection/affine.hpp"
#include "projection/grid.hpp"

namespace trevi {

/// The numbers of a struct that consists of numbers only, in their order.
template <class T>
using NumbersOf = std::array<Real, sizeof(T) / sizeof(Real)>;

/// The first numbers of cell c of a row, as a T. The row has `numbers` for each cell.
template <class T>
T cell_of(const FourCells* row, std::size_t numbers, LocalId c) {
  constexpr LocalId four = FourCells::count;
  NumbersOf<T> value;
  const FourCells* const from = row + static_cast<std::size_t>(c / four) * numbers;
  for (std::size_t q = 0; q < value.size(); ++q) value[q] = from[q].of[c % four];
  return std::bit_cast<T>(value);
}

/// The groups of four cells of a row. A group without memory is 0 and must not be written.
template <class Cells>
struct FoursOfRow {
  Cells* values;
  const std::uint32_t* places;
  std::uint32_t nowhere;
  std::size_t numbers;  // of a cell

  bool has(std::size_t four) const { return places[four] != nowhere; }
  /// The first number of the cells of a group.
  Cells* operator[](std::size_t four) const { return values + places[four] * numbers; }
  /// The groups from `four` on.
  FoursOfRow from(std::size_t four) const { return {values, places + four, nowhere, numbers}; }
  /// The same groups with their numbers from q on.
  FoursOfRow from_number(std::size_t q) const { return {values + q, places, nowhere, numbers}; }
  /// The same for reading.
  operator FoursOfRow<const Cells>() const { return {values, places, nowhere, numbers}; }
};
using RowToRead = FoursOfRow<const FourCells>;
using RowToWrite = FoursOfRow<FourCells>;

/// Number q of cell c of a row.
template <class Cells>
auto* number_of(const FoursOfRow<Cells>& row, LocalId c, std::size_t q = 0) {
  constexpr LocalId four = FourCells::count;
  return &row[static_cast<std::size_t>(c / four)][q].of[c % four];
}

/// Clears those of the cells [columns) of a row that have memory.
inline void clear_cells(const RowToWrite& row, Range columns) {
  constexpr LocalId four = FourCells::count;
  for (LocalId c = columns.begin; c < columns.end;) {
    const LocalId end = std::min(columns.end, (c / four + 1) * four);
    const auto f = static_cast<std::size_t>(c / four);
    for (std::size_t q = 0; q < row.numbers && row.has(f); ++q) std::fill_n(row[f][q].of + c % four, end - c, 0.0);
    c = end;
  }
}

class CellFields {
 public:
  /// `numbers` for each cell, and `more` for those in planes and rows that are exchanged.
  explicit CellFields(std::size_t numbers, std::size_t more = 0) : numbers_(numbers), in_exchanged_(numbers + more) {}

  /// Borrows memory for the present grid until give_back(). It is 0 in exchanged planes and uninitialised elsewhere.
  void borrow(Scratch& scratch, const RowStorage& storage) {
    borrow(storage, [&](std::size_t size) { return scratch.borrow<FourCells>(size); });
  }
  /// The same for a stage that ends before any Loan does: the memory may be lent.
  void borrow_briefly(Scratch& scratch, const RowStorage& storage) {
    borrow(storage, [&](std::size_t size) { return scratch.borrow_briefly<FourCells>(size); });
  }
  void give_back() { values_.give_back(); }
  /// Takes the memory of other fields, of which those numbers are kept, in rising order, and gives back the rest of it.
  template <std::size_t count>
  void take(CellFields& other, const std::array<std::size_t, count>& kept) {
    assert(count == numbers_ && count == in_exchanged_);
    storage_ = other.storage_;
    values_ = std::move(other.values_);
    const auto from = [&other](std::size_t place) {
      return place > other.storage_->exchanged() ? other.rest_ + place * other.numbers_ : place * other.in_exchanged_;
    };
    // At a time as many places as end before the first that is still to be read.
    for (std::size_t begin = 0, end = 0; begin < storage_->size(); begin = end) {
      end = std::min(std::max(begin + 1, from(begin) / count), storage_->size());
      for_each_index({static_cast<LocalId>(begin), static_cast<LocalId>(end)}, [&](std::size_t place) {
        for (std::size_t q = 0; q < count; ++q) values_[place * count + q] = values_[from(place) + kept[q]];
      });
    }
    values_.shrink(storage_->size() * count);
  }

  /// Row (k, r); −1 and rows() are the rows of the ring.
  RowToWrite row(LocalId k, LocalId r) {
    if (rest_ > 0 && storage_->is_exchanged(k, r))
      return {values_.data(), storage_->places(k, r), storage_->nowhere(), in_exchanged_};
    return {values_.data() + rest_, storage_->places(k, r), storage_->nowhere(), numbers_};
  }
  RowToRead row(LocalId k, LocalId r) const { return const_cast<CellFields*>(this)->row(k, r); }
  /// Number q of a cell. To be written only if the cell has memory.
  Real& number(std::size_t q, LocalId k, LocalId r, LocalId c) { return *number_of(row(k, r), c, q); }
  Real number(std::size_t q, LocalId k, LocalId r, LocalId c) const { return *number_of(row(k, r), c, q); }
  /// Clears the cells of a row except `kept`.
  void clear_around(LocalId k, LocalId r, Range kept) {
    clear_cells(row(k, r), {0, kept.begin});
    clear_cells(row(k, r), {kept.end, four_cells * static_cast<LocalId>(storage_->per_row())});
  }
  /// Clears a row.
  void clear(LocalId k, LocalId r) { clear_around(k, r, {0, 0}); }
  /// The first numbers of a cell, as a T.
  template <class T>
  T cell(LocalId k, LocalId r, LocalId c) const {
    return cell_of<T>(row(k, r)[four(c)], 0, static_cast<LocalId>(lane(c)));
  }
  template <class T>
  void set(LocalId k, LocalId r, LocalId c, const T& value) {
    FourCells* const to = row(k, r)[four(c)];
    const auto all = std::bit_cast<NumbersOf<T>>(value);
    for (std::size_t q = 0; q < all.size(); ++q) to[q].of[lane(c)] = all[q];
  }

  /// FourCells that the `numbers` of all cells of one row take.
  std::size_t per_row() const { return storage_->per_row() * numbers_; }
  /// Starts the exchange of boundary planes and, where rows are cut, of boundary rows.
  void start(Halo& halo) {
    const LocalId planes = storage_->shape().cells.planes.end - 2;
    halo.start_planes(planes, [this](LocalId k, const Range& rows) {
      const auto [first, count] = storage_->exchanged_plane(k, rows);
      return std::as_writable_bytes(std::span(values_.data() + first * in_exchanged_, count * in_exchanged_));
    });
    if (!halo.rows_are_cut()) return;
    halo.start_rows(
        {planes, storage_->per_row() * in_exchanged_ * sizeof(FourCells)},
        [this](LocalId k, LocalId r, int) { return values_.data() + storage_->places(k, r)[0] * in_exchanged_; });
  }
  std::size_t numbers() const { return numbers_; }

 private:
  template <class Borrow>
  void borrow(const RowStorage& storage, const Borrow& memory) {
    storage_ = &storage;
    rest_ = (storage_->exchanged() + 1) * (in_exchanged_ - numbers_);
    values_.give_back();
    values_ = memory(rest_ + storage_->size() * numbers_);
    // Including the group that stands for all others, which has as many numbers.
    const std::size_t first = (storage_->exchanged() + 1) * in_exchanged_;
    for_each_index({0, static_cast<LocalId>(first)}, [&](std::size_t i) { values_[i] = {}; });
  }
  static constexpr LocalId four_cells = FourCells::count;
  static std::size_t four(LocalId c) { return static_cast<std::size_t>(c / four_cells); }
  static std::size_t lane(LocalId c) { return static_cast<std::size_t>(c) % FourCells::count; }

  std::size_t numbers_, in_exchanged_;
  std::size_t rest_ = 0;  // offset of the places in rows that are not exchanged
  const RowStorage* storage_ = nullptr;
  Borrowed<FourCells> values_;
};

/// Calls work(state, k, r) for the rows of all owned planes, first for the planes at either end and the rows at cuts.
/// send() then starts to send these to the neighbours while the others are processed. State is as in
/// for_each_row_with().
template <class State, class Work, class Send>
void for_each_row_and_send(const ProjectionGrid& grid, Halo& halo, const Work& work, const Send& send) {
  const LocalId rows = grid.rows(), last = grid.planes();
  if (!halo.has_neighbours()) return for_each_row_with<State>(grid.rows_of({1, last + 1}), work);
  const LocalId ends = grid.rows_are_cut() ? std::min(rows, 2) : 0;  // rows of the planes between that are sent
  const LocalId of_planes = std::min(last, 2) * rows, between = std::max(last - 2, 0);
  constexpr LocalId part_size = 16;  // a plane has few rows for all threads
  for_each_part({0, of_planes + between * ends}, part_size, [&](Range part) {
    State state;
    for (LocalId i = part.begin; i < part.end; ++i) {
      const LocalId j = i - of_planes;
      if (j < 0) work(state, i < rows ? 1 : last, i % rows);
      // First rows and then last ones, so that consecutive rows are adjacent.
      if (j >= 0) work(state, 2 + j % between, j < between ? 0 : rows - 1);
    }
  });
  send();
  CellRows others = grid.rows_of({2, last});
  others.rows -= ends;
  others.first_row = ends > 0 ? 1 : 0;
  if (last > 2 && others.rows > 0) for_each_row_with<State>(others, work);
  halo.finish();
}
template <class State, class Work>
void for_each_row_and_send(const ProjectionGrid& grid, Halo& halo, CellFields& field, const Work& work) {
  for_each_row_and_send<State>(grid, halo, work, [&] { field.start(halo); });
}

/// Calls work(state, k, r) for the owned rows of a few planes, which are divided among the threads.
template <class State, class Work>
void for_each_row_of_few(const ProjectionGrid& grid, Range planes, const Work& work) {
  constexpr LocalId fewest = 8, parts_of_thread = 2;
  const LocalId rows = grid.rows(), all = planes.size() * rows;
  const LocalId parts = thread_count() == 1 ? 1 : parts_of_thread * thread_count();
  for_each_part(Range{planes.begin * rows, planes.end * rows}, std::max((all + parts - 1) / parts, fewest),
                [&](Range part) {
                  State state;
                  for (LocalId i = part.begin; i < part.end; ++i) work(state, i / rows, i % rows);
                });
}

/// Computes something for owned planes in any order, but only once for each: work(state, k, r) for their rows.
template <class State, class Work>
class PlanesOnce {
 public:
  PlanesOnce(const ProjectionGrid& grid, const Work& work)
      : grid_(grid), work_(work), found_(static_cast<std::size_t>(grid.planes()) + 1, 0) {}
  /// For those of the planes that are owned and have not been processed yet.
  void find(Range planes) {
    planes = {std::max(planes.begin, 1), std::min(planes.end, grid_.planes() + 1)};
    if (planes.size() <= 0) return;
    for_each_row_of_few<State>(grid_, planes, [&](State& state, LocalId k, LocalId r) {
      if (found_[static_cast<std::size_t>(k)] == 0) work_(state, k, r);
    });
    std::fill(found_.begin() + planes.begin, found_.begin() + planes.end, 1);
  }
  /// For the plane with this number, from 1, counted from each end that has a neighbouring rank.
  void find_at_ends(LocalId number) {
    const std::array<bool, 2>& exchanged = grid_.storage().shape().exchanged;
    const LocalId upper = grid_.planes() + 1 - number;
    if (exchanged[0]) find({number, number + 1});
    if (exchanged[1]) find({upper, upper + 1});
  }

 private:
  const ProjectionGrid& grid_;
  const Work& work_;
  std::vector<char> found_;
};

/// The computation for the rows of planes, work(state, k, r), and the call that sends its result to the neighbours.
template <class Work, class Send>
struct PlaneStage {
  Work work;
  Send send;
};
template <class Work, class Send>
PlaneStage(Work, Send) -> PlaneStage<Work, Send>;  // deduced by clang itself from version 17 on

/// Runs two stages in memory for few planes (ProjectionGrid::storage_rolling()). The second stage needs the result of
/// the first for the surrounding planes. use(planes) is then called for consecutive runs of owned planes for which the
/// result of the second stage is also known on the surrounding planes, including what neighbours have sent. Planes that
/// other ranks need come first, which is possible because the planes at the ends do not share memory. Collective.
template <class State, class First, class Second, class Use>
void for_each_plane_in_turn(const ProjectionGrid& grid, Halo& halo, const First& first, const Second& second,
                            const Use& use) {
  const LocalId last = grid.planes(), step = grid.rolling_planes();
  if (grid.rows_are_cut()) {
    for_each_row_and_send<State>(grid, halo, first.work, first.send);
    for_each_row_and_send<State>(grid, halo, second.work, second.send);
    return use(Range{1, last + 1});
  }
  PlanesOnce<State, decltype(first.work)> firsts(grid, first.work);
  PlanesOnce<State, decltype(second.work)> seconds(grid, second.work);
  if (halo.has_neighbours()) {
    firsts.find_at_ends(1);
    first.send();
    firsts.find_at_ends(2);
    halo.finish();
    seconds.find_at_ends(1);
    second.send();
  }
  for (LocalId begin = 1; begin <= last; begin += step) {
    const LocalId end = std::min(begin + step, last + 1);
    firsts.find({begin, end + 2});
    seconds.find({begin, end + 1});
    use(Range{begin, end});
  }
  halo.finish();
}

}  // namespace trevi

// Numbers of the cells of the projection's grid, several of each cell, laid out for loops over the cells of a row: of a
// row four cells after another, of these first the first number of all, then the second of all. Planes, and the ring
// of rows around each, are those of ProjectionGrid, the memory of fours that of RowStorage, which has none where there
// is no water: such cells are 0. Whoever writes a row writes all of its cells that there is memory for, or clears them.
// Not collective.
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

/// A struct that is nothing but numbers, as these in their order.
template <class T>
using NumbersOf = std::array<Real, sizeof(T) / sizeof(Real)>;

/// The first numbers of a cell of a row, of `numbers` each, as those of a T.
template <class T>
T cell_of(const FourCells* row, std::size_t numbers, LocalId c) {
  constexpr LocalId four = FourCells::count;
  NumbersOf<T> value;
  const FourCells* const from = row + static_cast<std::size_t>(c / four) * numbers;
  for (std::size_t q = 0; q < value.size(); ++q) value[q] = from[q].of[c % four];
  return std::bit_cast<T>(value);
}

/// The fours of a row of cells. There may be no memory for a four: then it is 0, and must not be written.
template <class Cells>
struct FoursOfRow {
  Cells* values;
  const std::uint32_t* places;
  std::uint32_t nowhere;
  std::size_t numbers;  // of a cell

  bool has(std::size_t four) const { return places[four] != nowhere; }
  /// The first number of the cells of a four.
  Cells* operator[](std::size_t four) const { return values + places[four] * numbers; }
  /// Those from a four on.
  FoursOfRow from(std::size_t four) const { return {values, places + four, nowhere, numbers}; }
  /// Their numbers from one on.
  FoursOfRow from_number(std::size_t q) const { return {values + q, places, nowhere, numbers}; }
  /// The same to read.
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

/// Clears the cells [columns) of a row of which there is memory.
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
  /// `numbers` of each cell, and `more` of those in planes and rows that are exchanged.
  explicit CellFields(std::size_t numbers, std::size_t more = 0) : numbers_(numbers), in_exchanged_(numbers + more) {}

  /// Memory for the grid as it is now, until give_back(): 0 in planes that neighbours exchange; else not yet written.
  void borrow(Scratch& scratch, const RowStorage& storage) {
    borrow(storage, [&](std::size_t size) { return scratch.borrow<FourCells>(size); });
  }
  /// The same for a stage that ends before any loan does.
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
  /// Number q of a cell; one that there is memory for, to write it.
  Real& number(std::size_t q, LocalId k, LocalId r, LocalId c) { return *number_of(row(k, r), c, q); }
  Real number(std::size_t q, LocalId k, LocalId r, LocalId c) const { return *number_of(row(k, r), c, q); }
  /// Clears the cells of a row but for `kept`.
  void clear_around(LocalId k, LocalId r, Range kept) {
    clear_cells(row(k, r), {0, kept.begin});
    clear_cells(row(k, r), {kept.end, four_cells * static_cast<LocalId>(storage_->per_row())});
  }
  /// Clears a row.
  void clear(LocalId k, LocalId r) { clear_around(k, r, {0, 0}); }
  /// The first numbers of a cell as those of a T.
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

  /// Memory for `numbers` of the cells of one row.
  std::size_t per_row() const { return storage_->per_row() * numbers_; }
  /// Begins to exchange boundary planes, and rows where these are cut.
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
    // With the four that stands for all others, which has as many numbers, too.
    const std::size_t first = (storage_->exchanged() + 1) * in_exchanged_;
    for_each_index({0, static_cast<LocalId>(first)}, [&](std::size_t i) { values_[i] = {}; });
  }
  static constexpr LocalId four_cells = FourCells::count;
  static std::size_t four(LocalId c) { return static_cast<std::size_t>(c / four_cells); }
  static std::size_t lane(LocalId c) { return static_cast<std::size_t>(c) % FourCells::count; }

  std::size_t numbers_, in_exchanged_;
  std::size_t rest_ = 0;  // where places in rows that are not exchanged are counted from
  const RowStorage* storage_ = nullptr;
  Borrowed<FourCells> values_;
};

/// work(state, k, r) for the rows of all own planes, those of the planes at either end first, and those at cuts: send()
/// then lets these travel to the neighbours while the others are worked on. A State as for_each_row_with() has it.
template <class State, class Work, class Send>
void for_each_row_and_send(const ProjectionGrid& grid, Halo& halo, const Work& work, const Send& send) {
  const LocalId rows = grid.rows(), last = grid.planes();
  if (!halo.has_neighbours()) return for_each_row_with<State>(grid.rows_of({1, last + 1}), work);
  const LocalId ends = grid.rows_are_cut() ? std::min(rows, 2) : 0;  // rows of the planes between that travel
  const LocalId of_planes = std::min(last, 2) * rows, between = std::max(last - 2, 0);
  constexpr LocalId part_size = 16;  // a plane has few rows for all threads
  for_each_part({0, of_planes + between * ends}, part_size, [&](Range part) {
    State state;
    for (LocalId i = part.begin; i < part.end; ++i) {
      const LocalId j = i - of_planes;
      if (j < 0) work(state, i < rows ? 1 : last, i % rows);
      // First rows and then last ones, so that one comes beside the one before.
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

/// work(state, k, r) for the own rows of a few planes, of which each thread gets some.
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

/// What is found for own planes in any order, and once for each: work(state, k, r) for their rows.
template <class State, class Work>
class PlanesOnce {
 public:
  PlanesOnce(const ProjectionGrid& grid, const Work& work)
      : grid_(grid), work_(work), found_(static_cast<std::size_t>(grid.planes()) + 1, 0) {}
  /// For those of them that are own ones and have not been found.
  void find(Range planes) {
    planes = {std::max(planes.begin, 1), std::min(planes.end, grid_.planes() + 1)};
    if (planes.size() <= 0) return;
    for_each_row_of_few<State>(grid_, planes, [&](State& state, LocalId k, LocalId r) {
      if (found_[static_cast<std::size_t>(k)] == 0) work_(state, k, r);
    });
    std::fill(found_.begin() + planes.begin, found_.begin() + planes.end, 1);
  }
  /// For the plane of that number, from 1, at each end beyond which other ranks go on.
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

/// What is found for the rows of planes, work(state, k, r), and how it travels to the neighbours.
template <class Work, class Send>
struct PlaneStage {
  Work work;
  Send send;
};
template <class Work, class Send>
PlaneStage(Work, Send) -> PlaneStage<Work, Send>;  // which clang finds itself from version 17 on

/// Two stages in memory of few planes (ProjectionGrid::storage_rolling()), of which the second needs what the first has
/// found of the planes around, and then use(planes) for runs of own planes, one after the other, of which the second
/// has found those around, too, but for what neighbours have sent, which is there after halo.finish(). What other ranks
/// need is first; as planes at the ends do not share memory, it may be. Collective.
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

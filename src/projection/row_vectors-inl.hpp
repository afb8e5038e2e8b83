// Vectors of cells of a row, and sums over tents. Included once per instruction set.
#if defined(TREVI_PROJECTION_ROW_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_PROJECTION_ROW_VECTORS_INL
#undef TREVI_PROJECTION_ROW_VECTORS_INL
#else
#define TREVI_PROJECTION_ROW_VECTORS_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>

#include "projection/parameters.hpp"
#include "projection/row_fits.hpp"
#include "projection/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

static_assert(max_lanes == FourCells::count);

/// The next cells of a row, as many as a vector has lanes. If a row consists of FourCells, whole vectors are written.
struct Part {
  std::size_t begin, end;
  HWY_INLINE Part& operator++() {
    begin += hn::Lanes(Wide());
    return *this;
  }
  HWY_INLINE const Real* of(const FourCells* row, std::size_t numbers) const {
    return row[begin / max_lanes * numbers].of + begin % max_lanes;
  }
  HWY_INLINE Real* of(FourCells* row, std::size_t numbers) const {
    return row[begin / max_lanes * numbers].of + begin % max_lanes;
  }
  HWY_INLINE const Real* of(const RowToRead& row) const { return row[begin / max_lanes]->of + begin % max_lanes; }
  HWY_INLINE Real* of(const RowToWrite& row) const { return row[begin / max_lanes]->of + begin % max_lanes; }
  HWY_INLINE bool is_in(const RowToWrite& row) const { return row.has(begin / max_lanes); }
  HWY_INLINE bool is_in(const RowToRead& row) const { return row.has(begin / max_lanes); }
};
HWY_INLINE V load(const Real* row, const Part& part) { return hn::LoadU(Wide(), row + part.begin); }
/// Writes nothing beyond the end, because that memory may belong to another thread.
HWY_INLINE void store(V v, const Part& part, Real* row) {
  const Wide d;
  Real* const to = row + part.begin;
  if (part.begin + hn::Lanes(d) <= part.end) return hn::StoreU(v, d, to);
  alignas(64) Real last[max_lanes];
  hn::Store(v, d, last);
  std::copy_n(last, part.end - part.begin, to);
}

/// Numbers of cells, `stride` apart from each other in memory.
template <std::size_t stride = max_lanes>
struct Numbers {
  const Real* first;
  HWY_INLINE V operator[](std::size_t q) const { return hn::LoadU(Wide(), first + q * stride); }
};
HWY_INLINE void write(V v, Real* numbers, std::size_t q) { hn::Store(v, Wide(), numbers + q * max_lanes); }

// Adjacent cells along coordinate axis b, and the sums over them. The cells below and above have the weight w, and
// their coordinates are relative to their own corners, one cell lower and one cell higher. Each sum is therefore own +
// w (low + high + a correction from other numbers for the shift of the coordinates).
template <std::size_t from, std::size_t to>
struct Beside {
  Numbers<from> low, own, high;
  Real* out;
  HWY_INLINE V difference(std::size_t q) const { return hn::Sub(high[q], low[q]); }
  HWY_INLINE V sum(std::size_t q) const { return hn::Add(high[q], low[q]); }
  HWY_INLINE void write(std::size_t q, V beside) const {
    hn::StoreU(hn::MulAdd(set(projection::tent), beside, own[q]), Wide(), out + q * to);
  }
};

// The numbers of a Flow, of Moments and of an AffineMap.
struct FlowSums {
  static constexpr std::size_t count = numbers::flow;
  template <std::size_t b, std::size_t first = 0, class Cells>
  static HWY_INLINE void add(const Cells& cells) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t uy = first + 3 + 3 * a;
      cells.write(first + a, cells.sum(first + a));
      const V shift = cells.difference(first + a);
      for (std::size_t j = 0; j < 3; ++j)
        cells.write(uy + j, j == b ? hn::Add(cells.sum(uy + j), shift) : cells.sum(uy + j));
    }
  }
};
struct MomentSums {
  static constexpr std::size_t count = numbers::moments;
  template <std::size_t b, class Cells>
  static HWY_INLINE void add(const Cells& cells) {
    constexpr std::size_t c = (b + 1) % 3, d = (b + 2) % 3;
    const V n = cells.sum(0), more = cells.difference(0);
    const V3 shift = {cells.difference(1), cells.difference(2), cells.difference(3)};
    cells.write(0, n);
    cells.write(1 + b, hn::Add(cells.sum(1 + b), more));
    cells.write(1 + c, cells.sum(1 + c));
    cells.write(1 + d, cells.sum(1 + d));
    cells.write(4 + b, hn::Add(cells.sum(4 + b), hn::MulAdd(set(2), shift[b], n)));
    cells.write(4 + c, cells.sum(4 + c));
    cells.write(4 + d, cells.sum(4 + d));
    cells.write(4 + b + c + 2, hn::Add(cells.sum(4 + b + c + 2), shift[c]));
    cells.write(4 + b + d + 2, hn::Add(cells.sum(4 + b + d + 2), shift[d]));
    cells.write(4 + c + d + 2, cells.sum(4 + c + d + 2));
    FlowSums::add<b, 10>(cells);
    cells.write(22, cells.sum(22));
  }
};
struct MapSums {
  static constexpr std::size_t count = numbers::map;
  template <std::size_t b, class Cells>
  static HWY_INLINE void add(const Cells& cells) {
    cells.write(0, cells.sum(0));
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t slope = 4 + 3 * a;
      cells.write(1 + a, hn::Sub(cells.sum(1 + a), cells.difference(slope + b)));
      for (std::size_t j = 0; j < 3; ++j) cells.write(slope + j, cells.sum(slope + j));
    }
  }
};

template <class Sums, class Cells>
HWY_INLINE void add_beside(std::size_t axis, const Cells& cells) {
  return axis == 0 ? Sums::template add<0>(cells) : Sums::template add<1>(cells);
}

using SixCells = TentMemory::SixCells;
constexpr std::size_t in_six = sizeof(SixCells) / sizeof(Real);

/// The cells of a row, beginning at the start of its first group of four.
HWY_INLINE Part cells_of(const RowsAround& rows) { return {rows.begin / max_lanes * max_lanes, rows.end}; }
/// The same with one more cell at either end, up to the end of the last group of four.
HWY_INLINE Part cells_around(const RowsAround& rows) {
  const std::size_t begin = rows.begin - (rows.begin > 0 ? 1 : 0), end = std::min(rows.end + 1, rows.columns);
  return {begin / max_lanes * max_lanes, (end + max_lanes - 1) / max_lanes * max_lanes};
}

// Whether the sums of a group of four cells are needed: its row holds something in this group, or its row holds
// something in a neighbouring group and one of the surrounding rows holds something in this group.
HWY_INLINE bool is_asked(const RowsAround& rows, std::size_t f) {
  const std::size_t last = (rows.columns - 1) / max_lanes;
  const auto is_own = [&](std::size_t of) { return rows.rows[1][1].has(of); };
  if (is_own(f)) return true;
  const bool below = f > 0 ? is_own(f - 1) : rows.repeats && is_own(last);
  const bool above = f < last ? is_own(f + 1) : rows.repeats && is_own(0);
  if (!below && !above) return false;
  for (const auto& of_row : rows.rows) {
    for (const RowToRead& row : of_row)
      if (row.has(f)) return true;
  }
  return false;
}

// The sums across planes for a group of four cells of row i of the surrounding rows.
template <class Sums>
HWY_INLINE void sum_planes(const RowsAround& rows, std::size_t i, std::size_t f, FourCells* out) {
  const std::array<RowToRead, 3>& planes = rows.rows[i];
  if (!planes[0].has(f) && !planes[1].has(f) && !planes[2].has(f)) {
    std::fill_n(out + f * Sums::count, Sums::count, FourCells{});
    return;
  }
  for (Part part{f * max_lanes, (f + 1) * max_lanes}; part.begin < part.end; ++part) {
    const auto of_plane = [&](std::size_t j) { return Numbers<>{part.of(planes[j])}; };
    add_beside<Sums>(rows.axis[0],
                     Beside<max_lanes, max_lanes>{of_plane(0), of_plane(1), of_plane(2), part.of(out, Sums::count)});
  }
}

// Copies the values of the cells before and after each group of four, from the other end where the row is periodic.
template <std::size_t count>
HWY_INLINE void join_fours(const RowsAround& rows, SixCells* sums) {
  const Part cells = cells_around(rows);
  const std::size_t first = cells.begin / max_lanes, end = cells.end / max_lanes;
  for (std::size_t j = first; j < end; ++j) {
    for (std::size_t q = j * count; q < (j + 1) * count; ++q) {
      sums[q].of[0] = j > first ? sums[q - count].of[max_lanes] : 0;
      sums[q].of[max_lanes + 1] = j + 1 < end ? sums[q + count].of[1] : 0;
    }
  }
  const std::size_t last = (rows.columns - 1) / max_lanes;
  for (std::size_t q = 0; q < count && rows.repeats; ++q) {
    Real* const highest = sums[last * count + q].of + (rows.columns - last * max_lanes);
    sums[q].of[0] = highest[0];
    highest[1] = sums[q].of[1];
  }
}

/// Sums over the surrounding rows, for the groups in which the row holds something; null if no cell is needed.
template <class Sums>
HWY_INLINE const SixCells* sum_across(const RowsAround& rows) {
  if (rows.begin == rows.end) return nullptr;
  std::array<TentMemory::Row*, 3> across;
  for (std::size_t i = 0; i < 3; ++i)
    across[i] = &rows.memory.row(rows.k, rows.r + static_cast<LocalId>(i) - 1, Sums::count, rows.columns);
  SixCells* const sums = rows.memory.sums(Sums::count, rows.columns).data();
  const Part around = cells_around(rows);
  for (std::size_t f = around.begin / max_lanes; f < around.end / max_lanes; ++f) {
    if (!is_asked(rows, f)) {
      std::fill_n(sums + f * Sums::count, Sums::count, SixCells{});
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if ((rows.is_layer && i != 1) || across[i]->is_known[f] != 0) continue;  // beside a layer everything is 0
      sum_planes<Sums>(rows, i, f, across[i]->values.data());
      across[i]->is_known[f] = 1;
    }
    for (Part part{f * max_lanes, (f + 1) * max_lanes}; part.begin < part.end; ++part) {
      const auto of_row = [&](std::size_t i) {
        return Numbers<>{part.of(static_cast<const FourCells*>(across[i]->values.data()), Sums::count)};
      };
      Real* const out = sums[f * Sums::count].of + part.begin % max_lanes + 1;
      add_beside<Sums>(rows.axis[1], Beside<max_lanes, in_six>{of_row(0), of_row(1), of_row(2), out});
    }
  }
  join_fours<Sums::count>(rows, sums);
  return sums;
}

/// The tents of the next cells.
template <class Sums>
class TentSums {
 public:
  HWY_INLINE TentSums(const SixCells* sums, const Part& part) {
    const Real* const low = sums[part.begin / max_lanes * Sums::count].of + part.begin % max_lanes;
    Sums::template add<2>(Beside<in_six, max_lanes>{{low}, {low + 1}, {low + 2}, value_});
  }
  /// The numbers from q on.
  HWY_INLINE Numbers<> from(std::size_t q = 0) const { return {value_ + q * max_lanes}; }

 private:
  alignas(64) Real value_[Sums::count * max_lanes];
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();
#endif

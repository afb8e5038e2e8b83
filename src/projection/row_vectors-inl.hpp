// Vectors of cells of a row, and the tents over them. Included once per instruction set.
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

/// The next cells of a row, up to `end`.
struct Part {
  std::size_t begin, end;
};
HWY_INLINE V load(const ConstCellRow& row, std::size_t q) { return hn::LoadU(Wide(), row.first + q * row.width); }
HWY_INLINE V load(const Real* row, const Part& part) { return hn::LoadU(Wide(), row + part.begin); }
/// Nothing beyond the end is written: it is another number's, or another thread's.
HWY_INLINE void store(V v, const Part& part, const CellRow& row, std::size_t q) {
  const Wide d;
  Real* const to = row.first + q * row.width + part.begin;
  if (part.begin + hn::Lanes(d) <= part.end) return hn::StoreU(v, d, to);
  alignas(64) Real last[most_lanes];
  hn::Store(v, d, last);
  std::copy_n(last, part.end - part.begin, to);
}

// What is added of cells beside one another along a coordinate axis: of those below and above, whose own coordinates
// are one cell less and one more, w of each number; then what the coordinates make of that (shift).
struct Beside {
  ConstCellRow low, high;
  std::size_t axis;
  HWY_INLINE V difference(std::size_t q) const { return hn::Sub(load(high, q), load(low, q)); }
  HWY_INLINE V sum(std::size_t q) const { return hn::Add(load(high, q), load(low, q)); }
};
HWY_INLINE void add(const CellRow& to, std::size_t q, Real w, V v) {
  Real* const at = to.first + q * to.width;
  hn::StoreU(hn::MulAdd(set(w), v, hn::LoadU(Wide(), at)), Wide(), at);
}

// Numbers of a Flow, of Moments and of an AffineMap: how many there are and, with those of the cells beside, their
// shift.
struct FlowSums {
  static constexpr std::size_t count = numbers::flow;
  static HWY_INLINE void shift(const Beside& by, const CellRow& to) {
    for (std::size_t a = 0; a < 3; ++a) add(to, 3 + 3 * a + by.axis, projection::tent, by.difference(a));
  }
};
struct MomentSums {
  static constexpr std::size_t count = numbers::moments;
  static HWY_INLINE void shift(const Beside& by, const CellRow& to) {
    constexpr Real w = projection::tent;
    const std::size_t b = by.axis, c = (b + 1) % 3, d = (b + 2) % 3;
    add(to, 1 + b, w, by.difference(0));
    add(to, 4 + b, w, hn::MulAdd(set(2), by.difference(1 + b), by.sum(0)));
    add(to, 4 + b + c + 2, w, by.difference(1 + c));
    add(to, 4 + b + d + 2, w, by.difference(1 + d));
    for (std::size_t a = 0; a < 3; ++a) add(to, 13 + 3 * a + b, w, by.difference(10 + a));
  }
};
struct MapSums {
  static constexpr std::size_t count = numbers::map;
  static HWY_INLINE void shift(const Beside& by, const CellRow& to) {
    for (std::size_t a = 0; a < 3; ++a) add(to, 1 + a, -projection::tent, by.difference(4 + 3 * a + by.axis));
  }
};

template <class Sums>
HWY_INLINE void add_beside(const ConstCellRow& own, const Beside& by, const CellRow& to) {
  for (std::size_t q = 0; q < Sums::count; ++q)
    hn::StoreU(hn::MulAdd(set(projection::tent), by.sum(q), load(own, q)), Wide(), to.first + q * to.width);
  Sums::shift(by, to);
}

/// Memory of this thread for the sums of a row; two at a time.
HWY_INLINE std::vector<Real>& row_memory(std::size_t number) {
  static thread_local std::array<std::vector<Real>, 2> memory;
  return memory[number];
}

/// Sums over the rows around, with one more cell at either end of the row.
template <class Sums>
HWY_INLINE ConstCellRow sum_across(const RowsAround& rows, std::vector<Real>& memory) {
  const std::size_t lanes = hn::Lanes(Wide());
  const std::size_t width = (rows.filled + most_lanes) / most_lanes * most_lanes + 2 * most_lanes;
  memory.resize(std::max(memory.size(), Sums::count * width));
  Real* const first = memory.data() + most_lanes;
  for (std::size_t c = 0; c < rows.filled; c += lanes) {
    alignas(64) Real across[3][Sums::count * most_lanes];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto of_plane = [&](std::size_t j) { return ConstCellRow{rows.first[i][j] + c, rows.width}; };
      add_beside<Sums>(of_plane(1), {of_plane(0), of_plane(2), rows.axis[0]}, {across[i], most_lanes});
    }
    const auto of_row = [&](std::size_t i) { return ConstCellRow{across[i], most_lanes}; };
    add_beside<Sums>(of_row(1), {of_row(0), of_row(2), rows.axis[1]}, {first + c, width});
  }
  for (std::size_t q = 0; q < Sums::count; ++q) {
    Real* const row = first + q * width;
    row[-1] = rows.repeats ? row[rows.filled - 1] : 0;
    row[rows.filled] = rows.repeats ? row[0] : 0;
  }
  return {first, width};
}

/// The tents of the next cells.
template <class Sums>
class TentSums {
 public:
  HWY_INLINE TentSums(const ConstCellRow& across, const Part& part) {
    const auto from = [&, first = across.first + part.begin](int z) { return ConstCellRow{first + z, across.width}; };
    add_beside<Sums>(from(0), {from(-1), from(1), 2}, {value_, most_lanes});
  }
  /// From number q on.
  HWY_INLINE ConstCellRow row(std::size_t q = 0) const { return {value_ + q * most_lanes, most_lanes}; }

 private:
  alignas(64) Real value_[Sums::count * most_lanes];
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();
#endif

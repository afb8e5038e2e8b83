// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "particles/neighbour_list.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include <algorithm>
#include <type_traits>

#include "trevi/particles/neighbour_list.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The particles of the 27 cells around one cell, transposed to one array per coordinate and relative to that cell,
// in storage order. Gathered once for all particles of the cell.
template <class T>
class Candidates {
 public:
  static constexpr std::size_t padding = 64;

  void clear() { size_ = 0; }

  template <class Record>
  void append(const Record* records, LocalId begin, LocalId end, const Record& anchor) {
    reserve(size_ + static_cast<std::size_t>(end - begin) + padding);
    for (LocalId j = begin; j < end; ++j, ++size_) {
      x[size_] = static_cast<T>(records[j].x - anchor.x);
      y[size_] = static_cast<T>(records[j].y - anchor.y);
      z[size_] = static_cast<T>(records[j].z - anchor.z);
      index[size_] = j;
    }
  }

  std::size_t size() const { return size_; }

  std::vector<T> x, y, z;
  std::vector<hwy::MakeSigned<T>> index;

 private:
  void reserve(std::size_t n) {
    if (n <= x.size()) return;
    for (auto* field : {&x, &y, &z}) field->resize(2 * n);
    index.resize(2 * n);
  }
  std::size_t size_ = 0;
};

// Stores signed integers as wide as T as LocalIds.
template <class D, class V>
void store_indices(D, V index, LocalId* HWY_RESTRICT out) {
  const hn::Rebind<LocalId, D> d32;
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(LocalId)) {
    hn::StoreU(index, d32, out);
  } else {
    const hn::RebindToUnsigned<D> du;
    const hn::Rebind<std::uint32_t, D> du32;
    hn::StoreU(hn::BitCast(d32, hn::TruncateTo(du32, hn::BitCast(du, index))), d32, out);
  }
}

// Writes the candidates nearer than one h to particle `self` (its place among all) and returns how many there are.
template <class T>
std::size_t near(const Candidates<T>& candidates, std::size_t self, LocalId* HWY_RESTRICT out) {
  const hn::ScalableTag<T> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto x = hn::Set(d, candidates.x[self]), y = hn::Set(d, candidates.y[self]), z = hn::Set(d, candidates.z[self]);
  const auto self_index = hn::Set(di, candidates.index[self]);
  const auto limit = hn::Set(d, static_cast<T>(Packed<T>::units_per_h * Packed<T>::units_per_h));
  std::size_t found = 0;
  for (std::size_t k = 0; k < candidates.size(); k += hn::Lanes(d)) {
    const auto dx = hn::Sub(hn::LoadU(d, &candidates.x[k]), x);
    const auto dy = hn::Sub(hn::LoadU(d, &candidates.y[k]), y);
    const auto dz = hn::Sub(hn::LoadU(d, &candidates.z[k]), z);
    const auto r2 = hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)));
    const auto index = hn::LoadU(di, &candidates.index[k]);
    const auto valid = hn::AndNot(hn::Eq(index, self_index), hn::FirstN(di, candidates.size() - k));
    const auto mask = hn::And(valid, hn::RebindMask(di, hn::Lt(r2, limit)));
    // Compress in a register and store whole: a compressing store to memory is slow on some processors.
    store_indices(d, hn::Compress(index, mask), out + found);
    found += hn::CountTrue(di, mask);
  }
  return found;
}

// The rows of cells around cell c of plane k (0 is the low ghost plane), each a contiguous run of particles.
template <class Visit>
void for_each_row_around(const CellOrder& order, LocalId k, LocalId c, Visit&& visit) {
  const LocalId columns = order.grid().columns(), rows = order.grid().rows();
  const LocalId row = c / columns, column = c % columns;
  const LocalId first = std::max(column - 1, 0), last = std::min(column + 1, columns - 1);
  for (LocalId plane = k - 1; plane <= k + 1; ++plane) {
    for (LocalId r = std::max(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r) {
      visit(order.start(plane, r * columns + first), order.start(plane, r * columns + last + 1));
    }
  }
}

template <class T>
void search(const CellOrder& order, const std::vector<Packed<T>>& records, NeighbourRows& rows) {
  Candidates<T> candidates;
  LocalId i = 0;
  std::int64_t end = 0;
  for (LocalId k = 1; k <= order.planes(); ++k) {
    for (LocalId c = 0; c < order.grid().cells_per_plane(); ++c) {
      const LocalId begin = order.start(k, c), count = order.start(k, c + 1) - begin;
      if (count == 0) continue;
      candidates.clear();
      std::size_t self = 0;
      const auto anchor = records[static_cast<std::size_t>(begin)];
      for_each_row_around(order, k, c, [&](LocalId row_begin, LocalId row_end) {
        if (row_begin <= begin && begin < row_end)
          self = candidates.size() + static_cast<std::size_t>(begin - row_begin);
        candidates.append(records.data(), row_begin, row_end, anchor);
      });
      rows.reserve(end + static_cast<std::int64_t>(candidates.size() + Candidates<T>::padding) * count);
      for (LocalId n = 0; n < count; ++n, ++i) {
        const std::size_t found = near(candidates, self + static_cast<std::size_t>(n), rows.index.data() + end);
        if (found > static_cast<std::size_t>(NeighbourList::most_neighbours)) {
          rows.crowded = i;
          return;
        }
        end += static_cast<std::int64_t>(found);
        rows.first[static_cast<std::size_t>(i) + 1] = end;
      }
    }
  }
  // Whole vectors are read past the last row. What an earlier, longer list left there may name records that are gone.
  rows.reserve(end);
  std::fill_n(rows.index.begin() + end, NeighbourRows::slack, 0);
}

void search_single(const CellOrder& order, const std::vector<Packed<float>>& records, NeighbourRows& rows) {
  search(order, records, rows);
}
void search_double(const CellOrder& order, const std::vector<Packed<double>>& records, NeighbourRows& rows) {
  search(order, records, rows);
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(search_single);
HWY_EXPORT(search_double);

template <class T>
void NeighbourList::rebuild(const CellOrder& order, const std::vector<Packed<T>>& records) {
  rows_.first.assign(static_cast<std::size_t>(order.owned()) + 1, 0);
  rows_.crowded = -1;
  rows_.reserve(0);
  if constexpr (std::is_same_v<T, float>) {
    HWY_DYNAMIC_DISPATCH(search_single)(order, records, rows_);
  } else {
    HWY_DYNAMIC_DISPATCH(search_double)(order, records, rows_);
  }
  if (rows_.crowded >= 0) {
    const auto cut = rows_.first.begin() + rows_.crowded;
    std::fill(cut + 1, rows_.first.end(), *cut);
  }
}

template void NeighbourList::rebuild(const CellOrder&, const std::vector<Packed<float>>&);
template void NeighbourList::rebuild(const CellOrder&, const std::vector<Packed<double>>&);

}  // namespace trevi
#endif

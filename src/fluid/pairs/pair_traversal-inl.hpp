// The one traversal that all pair loops share: particle by particle, a vector of neighbours at a time. The whole
// records of the neighbours are loaded and transposed in registers, which is twice as fast as gather instructions.
// Included once per instruction set, inside the sources that Highway compiles repeatedly.
#if defined(TREVI_FLUID_PAIR_TRAVERSAL_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_PAIR_TRAVERSAL_INL
#undef TREVI_FLUID_PAIR_TRAVERSAL_INL
#else
#define TREVI_FLUID_PAIR_TRAVERSAL_INL
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "fluid/pairs/pair_sums.hpp"
#include "kernels/shape-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <class D>
struct Four {
  hn::Vec<D> x, y, z, w;
};

// Block b of the result is the 16 bytes at `base` of the record with number index[b · stride].
template <class D>
HWY_INLINE hn::Vec<D> load_blocks(D d, const hn::TFromD<D>* base, const LocalId* index, std::size_t stride) {
  const auto block = [=](std::size_t b) { return base + 4 * static_cast<std::size_t>(index[b * stride]); };
  constexpr std::size_t lanes_per_block = 16 / sizeof(hn::TFromD<D>);
  constexpr std::size_t blocks = HWY_MAX_BYTES >= 16 ? hn::MaxLanes(D()) / lanes_per_block : 1;
  if constexpr (blocks == 1) {
    return hn::Load(d, block(0));
  } else if constexpr (blocks == 2) {
    return hn::ConcatUpperLower(d, hn::LoadDup128(d, block(1)), hn::LoadDup128(d, block(0)));
  } else {
    static_assert(blocks == 4);
    const auto low =
        hn::IfThenElse(hn::FirstN(d, lanes_per_block), hn::LoadDup128(d, block(0)), hn::LoadDup128(d, block(1)));
    const auto high =
        hn::IfThenElse(hn::FirstN(d, 3 * lanes_per_block), hn::LoadDup128(d, block(2)), hn::LoadDup128(d, block(3)));
    return hn::ConcatUpperLower(d, high, low);
  }
}

// Lane k of x, y, z, w is the record at index[k].
template <class D>
requires(sizeof(hn::TFromD<D>) == 4) HWY_INLINE Four<D> gather(D d, const void* records, const LocalId* index) {
  const auto* base = static_cast<const hn::TFromD<D>*>(records);
  const auto a = load_blocks(d, base, index, 4), b = load_blocks(d, base, index + 1, 4);
  const auto c = load_blocks(d, base, index + 2, 4), e = load_blocks(d, base, index + 3, 4);
  const hn::Repartition<double, D> wide;  // to move two lanes as one
  const auto ab = hn::BitCast(wide, hn::InterleaveLower(d, a, b)), ce = hn::BitCast(wide, hn::InterleaveLower(d, c, e));
  const auto ab2 = hn::BitCast(wide, hn::InterleaveUpper(d, a, b)),
             ce2 = hn::BitCast(wide, hn::InterleaveUpper(d, c, e));
  return {hn::BitCast(d, hn::InterleaveLower(wide, ab, ce)), hn::BitCast(d, hn::InterleaveUpper(wide, ab, ce)),
          hn::BitCast(d, hn::InterleaveLower(wide, ab2, ce2)), hn::BitCast(d, hn::InterleaveUpper(wide, ab2, ce2))};
}

template <class D>
requires(sizeof(hn::TFromD<D>) == 8) HWY_INLINE Four<D> gather(D d, const void* records, const LocalId* index) {
  const auto* base = static_cast<const hn::TFromD<D>*>(records);
  const auto xy0 = load_blocks(d, base, index, 2), xy1 = load_blocks(d, base, index + 1, 2);
  const auto zw0 = load_blocks(d, base + 2, index, 2), zw1 = load_blocks(d, base + 2, index + 1, 2);
  return {hn::InterleaveLower(d, xy0, xy1), hn::InterleaveUpper(d, xy0, xy1), hn::InterleaveLower(d, zw0, zw1),
          hn::InterleaveUpper(d, zw0, zw1)};
}

// The sum of the 128-bit blocks of a vector, in one block.
template <class D, class V>
HWY_INLINE auto sum_of_blocks(D, V v) {
  if constexpr (hn::MaxLanes(D()) * sizeof(hn::TFromD<D>) <= 16) {
    return v;
  } else {
    const hn::Half<D> half;
    return sum_of_blocks(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

// For each 128-bit block, its sums of x, y, z and w over the lanes. In single precision a block holds all four sums; in
// double precision it holds two, and there are two vectors.
template <class D>
struct BlockSums {
  hn::Vec<D> xy, zw;  // single precision: all in xy
};
template <class D>
requires(sizeof(hn::TFromD<D>) == 4) HWY_INLINE BlockSums<D> sums_of_blocks(D d, const Four<D>& v) {
  const hn::Repartition<double, D> wide;
  const auto xy = hn::BitCast(wide, hn::Add(hn::InterleaveLower(d, v.x, v.y), hn::InterleaveUpper(d, v.x, v.y)));
  const auto zw = hn::BitCast(wide, hn::Add(hn::InterleaveLower(d, v.z, v.w), hn::InterleaveUpper(d, v.z, v.w)));
  const auto sums =
      hn::Add(hn::BitCast(d, hn::InterleaveLower(wide, xy, zw)), hn::BitCast(d, hn::InterleaveUpper(wide, xy, zw)));
  return {sums, sums};
}
template <class D>
requires(sizeof(hn::TFromD<D>) == 8) HWY_INLINE BlockSums<D> sums_of_blocks(D d, const Four<D>& v) {
  return {hn::Add(hn::InterleaveLower(d, v.x, v.y), hn::InterleaveUpper(d, v.x, v.y)),
          hn::Add(hn::InterleaveLower(d, v.z, v.w), hn::InterleaveUpper(d, v.z, v.w))};
}

// A vector of pairs (i, j): d = p_i − p_j in the units of the records, r2 in h², w_j the scalar of record j.
template <class D>
struct PairVector {
  hn::Vec<D> dx, dy, dz, r2, w;
  const LocalId* index;
};

// The coordinates of a record are integers in single precision; their difference is exact.
template <class D, class V>
HWY_INLINE hn::Vec<D> difference(D d, hwy::HWY_NAMESPACE::Vec<hn::RebindToSigned<D>> a, V b) {
  const hn::RebindToSigned<D> di;
  return hn::ConvertTo(d, hn::Sub(a, hn::BitCast(di, b)));
}

template <class D>
HWY_INLINE PairVector<D> pair_vector(D d, const Packed<float>& self, const Packed<float>* records,
                                     const LocalId* index) {
  const hn::RebindToSigned<D> di;
  const Four<D> j = gather(d, records, index);
  const auto dx = difference(d, hn::Set(di, self.x), j.x), dy = difference(d, hn::Set(di, self.y), j.y);
  const auto dz = difference(d, hn::Set(di, self.z), j.z);
  const auto scale = hn::Set(d, static_cast<float>(1 / (Packed<float>::units_per_h * Packed<float>::units_per_h)));
  return {dx, dy, dz, hn::Mul(scale, hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)))), j.w, index};
}

template <class D>
HWY_INLINE PairVector<D> pair_vector(D d, const Packed<double>& self, const Packed<double>* records,
                                     const LocalId* index) {
  const Four<D> j = gather(d, records, index);
  const auto dx = hn::Sub(hn::Set(d, self.x), j.x), dy = hn::Sub(hn::Set(d, self.y), j.y);
  const auto dz = hn::Sub(hn::Set(d, self.z), j.z);
  return {dx, dy, dz, hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx))), j.w, index};
}

// A particle's sum has the same structure on every processor: 64 bytes of virtual lanes, however wide the registers
// are. Neighbour k of a row belongs to lane k modulo 16 (8 in double precision), each lane is summed in the order of
// the row, and the lanes are then added as a fixed tree: first within each block of 16 bytes, then halves of 32 bytes,
// then the two blocks that are left. This tree is the cheapest one on AVX-512. Narrower registers hold the lanes in
// several groups.
template <class D>
inline constexpr std::size_t groups = 64 / (hn::MaxLanes(D()) * sizeof(hn::TFromD<D>));

// The sums of each group; only the first `groups` of the four members are used.
template <class Sums>
struct Groups {
  Sums a, b, c, e;
};

// The sum of all 128-bit blocks of one vector per group, in one block.
template <class D>
HWY_INLINE auto sum_of_blocks(D d, const Groups<hn::Vec<D>>& v) {
  if constexpr (groups<D> == 1) {
    return sum_of_blocks(d, v.a);
  } else if constexpr (groups<D> == 2) {
    return sum_of_blocks(d, hn::Add(v.a, v.b));
  } else {
    return hn::Add(hn::Add(v.a, v.c), hn::Add(v.b, v.e));
  }
}

// The sums of x, y, z and w in each block of one group.
template <class D, class Sums>
HWY_INLINE BlockSums<D> sums_of_blocks(D d, const Sums& s) {
  return sums_of_blocks(d, Four<D>{s.x, s.y, s.z, s.w});
}

// The sums of x, y, z and w over all virtual lanes, as one record. Groups that do not exist are copies of the first and
// are not used.
template <class D, class Sums>
HWY_INLINE Vec4<hn::TFromD<D>> sum_of_groups(D d, const Groups<Sums>& s) {
  using T = hn::TFromD<D>;
  const auto a = sums_of_blocks(d, s.a), b = groups<D> >= 2 ? sums_of_blocks(d, s.b) : a;
  const auto c = groups<D> == 4 ? sums_of_blocks(d, s.c) : a, e = groups<D> == 4 ? sums_of_blocks(d, s.e) : a;
  Vec4<T> result;
  hn::Store(sum_of_blocks(d, Groups<hn::Vec<D>>{a.xy, b.xy, c.xy, e.xy}), hn::Full128<T>(), &result.x);
  if constexpr (sizeof(T) == 8)
    hn::Store(sum_of_blocks(d, Groups<hn::Vec<D>>{a.zw, b.zw, c.zw, e.zw}), hn::Full128<T>(), &result.z);
  return result;
}

// The sum over all virtual lanes of one number; here blocks are added before the lanes within them.
template <class D>
HWY_INLINE hn::TFromD<D> sum_of_lanes(D d, const Groups<hn::Vec<D>>& s) {
  using T = hn::TFromD<D>;
  const hn::Full128<T> block;
  constexpr std::size_t lanes = hn::MaxLanes(block);
  alignas(16) T lane[lanes];
  hn::Store(sum_of_blocks(d, s), block, lane);
  if constexpr (lanes == 4) {
    return (lane[0] + lane[2]) + (lane[1] + lane[3]);
  } else {
    return lane[0] + lane[1];
  }
}

// The row of the neighbour list of one particle, with the records that its indices refer to.
template <class T>
struct Row {
  const Packed<T>& self;
  const Packed<T>* records;
  const LocalId* index;
  LocalId count;
};

// Writes the indices of the neighbours of a row, and after them a vector of 0, which are indices, too.
template <class D>
HWY_INLINE void decode(D, const NeighbourRow& row, LocalId* HWY_RESTRICT index) {
  const hn::Rebind<LocalId, D> d;
  const hn::Rebind<std::uint16_t, D> d16;
  constexpr auto lanes = static_cast<LocalId>(hn::MaxLanes(D()));
  if constexpr (lanes >= NeighbourRow::windows) {
    if (HWY_LIKELY(row.coded != nullptr)) {
      const auto shifts = hn::LoadDup128(d, row.shift);
      for (LocalId k = 0; k < row.count; k += lanes) {
        const auto code = hn::PromoteTo(d, hn::LoadU(d16, row.coded + k));
        const auto window = hn::IndicesFromVec(d, hn::ShiftRight<NeighbourRow::bits_of_number>(code));
        hn::Store(hn::Add(code, hn::TableLookupLanes(shifts, window)), d, index + k);
      }
      return hn::StoreU(hn::Zero(d), d, index + row.count);  // in place of what the codes of the next row gave
    }
  }
  for (LocalId k = 0; k < row.count; ++k) index[k] = row[k];
  for (LocalId lane = 0; lane < lanes; ++lane) index[row.count + lane] = 0;
}

template <class D, class Terms, class Sums, class T>
HWY_INLINE void add_vector(D d, const Terms& terms, Sums& sums, const Row<T>& row, LocalId k) {
  auto pair = pair_vector(d, row.self, row.records, row.index + k);
  // Lanes past the end of the row are moved to r = h, where every smoothing kernel is zero.
  if (row.count - k < static_cast<LocalId>(hn::Lanes(d)))
    pair.r2 = hn::IfThenElse(hn::FirstN(d, static_cast<std::size_t>(row.count - k)), pair.r2, hn::Set(d, T{1}));
  terms.add(d, sums, pair);
}

// Adds the pairs of a row, one vector to each group in turn. A vector past the end of the row is skipped: it would only
// add zeros.
template <class D, class Terms, class Sums, class T>
HWY_INLINE void add_row(D d, const Terms& terms, Groups<Sums>& sums, const Row<T>& row) {
  const auto lanes = static_cast<LocalId>(hn::Lanes(d));
  for (LocalId k = 0; k < row.count; k += lanes) {
    add_vector(d, terms, sums.a, row, k);
    if constexpr (groups<D> >= 2) {
      if ((k += lanes) >= row.count) break;
      add_vector(d, terms, sums.b, row, k);
    }
    if constexpr (groups<D> == 4) {
      if ((k += lanes) >= row.count) break;
      add_vector(d, terms, sums.c, row, k);
      if ((k += lanes) >= row.count) break;
      add_vector(d, terms, sums.e, row, k);
    }
  }
}

// For each owned particle i of the range: sums = terms.start(i) in each group, terms.add(sums, pairs) for all its
// neighbours, terms.finish(index in the range, groups).
template <class T, class Terms>
HWY_INLINE void for_each_particle(const Pairs<T>& pairs, Range range, const Terms& terms) {
  const hn::ScalableTag<T> d;
  const Packed<T>* records = pairs.records.data();
  // Rows are decoded one ahead: what is stored in vectors is not at hand for single loads at once.
  constexpr std::size_t room = static_cast<std::size_t>(NeighbourList::max_neighbours) + RowWriter::slack;
  alignas(64) LocalId indices[2][room];
  if (range.size() > 0) decode(d, pairs.list.row(range.begin), indices[range.begin % 2]);
  for (LocalId i = range.begin; i < range.end; ++i) {
    if (i + 1 < range.end) decode(d, pairs.list.row(i + 1), indices[(i + 1) % 2]);
    const LocalId self = pairs.low_ghosts + i;
    const auto start = terms.start(d, self);
    Groups<std::remove_const_t<decltype(start)>> sums{start, start, start, start};
    add_row(d, terms, sums, Row<T>{records[self], records, indices[i % 2], pairs.list.count(i)});
    terms.finish(d, i - range.begin, sums);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

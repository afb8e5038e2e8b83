// One traversal for all pair loops: particle by particle, a vector of neighbours at a time. A neighbour's record is
// loaded whole and the vector of records transposed in registers, which beats gather instructions by a factor of two.
// Included once per instruction set, inside the sources that Highway compiles repeatedly.
#if defined(TREVI_FLUID_PAIR_TRAVERSAL_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_PAIR_TRAVERSAL_INL
#undef TREVI_FLUID_PAIR_TRAVERSAL_INL
#else
#define TREVI_FLUID_PAIR_TRAVERSAL_INL
#endif

#include <hwy/highway.h>

#include <type_traits>

#include "fluid/kernels/shape-inl.hpp"
#include "fluid/pair_sums.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <class D>
struct Four {
  hn::Vec<D> x, y, z, w;
};

// Block b of the result is the 16 bytes at records[index[first + b · stride]] + offset.
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
  const hn::Repartition<double, D> wide;  // two lanes moved as one
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

// Sum of the 128-bit blocks of a vector.
template <class D, class V>
HWY_INLINE auto sum_of_blocks(D, V v) {
  if constexpr (hn::MaxLanes(D()) * sizeof(hn::TFromD<D>) <= 16) {
    return v;
  } else {
    const hn::Half<D> half;
    return sum_of_blocks(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

// The four sums over lanes as one record.
template <class D>
requires(sizeof(hn::TFromD<D>) == 4) HWY_INLINE Vec4<float> sum_of_lanes(D d, const Four<D>& v) {
  const hn::Repartition<double, D> wide;
  const auto xy = hn::BitCast(wide, hn::Add(hn::InterleaveLower(d, v.x, v.y), hn::InterleaveUpper(d, v.x, v.y)));
  const auto zw = hn::BitCast(wide, hn::Add(hn::InterleaveLower(d, v.z, v.w), hn::InterleaveUpper(d, v.z, v.w)));
  const auto sums =
      hn::Add(hn::BitCast(d, hn::InterleaveLower(wide, xy, zw)), hn::BitCast(d, hn::InterleaveUpper(wide, xy, zw)));
  Vec4<float> result;
  hn::Store(sum_of_blocks(D(), sums), hn::Full128<float>(), &result.x);
  return result;
}

template <class D>
requires(sizeof(hn::TFromD<D>) == 8) HWY_INLINE Vec4<double> sum_of_lanes(D d, const Four<D>& v) {
  const auto xy = hn::Add(hn::InterleaveLower(d, v.x, v.y), hn::InterleaveUpper(d, v.x, v.y));
  const auto zw = hn::Add(hn::InterleaveLower(d, v.z, v.w), hn::InterleaveUpper(d, v.z, v.w));
  Vec4<double> result;
  hn::Store(sum_of_blocks(D(), xy), hn::Full128<double>(), &result.x);
  hn::Store(sum_of_blocks(D(), zw), hn::Full128<double>(), &result.z);
  return result;
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

// A particle's sum has the same shape on every processor: 64 bytes of virtual lanes, whatever the registers are.
// Neighbour k of a row belongs to lane k modulo 16 (8 in double precision), each lane is summed in the order of the
// row, and the lanes are added by one tree: halves of 32 bytes, then blocks of 16 bytes, then the lanes of a block. A
// register that is narrower holds one of `groups` parts of the lanes.
template <class D>
inline constexpr std::size_t groups = 64 / (hn::MaxLanes(D()) * sizeof(hn::TFromD<D>));

// The sums of all groups; of four, those that the registers need are used.
template <class Sums>
struct Groups {
  Sums a, b, c, e;
};

// The two halves of the virtual lanes, added, for registers of 32 bytes and more.
template <class D>
using Narrow = hn::CappedTag<hn::TFromD<D>, 32 / sizeof(hn::TFromD<D>)>;
template <class D>
HWY_INLINE hn::Vec<Narrow<D>> halves_added(D, hn::Vec<D> a, hn::Vec<D> b) {
  if constexpr (groups<D> == 1) {
    const Narrow<D> narrow;
    return hn::Add(hn::LowerHalf(narrow, a), hn::UpperHalf(narrow, a));
  } else {
    return hn::Add(a, b);
  }
}

template <class D, class Sums>
HWY_INLINE Four<D> four_added(D, const Sums& a, const Sums& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z), hn::Add(a.w, b.w)};
}

// The four sums over all virtual lanes as one record.
template <class D, class Sums>
HWY_INLINE auto sum_of_groups(D d, const Groups<Sums>& s) {
  if constexpr (groups<D> <= 2) {
    const Four<Narrow<D>> v{halves_added(d, s.a.x, s.b.x), halves_added(d, s.a.y, s.b.y), halves_added(d, s.a.z, s.b.z),
                            halves_added(d, s.a.w, s.b.w)};
    return sum_of_lanes(Narrow<D>(), v);
  } else {
    const auto low = sum_of_lanes(d, four_added(d, s.a, s.c)), high = sum_of_lanes(d, four_added(d, s.b, s.e));
    return std::remove_const_t<decltype(low)>{low.x + high.x, low.y + high.y, low.z + high.z, low.w + high.w};
  }
}

// The same for a single sum, `squares`.
template <class D, class Sums>
HWY_INLINE hn::TFromD<D> sum_of_squares(D d, const Groups<Sums>& s) {
  using T = hn::TFromD<D>;
  const hn::Full128<T> block;
  constexpr std::size_t lanes = hn::MaxLanes(block);
  hn::Vec<decltype(block)> total;
  if constexpr (groups<D> <= 2) {
    const auto v = halves_added(d, s.a.squares, s.b.squares);
    total = hn::Add(hn::LowerHalf(block, v), hn::UpperHalf(block, v));
  } else {
    total = hn::Add(hn::Add(s.a.squares, s.c.squares), hn::Add(s.b.squares, s.e.squares));
  }
  alignas(16) T lane[lanes];
  hn::Store(total, block, lane);
  if constexpr (lanes == 4) {
    return (lane[0] + lane[2]) + (lane[1] + lane[3]);
  } else {
    return lane[0] + lane[1];
  }
}

// A row of the list, and what is read of it.
template <class T>
struct Row {
  const Packed<T>& self;
  const Packed<T>* records;
  const LocalId* index;
  LocalId count;
};

template <class D, class Terms, class Sums, class T>
HWY_INLINE void add_vector(D d, const Terms& terms, Sums& sums, const Row<T>& row, LocalId k) {
  auto pair = pair_vector(d, row.self, row.records, row.index + k);
  // Lanes past the end of the row are moved to r = h, where every smoothing kernel is zero.
  if (row.count - k < static_cast<LocalId>(hn::Lanes(d)))
    pair.r2 = hn::IfThenElse(hn::FirstN(d, static_cast<std::size_t>(row.count - k)), pair.r2, hn::Set(d, T{1}));
  terms.add(d, sums, pair);
}

// A row's pairs, group after group. One past the end of the row would add zeros, which change no sum.
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
  for (LocalId i = range.begin; i < range.end; ++i) {
    const LocalId self = pairs.low_ghosts + i;
    const auto start = terms.start(d, self);
    Groups<std::remove_const_t<decltype(start)>> sums{start, start, start, start};
    add_row(d, terms, sums, Row<T>{records[self], records, pairs.list.row(i), pairs.list.count(i)});
    terms.finish(d, i - range.begin, sums);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

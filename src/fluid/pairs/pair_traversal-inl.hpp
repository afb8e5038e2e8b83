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

#include <algorithm>
#include <type_traits>
#include <utility>

#include "fluid/pairs/pair_sums.hpp"
#include "kernels/shape-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <class D>
struct Four {
  hn::Vec<D> x, y, z, w;
};

// The position of a record, in halves of a record: in single precision, half a record is a unit by which the processor
// can compute addresses by itself.
using Place = std::uint32_t;

// Block b of the result is the 16 bytes at `base` of the record at place[b · stride].
template <class D>
HWY_INLINE hn::Vec<D> load_blocks(D d, const hn::TFromD<D>* base, const Place* place, std::size_t stride) {
  const auto block = [=](std::size_t b) { return base + 2 * static_cast<std::size_t>(place[b * stride]); };
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

// Lane k of x, y, z, w is the record at place[k].
template <class D>
requires(sizeof(hn::TFromD<D>) == 4) HWY_INLINE Four<D> gather(D d, const void* records, const Place* place) {
  const auto* base = static_cast<const hn::TFromD<D>*>(records);
  const auto a = load_blocks(d, base, place, 4), b = load_blocks(d, base, place + 1, 4);
  const auto c = load_blocks(d, base, place + 2, 4), e = load_blocks(d, base, place + 3, 4);
  const hn::Repartition<double, D> wide;  // to move two lanes as one
  const auto ab = hn::BitCast(wide, hn::InterleaveLower(d, a, b)), ce = hn::BitCast(wide, hn::InterleaveLower(d, c, e));
  const auto ab2 = hn::BitCast(wide, hn::InterleaveUpper(d, a, b)),
             ce2 = hn::BitCast(wide, hn::InterleaveUpper(d, c, e));
  return {hn::BitCast(d, hn::InterleaveLower(wide, ab, ce)), hn::BitCast(d, hn::InterleaveUpper(wide, ab, ce)),
          hn::BitCast(d, hn::InterleaveLower(wide, ab2, ce2)), hn::BitCast(d, hn::InterleaveUpper(wide, ab2, ce2))};
}

template <class D>
requires(sizeof(hn::TFromD<D>) == 8) HWY_INLINE Four<D> gather(D d, const void* records, const Place* place) {
  const auto* base = static_cast<const hn::TFromD<D>*>(records);
  const auto xy0 = load_blocks(d, base, place, 2), xy1 = load_blocks(d, base, place + 1, 2);
  const auto zw0 = load_blocks(d, base + 2, place, 2), zw1 = load_blocks(d, base + 2, place + 1, 2);
  return {hn::InterleaveLower(d, xy0, xy1), hn::InterleaveUpper(d, xy0, xy1), hn::InterleaveLower(d, zw0, zw1),
          hn::InterleaveUpper(d, zw0, zw1)};
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
  const Place* place;
};

// The coordinates of a record are integers in single precision; their difference is exact.
template <class D, class V>
HWY_INLINE hn::Vec<D> difference(D d, hwy::HWY_NAMESPACE::Vec<hn::RebindToSigned<D>> a, V b) {
  const hn::RebindToSigned<D> di;
  return hn::ConvertTo(d, hn::Sub(a, hn::BitCast(di, b)));
}

template <class D>
HWY_INLINE PairVector<D> pair_vector(D d, const Packed<float>& self, const Packed<float>* records, const Place* place) {
  const hn::RebindToSigned<D> di;
  const Four<D> j = gather(d, records, place);
  const auto dx = difference(d, hn::Set(di, self.x), j.x), dy = difference(d, hn::Set(di, self.y), j.y);
  const auto dz = difference(d, hn::Set(di, self.z), j.z);
  const auto scale = hn::Set(d, static_cast<float>(1 / (Packed<float>::units_per_h * Packed<float>::units_per_h)));
  return {dx, dy, dz, hn::Mul(scale, hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)))), j.w, place};
}

template <class D>
HWY_INLINE PairVector<D> pair_vector(D d, const Packed<double>& self, const Packed<double>* records,
                                     const Place* place) {
  const Four<D> j = gather(d, records, place);
  const auto dx = hn::Sub(hn::Set(d, self.x), j.x), dy = hn::Sub(hn::Set(d, self.y), j.y);
  const auto dz = hn::Sub(hn::Set(d, self.z), j.z);
  return {dx, dy, dz, hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx))), j.w, place};
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

// The sum of one vector per group.
template <class D>
HWY_INLINE hn::Vec<D> sum_of_groups(const Groups<hn::Vec<D>>& v) {
  if constexpr (groups<D> == 1) {
    return v.a;
  } else if constexpr (groups<D> == 2) {
    return hn::Add(v.a, v.b);
  } else {
    return hn::Add(hn::Add(v.a, v.c), hn::Add(v.b, v.e));
  }
}

// The sums of x, y, z and w in each block of all groups. Groups that do not exist are copies of the first and are not
// used.
template <class D, class Sums>
HWY_INLINE BlockSums<D> sums_of_blocks(D d, const Groups<Sums>& s) {
  const auto of = [=](const Sums& group) { return sums_of_blocks(d, Four<D>{group.x, group.y, group.z, group.w}); };
  const auto a = of(s.a), b = groups<D> >= 2 ? of(s.b) : a;
  const auto c = groups<D> == 4 ? of(s.c) : a, e = groups<D> == 4 ? of(s.e) : a;
  return {sum_of_groups<D>({a.xy, b.xy, c.xy, e.xy}), sum_of_groups<D>({a.zw, b.zw, c.zw, e.zw})};
}

// The sums of this many particles are finished together, so that none has to wait for a sum of its own.
inline constexpr std::size_t batch = 4;

// A vector for each particle of a batch, whose blocks are still to be added; and their sums, one block for each.
template <class D>
struct alignas(64) Unfinished {
  hn::TFromD<D> of[batch][hn::MaxLanes(D())];
};
template <class T>
struct alignas(64) Finished {
  static constexpr std::size_t lanes = 16 / sizeof(T);
  T of[batch][lanes];
};

// For two vectors: the sum of the halves of the first one, followed by that of the second one.
template <class D>
HWY_INLINE hn::Vec<D> halves(D d, hn::Vec<D> a, hn::Vec<D> b) {
  return hn::Add(hn::ConcatLowerLower(d, b, a), hn::ConcatUpperUpper(d, b, a));
}

template <class D>
HWY_INLINE Finished<hn::TFromD<D>> sum_of_blocks(D d, const Unfinished<D>& v) {
  Finished<hn::TFromD<D>> sums;
  const auto load = [&](std::size_t k) { return hn::Load(d, v.of[k]); };
  constexpr std::size_t blocks = hn::MaxLanes(D()) / Finished<hn::TFromD<D>>::lanes;
  if constexpr (blocks == 4) {
    const auto a = halves(d, load(0), load(2)), b = halves(d, load(1), load(3));
    hn::Store(hn::Add(hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a), hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a))),
              d, sums.of[0]);
  } else if constexpr (blocks == 2) {
    hn::Store(halves(d, load(0), load(1)), d, sums.of[0]);
    hn::Store(halves(d, load(2), load(3)), d, sums.of[2]);
  } else {
    for (std::size_t k = 0; k < batch; ++k) hn::Store(load(k), d, sums.of[k]);
  }
  return sums;
}

// Also adds the lanes of each block: the sum is then in the first lane.
template <class D>
HWY_INLINE Finished<hn::TFromD<D>> sum_of_lanes(D d, const Unfinished<D>& v) {
  Finished<hn::TFromD<D>> sums = sum_of_blocks(d, v);
  for (std::size_t at = 0; at < batch * Finished<hn::TFromD<D>>::lanes; at += hn::MaxLanes(D())) {
    auto sum = hn::Load(d, &sums.of[0][0] + at);
    if constexpr (sizeof(hn::TFromD<D>) == 4) {
      sum = hn::Add(sum, hn::Shuffle1032(sum));
      sum = hn::Add(sum, hn::Shuffle2301(sum));
    } else {
      sum = hn::Add(sum, hn::Shuffle01(sum));
    }
    hn::Store(sum, d, &sums.of[0][0] + at);
  }
  return sums;
}

// The row of the neighbour list of one particle, with the records that its indices refer to.
template <class T>
struct Row {
  const Packed<T>& self;
  const Packed<T>* records;
  const Place* place;
  LocalId count;
};

// Writes the positions of the neighbours of a row, followed by a vector of zeros, which are valid positions, too.
template <class D>
HWY_INLINE void decode(D, const NeighbourRow& row, Place* HWY_RESTRICT place) {
  const hn::Rebind<Place, D> d;
  const hn::Rebind<std::uint16_t, D> d16;
  constexpr auto lanes = static_cast<LocalId>(hn::MaxLanes(D()));
  if constexpr (lanes >= NeighbourRow::windows) {
    if (HWY_LIKELY(row.coded != nullptr)) {
      const auto shifts = hn::LoadDup128(d, reinterpret_cast<const Place*>(row.shift));
      for (LocalId k = 0; k < row.count; k += lanes) {
        const auto code = hn::PromoteTo(d, hn::LoadU(d16, row.coded + k));
        const auto window = hn::IndicesFromVec(d, hn::ShiftRight<NeighbourRow::bits_of_number>(code));
        const auto index = hn::Add(code, hn::TableLookupLanes(shifts, window));
        hn::Store(hn::Add(index, index), d, place + k);
      }
      return hn::StoreU(hn::Zero(d), d, place + row.count);  // in place of what the codes of the next row gave
    }
  }
  for (LocalId k = 0; k < row.count; ++k) place[k] = 2 * static_cast<Place>(row[k]);
  for (LocalId lane = 0; lane < lanes; ++lane) place[row.count + lane] = 0;
}

template <class D, class Terms, class Sums, class T>
HWY_INLINE void add_vector(D d, const Terms& terms, Sums& sums, const Row<T>& row, LocalId k) {
  auto pair = pair_vector(d, row.self, row.records, row.place + k);
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
// neighbours, terms.keep(sums, its number in the batch, unfinished sums); and for each batch of particles
// terms.finish(index in the range of the first, how many, unfinished sums).
template <class T, class Terms>
HWY_INLINE void for_each_particle(const Pairs<T>& pairs, Range range, const Terms& terms) {
  using D = hn::ScalableTag<T>;
  const D d;
  const Packed<T>* records = pairs.records.data();
  // Rows are decoded one ahead: values that were stored as vectors are not immediately available to scalar loads.
  constexpr std::size_t room = static_cast<std::size_t>(NeighbourList::max_neighbours) + RowWriter::slack;
  alignas(64) Place places[2][room];
  Place *here = places[0], *next = places[1];
  if (range.size() > 0) decode(d, pairs.list.row(range.begin), next);
  typename Terms::template Kept<D> kept{};
  for (LocalId first = range.begin; first < range.end; first += static_cast<LocalId>(batch)) {
    const std::size_t count = std::min(batch, static_cast<std::size_t>(range.end - first));
    for (std::size_t k = 0; k < count; ++k) {
      const LocalId i = first + static_cast<LocalId>(k), self = pairs.low_ghosts + i;
      std::swap(here, next);
      if (i + 1 < range.end) decode(d, pairs.list.row(i + 1), next);
      const auto start = terms.start(d, self);
      Groups<std::remove_const_t<decltype(start)>> sums{start, start, start, start};
      add_row(d, terms, sums, Row<T>{records[self], records, here, pairs.list.count(i)});
      terms.keep(d, sums, k, kept);
    }
    terms.finish(d, static_cast<std::size_t>(first - range.begin), count, kept);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

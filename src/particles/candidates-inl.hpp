// The particles that may be neighbours of any particle of a cell: the first half of the search of neighbour_list.cpp,
// which compares each particle of the cell with them. Included once per instruction set, inside the source that Highway
// compiles repeatedly.
#if defined(TREVI_PARTICLES_CANDIDATES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_PARTICLES_CANDIDATES_INL
#undef TREVI_PARTICLES_CANDIDATES_INL
#else
#define TREVI_PARTICLES_CANDIDATES_INL
#endif

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <vector>

#include "base/threads.hpp"
#include "particles/compress-inl.hpp"
#include "particles/packed.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// The bounding box of the particles of one cell, in units of the records, relative to the first of the particles.
template <class T>
struct Bounds {
  using Record = Packed<T>;
  Record anchor;
  std::array<T, 3> low{}, high{};

  Bounds(const Record* records, LocalId begin, LocalId end) : anchor(records[begin]) {
    for (LocalId j = begin; j < end; ++j) {
      const std::array<T, 3> p = relative(records[j]);
      for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::min(low[a], p[a]);
        high[a] = std::max(high[a], p[a]);
      }
    }
  }

  std::array<T, 3> relative(const Record& r) const {
    return {difference(r.x, anchor.x), difference(r.y, anchor.y), difference(r.z, anchor.z)};
  }

 private:
  using Coordinate = typename Record::Coordinate;
  static T difference(Coordinate a, Coordinate b) {
    if constexpr (std::is_integral_v<Coordinate>) {  // wraps around every 1024 h, which signed integers must not
      return static_cast<T>(static_cast<Coordinate>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b)));
    } else {
      return a - b;
    }
  }
};

// Coordinates relative to those of the anchor, as T; the difference of integers is taken modulo 2^32, because they wrap
// around.
template <class D, class V>
HWY_INLINE hn::Vec<D> from_anchor(D d, V v, typename Packed<hn::TFromD<D>>::Coordinate anchor) {
  if constexpr (sizeof(hn::TFromD<D>) == 4) {
    return hn::ConvertTo(d, hn::Sub(v, hn::Set(hn::RebindToSigned<D>(), anchor)));
  } else {
    return hn::Sub(v, hn::Set(d, anchor));
  }
}

// The coordinates of all records, one array each, with room to read whole vectors beyond the end.
template <class T>
struct Coordinates {
  using Coordinate = typename Packed<T>::Coordinate;
  Coordinate *x, *y, *z;

  // Each array has a third of the memory, one vector more than there are records.
  Coordinates(const std::vector<Packed<T>>& records, std::span<Coordinate> memory)
      : x(memory.data()), y(x + memory.size() / 3), z(y + memory.size() / 3) {
    constexpr LocalId part_size = 4096;
    for_each_part({0, static_cast<LocalId>(records.size())}, part_size, [&](Range part) {
      const hn::ScalableTag<Coordinate> d;
      auto j = static_cast<std::size_t>(part.begin);
      const auto end = static_cast<std::size_t>(part.end);
      for (; j + hn::Lanes(d) <= end; j += hn::Lanes(d)) {
        hn::Vec<decltype(d)> of_x, of_y, of_z, w;
        hn::LoadInterleaved4(d, &records[j].x, of_x, of_y, of_z, w);
        hn::StoreU(of_x, d, x + j);
        hn::StoreU(of_y, d, y + j);
        hn::StoreU(of_z, d, z + j);
      }
      for (; j < end; ++j) {
        x[j] = records[j].x;
        y[j] = records[j].y;
        z[j] = records[j].z;
      }
    });
    for (Coordinate* const of : {x, y, z}) std::fill(of + records.size(), of + memory.size() / 3, Coordinate{0});
  }
};

// The particles around one cell that may be neighbours of any particle in it, in storage order, with one array per
// coordinate. Gathered once for all particles of the cell; those farther than h from the cell's bounding box, about
// half, are left out.
template <class T>
class Candidates {
 public:
  static constexpr std::size_t padding = 64;
  using Index = hwy::MakeSigned<T>;

  void clear() { size_ = 0; }

  // `code`: the entry in `index` for the first of them; it increases by one for each of the following.
  void append(const Coordinates<T>& all, Range run, LocalId code, const Bounds<T>& bounds) {
    const auto [begin, end] = run;
    const hn::ScalableTag<T> d;
    const auto lanes = static_cast<LocalId>(hn::Lanes(d));
    reserve(size_ + static_cast<std::size_t>(end - begin) + padding);
    for (LocalId j = begin; j < end; j += lanes)
      append_vector(d, all, j, code + (j - begin), static_cast<std::size_t>(std::min(lanes, end - j)), bounds);
  }

  // Fills the vector past the last candidate with particles far away, so that whole vectors can be compared.
  void close() {
    const hn::ScalableTag<T> d;
    hn::StoreU(hn::Set(d, static_cast<T>(1e15)), d, &x[size_]);
  }

  std::size_t size() const { return size_; }

  std::vector<T> x, y, z;
  std::vector<Index> index;

 private:
  template <class D>
  HWY_INLINE void append_vector(D d, const Coordinates<T>& all, LocalId j, LocalId first, std::size_t left,
                                const Bounds<T>& bounds) {
    const hn::Rebind<typename Packed<T>::Coordinate, D> dc;
    const hn::RebindToSigned<D> di;
    const auto px = from_anchor(d, hn::LoadU(dc, all.x + j), bounds.anchor.x);
    const auto py = from_anchor(d, hn::LoadU(dc, all.y + j), bounds.anchor.y);
    const auto pz = from_anchor(d, hn::LoadU(dc, all.z + j), bounds.anchor.z);
    const auto dx = outside(d, px, bounds, 0), dy = outside(d, py, bounds, 1), dz = outside(d, pz, bounds, 2);
    const auto r2 = hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)));
    // A little more than h, so that no rounding drops a neighbour.
    const auto limit = hn::Set(d, static_cast<T>(1.0001 * Packed<T>::units_per_h * Packed<T>::units_per_h));
    const Chosen<D> near(d, hn::And(hn::FirstN(d, left), hn::Lt(r2, limit)));
    hn::StoreU(near.first(px), d, &x[size_]);
    hn::StoreU(near.first(py), d, &y[size_]);
    hn::StoreU(near.first(pz), d, &z[size_]);
    // Iota(0) is a constant; for another start the compiler would build the vector in memory.
    const auto self = hn::Add(hn::Iota(di, 0), hn::Set(di, first));
    hn::StoreU(hn::BitCast(di, near.first(hn::BitCast(d, self))), di, &index[size_]);
    size_ += near.count();
  }

  // How far p is outside the bounds along axis a.
  template <class D>
  static HWY_INLINE hn::Vec<D> outside(D d, hn::Vec<D> p, const Bounds<T>& bounds, std::size_t a) {
    const auto below = hn::Sub(hn::Set(d, bounds.low[a]), p), above = hn::Sub(p, hn::Set(d, bounds.high[a]));
    return hn::Max(hn::Max(below, above), hn::Zero(d));
  }

  void reserve(std::size_t n) {
    if (n <= x.size()) return;
    for (auto* field : {&x, &y, &z}) field->resize(2 * n);
    index.resize(2 * n);
  }
  std::size_t size_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

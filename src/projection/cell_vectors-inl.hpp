// Vectors of particles of a cell, and sums over them. Included once per instruction set.
#if defined(TREVI_PROJECTION_CELL_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_PROJECTION_CELL_VECTORS_INL
#undef TREVI_PROJECTION_CELL_VECTORS_INL
#else
#define TREVI_PROJECTION_CELL_VECTORS_INL
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "projection/cell_sums.hpp"
#include "projection/parameters.hpp"
#include "projection/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// A vector of particles of a cell.
struct ParticleVectors {
  V3 path;     // p − x, m
  V3 y, half;  // MotionSums; half of the path, in cells
};

HWY_INLINE V3 load(std::span<const Vec3> field, std::size_t i) {
  V3 v = zeros();
  if (i + hn::Lanes(Wide()) <= field.size()) {
    hn::LoadInterleaved3(Wide(), field[i].data(), v[0], v[1], v[2]);
  } else {  // whole vectors are read, so the last particles need padding behind them
    std::array<Vec3, max_lanes> last;
    last.fill(Vec3::Zero());
    if (i < field.size()) std::copy(field.begin() + static_cast<std::ptrdiff_t>(i), field.end(), last.begin());
    hn::LoadInterleaved3(Wide(), last[0].data(), v[0], v[1], v[2]);
  }
  return v;
}

HWY_INLINE ParticleVectors load(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                                std::size_t i) {
  constexpr Real max_half = projection::max_half_path;
  const V3 p = load(motion.p, i), x = load(motion.x, i);
  ParticleVectors particles{zeros(), zeros(), zeros()};
  for (std::size_t a = 0; a < 3; ++a) {
    const V in_cells = hn::Mul(hn::Sub(p[a], set(cell.place.origin[a])), set(frame.per_length[a]));
    const V here = hn::Sub(in_cells, set(cell.place.corner[a]));
    particles.path[a] = hn::Sub(p[a], x[a]);
    particles.half[a] = clamp(hn::Mul(particles.path[a], set(0.5 * frame.per_length[a])), -max_half, max_half);
    particles.y[a] = hn::Sub(here, particles.half[a]);
  }
  return particles;
}

// Where the volumes of particles are placed, in cells from the corner of the cell.
HWY_INLINE V3 places_of_volumes(const CellFrame& frame, const ParticleVectors& particles) {
  V3 places = particles.y;
  if (frame.by_gravity > 0) {
    places[2] = hn::Add(places[2], set(frame.by_gravity));
    return places;
  }
  constexpr Real max_path = projection::max_path;
  V3 path = particles.path;
  V longest = set(max_path);
  for (std::size_t a = 0; a < 3; ++a) {
    path[a] = hn::Mul(path[a], set(frame.per_length[a]));
    longest = hn::Max(longest, hn::Abs(path[a]));
  }
  const V back = hn::Div(set(max_path), longest);
  for (std::size_t a = 0; a < 3; ++a) places[a] = hn::NegMulAdd(path[a], back, hn::Add(places[a], particles.half[a]));
  return places;
}

template <class T>
HWY_INLINE auto narrowed(V v) {
  if constexpr (sizeof(T) == sizeof(double)) {
    return v;
  } else {
    return hn::DemoteTo(hn::Rebind<T, Wide>(), v);
  }
}

// Vectors and scalars of particles.
struct Vec4s {
  V3 u;
  V w;
};
// Stores those of the first `count` particles.
template <class T>
HWY_INLINE void store_vectors(const Vec4s& v, std::size_t count, Vec4<T>* out) {
  const hn::Rebind<T, Wide> d;
  const auto x = narrowed<T>(v.u[0]), y = narrowed<T>(v.u[1]), z = narrowed<T>(v.u[2]), w = narrowed<T>(v.w);
  if (count >= hn::Lanes(d)) return hn::StoreInterleaved4(x, y, z, w, d, &out->x);
  std::array<Vec4<T>, max_lanes> last;
  hn::StoreInterleaved4(x, y, z, w, d, &last[0].x);
  std::copy_n(last.begin(), count, out);
}

// Particle k of a cell is added to lane k modulo 8 on every processor.
constexpr std::size_t virtual_lanes = 8;

// `first`: nothing has yet been added to these lanes.
template <bool first>
HWY_INLINE void add_to_lanes(Real* at, V v) {
  const Wide d;
  hn::Store(first ? v : hn::Add(hn::Load(d, at), v), d, at);
}

// The sums of quantities over the virtual lanes, formed in the same order on every processor.
using Two = hn::FixedTag<double, 2>;
HWY_INLINE auto folded(const double* lane) {
  const Two d;
  return hn::Add(hn::Add(hn::Load(d, lane), hn::Load(d, lane + 4)),
                 hn::Add(hn::Load(d, lane + 2), hn::Load(d, lane + 6)));
}
HWY_INLINE void fold_two(const Real (*lanes)[virtual_lanes], std::size_t q, double* out) {
  const Two d;
  const auto a = folded(lanes[q]), b = folded(lanes[q + 1]);
  hn::StoreU(hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b)), d, out);
}

// For two quantities: the even and odd lanes of the first, then those of the second.
HWY_INLINE V even_and_odd(const double* one, const double* other) {
  const Wide d;
  const V a = hn::Add(hn::Load(d, one), hn::Load(d, one + 4));
  const V b = hn::Add(hn::Load(d, other), hn::Load(d, other + 4));
  return hn::Add(hn::ConcatLowerLower(d, b, a), hn::ConcatUpperUpper(d, b, a));
}
HWY_INLINE void fold_four(const Real (*lanes)[virtual_lanes], std::size_t q, double* out) {
  if constexpr (hn::MaxLanes(Wide()) < 4) {
    fold_two(lanes, q, out);
    fold_two(lanes, q + 2, out + 2);
  } else {
    const Wide d;
    const V first = even_and_odd(lanes[q], lanes[q + 2]), second = even_and_odd(lanes[q + 1], lanes[q + 3]);
    hn::StoreU(hn::Add(hn::InterleaveLower(d, first, second), hn::InterleaveUpper(d, first, second)), d, out);
  }
}

template <std::size_t count>
HWY_INLINE void fold_all(const Real (*lanes)[virtual_lanes], double* out) {
  constexpr std::size_t fours = count / 4 * 4;
  for (std::size_t q = 0; q < fours; q += 4) fold_four(lanes, q, out + q);
  if constexpr (count % 4 >= 2) fold_two(lanes, fours, out + fours);
  if constexpr (count % 2 == 1) {
    const auto last = folded(lanes[count - 1]);
    out[count - 1] = hn::GetLane(hn::Add(last, hn::InterleaveUpper(Two(), last, last)));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();
#endif

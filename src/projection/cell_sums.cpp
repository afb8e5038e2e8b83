// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/cell_sums.hpp"

#include "projection/parameters.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/cell_sums.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t virtual_lanes = 8;
using Wide = hn::CappedTag<double, virtual_lanes>;
using V = hn::Vec<Wide>;
using V3 = std::array<V, 3>;

HWY_INLINE V set(Real a) { return hn::Set(Wide(), a); }
HWY_INLINE V clamp(V v, Real low, Real high) { return hn::Min(hn::Max(v, set(low)), set(high)); }

// A vector of particles of a cell; lanes of `valid` hold one.
struct Particles8 {
  V3 path;     // p − x, m
  V3 surface;  // surface position, in cells from the corner of the cell
  V3 y, f;     // MotionSums
};

// Always made with values: the default constructor would not be of this instruction set.
HWY_INLINE V3 zeros() { return {hn::Zero(Wide()), hn::Zero(Wide()), hn::Zero(Wide())}; }

HWY_INLINE V3 load(std::span<const Vec3> field, std::size_t i) {
  V3 v = zeros();
  if (i + hn::Lanes(Wide()) <= field.size()) {
    hn::LoadInterleaved3(Wide(), field[i].data(), v[0], v[1], v[2]);
  } else {  // whole vectors are read, so the last particles need something behind them
    std::array<Vec3, virtual_lanes> last;
    last.fill(Vec3::Zero());
    if (i < field.size()) std::copy(field.begin() + static_cast<std::ptrdiff_t>(i), field.end(), last.begin());
    hn::LoadInterleaved3(Wide(), last[0].data(), v[0], v[1], v[2]);
  }
  return v;
}

HWY_INLINE Particles8 load(const CellFrame& frame, const Motion& motion, const CellParticles& cell, std::size_t i) {
  constexpr Real most_half = projection::most_half_path, most = projection::most_path;
  const V3 p = load(motion.p, i), x = load(motion.x, i);
  Particles8 particles{zeros(), zeros(), zeros(), zeros()};
  for (std::size_t a = 0; a < 3; ++a) {
    const V in_cells = hn::Mul(hn::Sub(p[a], set(cell.place.origin[a])), set(frame.per_length[a]));
    const V here = hn::Sub(in_cells, set(cell.place.corner[a]));
    particles.path[a] = hn::Sub(p[a], x[a]);
    const V half = clamp(hn::Mul(particles.path[a], set(0.5 * frame.per_length[a])), -most_half, most_half);
    particles.y[a] = hn::Sub(here, half);
    particles.f[a] = hn::Sub(particles.y[a], half);
    particles.surface[a] = hn::Sub(here, clamp(hn::Add(half, half), -most, most));
  }
  return particles;
}

// What particles of a cell add to its sums, in as many arrays of virtual lanes.
struct Lanes {
  static constexpr std::size_t moments = 22, volumes = 27;
  alignas(64) double value[moments + volumes][virtual_lanes];
};

// The part of each cube below the cell along a, in it and above it.
HWY_INLINE V3 parts(const CellFrame& frame, const Particles8& particles, const ByAxis& corner, std::size_t a) {
  const Real half = frame.half[a], per_cube = 0.5 / half;
  const V mid = clamp(particles.surface[a], frame.nearest[a] - corner[a], frame.farthest[a] - corner[a]);
  const V below = clamp(hn::Mul(hn::Sub(set(half), mid), set(per_cube)), 0, 1);
  const V above = clamp(hn::Mul(hn::Add(mid, set(half - 1)), set(per_cube)), 0, 1);
  return {below, hn::Sub(hn::Sub(set(1), below), above), above};
}

// first: nothing has been added to these lanes before.
template <bool first>
HWY_INLINE void add(Lanes& lanes, std::size_t quantity, std::size_t lane, V v) {
  const Wide d;
  double* at = &lanes.value[quantity][lane];
  hn::Store(first ? v : hn::Add(hn::Load(d, at), v), d, at);
}

template <bool first>
HWY_INLINE void add_motion(const Particles8& particles, hn::Mask<Wide> valid, std::size_t lane, Lanes& lanes) {
  V3 y = zeros(), u = zeros();
  for (std::size_t a = 0; a < 3; ++a) {
    y[a] = hn::IfThenElseZero(valid, particles.y[a]);
    u[a] = hn::IfThenElseZero(valid, particles.path[a]);
    add<first>(lanes, a, lane, y[a]);
    add<first>(lanes, 3 + a, lane, hn::Mul(y[a], y[a]));
    add<first>(lanes, 9 + a, lane, u[a]);
  }
  add<first>(lanes, 6, lane, hn::Mul(y[0], y[1]));
  add<first>(lanes, 7, lane, hn::Mul(y[0], y[2]));
  add<first>(lanes, 8, lane, hn::Mul(y[1], y[2]));
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) add<first>(lanes, 12 + 3 * a + b, lane, hn::Mul(u[a], y[b]));
  }
  add<first>(lanes, 21, lane, hn::MulAdd(u[2], u[2], hn::MulAdd(u[1], u[1], hn::Mul(u[0], u[0]))));
}

template <bool first, bool volumes>
HWY_INLINE void add_particles(const CellFrame& frame, const Motion& motion, const CellParticles& cell, std::size_t i,
                              Lanes& lanes) {
  const Wide d;
  for (std::size_t lane = 0; lane < virtual_lanes; lane += hn::Lanes(d)) {
    const std::size_t begin = i + lane, count = cell.end > begin ? cell.end - begin : 0;
    const auto valid = hn::FirstN(d, std::min(count, hn::Lanes(d)));
    const Particles8 particles = load(frame, motion, cell, begin);
    add_motion<first>(particles, valid, lane, lanes);
    if constexpr (volumes) {
      V3 x = parts(frame, particles, cell.place.corner, 0);
      const V3 y = parts(frame, particles, cell.place.corner, 1), z = parts(frame, particles, cell.place.corner, 2);
      for (V& part : x) part = hn::IfThenElseZero(valid, hn::Mul(part, set(frame.per_full)));
      for (std::size_t b = 0; b < 9; ++b) {
        const V xy = hn::Mul(x[b / 3], y[b % 3]);
        for (std::size_t c = 0; c < 3; ++c) add<first>(lanes, Lanes::moments + 3 * b + c, lane, hn::Mul(xy, z[c]));
      }
    }
  }
}

// The sums over the virtual lanes of quantities, in the same order on every processor.
using Two = hn::FixedTag<double, 2>;
HWY_INLINE auto folded(const double* lane) {
  const Two d;
  return hn::Add(hn::Add(hn::Load(d, lane), hn::Load(d, lane + 4)),
                 hn::Add(hn::Load(d, lane + 2), hn::Load(d, lane + 6)));
}
HWY_INLINE void fold_two(const Lanes& lanes, std::size_t q, double* out) {
  const Two d;
  const auto a = folded(lanes.value[q]), b = folded(lanes.value[q + 1]);
  hn::StoreU(hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b)), d, out);
}

using Four = hn::CappedTag<double, 4>;
// Of two quantities: even and odd lanes of the one, then of the other.
HWY_INLINE auto even_and_odd(const double* one, const double* other) {
  const Four d;
  const auto a = hn::Add(hn::Load(d, one), hn::Load(d, one + 4));
  const auto b = hn::Add(hn::Load(d, other), hn::Load(d, other + 4));
  return hn::Add(hn::ConcatLowerLower(d, b, a), hn::ConcatUpperUpper(d, b, a));
}
HWY_INLINE void fold_four(const Lanes& lanes, std::size_t q, double* out) {
  if constexpr (hn::MaxLanes(Four()) < 4) {
    fold_two(lanes, q, out);
    fold_two(lanes, q + 2, out + 2);
  } else {
    const Four d;
    const auto first = even_and_odd(lanes.value[q], lanes.value[q + 2]);
    const auto second = even_and_odd(lanes.value[q + 1], lanes.value[q + 3]);
    hn::StoreU(hn::Add(hn::InterleaveLower(d, first, second), hn::InterleaveUpper(d, first, second)), d, out);
  }
}

template <std::size_t count>
HWY_INLINE void fold_all(const Lanes& lanes, double* out) {
  constexpr std::size_t fours = count / 4 * 4;
  for (std::size_t q = 0; q < fours; q += 4) fold_four(lanes, q, out + q);
  if constexpr (count % 4 >= 2) fold_two(lanes, fours, out + fours);
  if constexpr (count % 2 == 1) {
    const auto last = folded(lanes.value[count - 1]);
    out[count - 1] = hn::GetLane(hn::Add(last, hn::InterleaveUpper(Two(), last, last)));
  }
}

template <bool volumes>
HWY_INLINE void sum_particles(const CellFrame& frame, const Motion& motion, const CellParticles& cell, Lanes& lanes) {
  add_particles<true, volumes>(frame, motion, cell, cell.begin, lanes);
  for (std::size_t i = cell.begin + virtual_lanes; i < cell.end; i += virtual_lanes)
    add_particles<false, volumes>(frame, motion, cell, i, lanes);
}

CellSums sum_cell_of(const CellFrame& frame, const Motion& motion, const CellParticles& cell) {
  constexpr std::size_t count = Lanes::moments + Lanes::volumes;
  Lanes lanes;
  sum_particles<true>(frame, motion, cell, lanes);
  static_assert(sizeof(CellSums) == count * sizeof(double));
  CellSums sums;
  fold_all<count>(lanes, reinterpret_cast<double*>(&sums));
  return sums;
}

MotionSums sum_motion_of(const CellFrame& frame, const Motion& motion, const CellParticles& cell) {
  Lanes lanes;
  sum_particles<false>(frame, motion, cell, lanes);
  static_assert(sizeof(MotionSums) == Lanes::moments * sizeof(double));
  MotionSums sums;
  fold_all<Lanes::moments>(lanes, reinterpret_cast<double*>(&sums));
  return sums;
}

struct Displaced {
  V3 u;
  V act;
};

HWY_INLINE Displaced displacements(const Particles8& particles, const CellParticles& cell, const CellDisplacement& by) {
  const V above = hn::Sub(particles.surface[2], set(by.surface - cell.place.corner[2]));
  const V faded = clamp(hn::Sub(set(by.at_surface), hn::Mul(above, set(by.fade))), 0, 1);
  Displaced out{zeros(), hn::Mul(faded, set(by.act))};
  for (std::size_t a = 0; a < 3; ++a) {
    V u = hn::MulAdd(particles.f[a], set(by.rise[a]), set(by.low[a]));
    V damped = hn::NegMulAdd(set(by.own), particles.path[a], set(by.offset[a]));
    for (std::size_t b = 0; b < 3; ++b) damped = hn::MulAdd(particles.y[b], set(by.slope[a][b]), damped);
    out.u[a] = hn::Mul(hn::Add(u, damped), faded);
  }
  return out;
}

template <class T>
HWY_INLINE auto narrowed(V v) {
  if constexpr (sizeof(T) == sizeof(double)) {
    return v;
  } else {
    return hn::DemoteTo(hn::Rebind<T, Wide>(), v);
  }
}

template <class T>
void displace_cell_of(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                      const CellDisplacement& by, Vec4<T>* out) {
  const std::size_t lanes = hn::Lanes(Wide());
  const hn::Rebind<T, Wide> d;
  for (std::size_t i = cell.begin; i < cell.end; i += lanes, out += lanes) {
    const Displaced by_cell = displacements(load(frame, motion, cell, i), cell, by);
    const auto x = narrowed<T>(by_cell.u[0]), y = narrowed<T>(by_cell.u[1]), z = narrowed<T>(by_cell.u[2]);
    const auto act = narrowed<T>(by_cell.act);
    if (i + lanes <= cell.end) {
      hn::StoreInterleaved4(x, y, z, act, d, &out->x);
    } else {
      std::array<Vec4<T>, virtual_lanes> last;
      hn::StoreInterleaved4(x, y, z, act, d, &last[0].x);
      std::copy_n(last.begin(), cell.end - i, out);
    }
  }
}

// Highway's dispatch takes no templates.
void displace_single(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                     const CellDisplacement& by, Vec4<float>* out) {
  displace_cell_of(frame, motion, cell, by, out);
}
void displace_double(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                     const CellDisplacement& by, Vec4<double>* out) {
  displace_cell_of(frame, motion, cell, by, out);
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(sum_cell_of);
HWY_EXPORT(sum_motion_of);
HWY_EXPORT(displace_single);
HWY_EXPORT(displace_double);

CellSums sum_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell) {
  return HWY_DYNAMIC_DISPATCH(sum_cell_of)(frame, motion, cell);
}
MotionSums sum_motion(const CellFrame& frame, const Motion& motion, const CellParticles& cell) {
  return HWY_DYNAMIC_DISPATCH(sum_motion_of)(frame, motion, cell);
}
template <>
void displace_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell, const CellDisplacement& by,
                   Vec4<float>* out) {
  HWY_DYNAMIC_DISPATCH(displace_single)(frame, motion, cell, by, out);
}
template <>
void displace_cell(const CellFrame& frame, const Motion& motion, const CellParticles& cell, const CellDisplacement& by,
                   Vec4<double>* out) {
  HWY_DYNAMIC_DISPATCH(displace_double)(frame, motion, cell, by, out);
}

}  // namespace trevi
#endif

// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/cell_sums.hpp"

#include <array>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/cell_sums.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include "projection/cell_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// The contributions of the particles of a cell to its sums, with one array of virtual lanes for each quantity.
struct Lanes {
  static constexpr std::size_t moments = 22, volumes = 27;
  alignas(64) double value[moments + volumes][virtual_lanes];
};

HWY_INLINE V square_above_zero(V v) {
  const V positive = hn::Max(v, set(0));
  return hn::Mul(positive, positive);
}

// The fraction of a particle that lies more than `way` beyond its centre, in cells: the integral of its density.
HWY_INLINE V part_beyond(const CellFrame& frame, V way, std::size_t a) {
  const Real flat = frame.flat[a], reach = frame.reach[a];
  const V w = hn::Max(way, set(-reach));
  const V sloped = hn::Sub(square_above_zero(hn::Sub(set(reach), w)), square_above_zero(hn::Sub(set(flat), w)));
  return hn::Mul(hn::Sub(sloped, square_above_zero(hn::Sub(set(-flat), w))), set(0.5 / (reach * reach - flat * flat)));
}

// The fraction of each particle's volume that goes to the next cell along a: what lies beyond the face, `way` from the
// place of the particle, and what lies beyond that cell a second time, at the expense of the own cell. The mean
// position is thus kept. Without this the volumes of fast water are ahead of it, and waves on a current of two thirds
// of a cell a step grow or decay by 0.13 a second.
HWY_INLINE V part_beside(const CellFrame& frame, V way, std::size_t a, bool more_cells) {
  const V beyond = part_beyond(frame, way, a);
  const bool reaches = frame.reach[a] > 1 - projection::max_half_path;
  return more_cells && reaches ? hn::Add(beyond, part_beyond(frame, hn::Add(way, set(1)), a)) : beyond;
}

// The fractions of each particle's volume that go to the cell below along a, to its own cell and to that above.
HWY_INLINE V3 parts(const CellFrame& frame, const V3& places, const ByAxis& corner, std::size_t a) {
  const Real floor = frame.floor[a] - corner[a], ceiling = frame.ceiling[a] - corner[a];
  const V mid = clamp(places[a], frame.nearest[a] - corner[a], frame.farthest[a] - corner[a]);
  const V below = floor < 0 ? part_beside(frame, mid, a, floor < -1) : set(0);
  const V above = ceiling > 1 ? part_beside(frame, hn::Sub(set(1), mid), a, ceiling > 2) : set(0);
  return {below, hn::Sub(hn::Sub(set(1), below), above), above};
}

template <bool first>
HWY_INLINE void add(Lanes& lanes, std::size_t quantity, std::size_t lane, V v) {
  add_to_lanes<first>(&lanes.value[quantity][lane], v);
}

template <bool first>
HWY_INLINE void add_motion(const ParticleVectors& particles, hn::Mask<Wide> valid, std::size_t lane, Lanes& lanes) {
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
    const ParticleVectors particles = load(frame, motion, cell, begin);
    add_motion<first>(particles, valid, lane, lanes);
    if constexpr (volumes) {
      const V3 places = places_of_volumes(frame, particles);
      V3 x = parts(frame, places, cell.place.corner, 0);
      const V3 y = parts(frame, places, cell.place.corner, 1), z = parts(frame, places, cell.place.corner, 2);
      for (V& part : x) part = hn::IfThenElseZero(valid, hn::Mul(part, set(frame.per_full)));
      for (std::size_t b = 0; b < 9; ++b) {
        const V xy = hn::Mul(x[b / 3], y[b % 3]);
        for (std::size_t c = 0; c < 3; ++c) add<first>(lanes, Lanes::moments + 3 * b + c, lane, hn::Mul(xy, z[c]));
      }
    }
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
  std::array<double, count> sums;
  fold_all<count>(lanes.value, sums.data());
  return std::bit_cast<CellSums>(sums);
}

MotionSums sum_motion_of(const CellFrame& frame, const Motion& motion, const CellParticles& cell) {
  Lanes lanes;
  sum_particles<false>(frame, motion, cell, lanes);
  std::array<double, Lanes::moments> sums;
  fold_all<Lanes::moments>(lanes.value, sums.data());
  return std::bit_cast<MotionSums>(sums);
}

HWY_INLINE Vec4s displacements(const CellFrame& frame, const ParticleVectors& particles, const CellParticles& cell,
                               const CellDisplacement& by) {
  constexpr Real max_shift = projection::max_fade_shift;
  const V begin = hn::Sub(particles.y[2], particles.half[2]);
  const V z = hn::Add(begin, clamp(hn::Add(particles.half[2], set(frame.by_gravity)), -max_shift, max_shift));
  const V above = hn::Sub(z, set(by.surface - cell.place.corner[2]));
  const V faded = clamp(hn::Sub(set(by.at_surface), hn::Mul(above, set(by.fade))), 0, 1);
  Vec4s out{zeros(), hn::Mul(faded, set(by.act))};
  for (std::size_t a = 0; a < 3; ++a) {
    const V place = hn::NegMulAdd(set(by.back), particles.half[a], particles.y[a]);
    const V u = hn::MulAdd(place, set(by.rise[a]), set(by.low[a]));
    V more = hn::NegMulAdd(set(by.own), particles.path[a], set(by.offset[a]));
    for (std::size_t b = 0; b < 3; ++b) more = hn::MulAdd(particles.y[b], set(by.slope[a][b]), more);
    out.u[a] = hn::Mul(hn::Add(u, more), faded);
  }
  return out;
}

template <class T>
void displace_cell_of(const CellFrame& frame, const Motion& motion, const CellParticles& cell,
                      const CellDisplacement& by, Vec4<T>* out) {
  const std::size_t lanes = hn::Lanes(Wide());
  for (std::size_t i = cell.begin; i < cell.end; i += lanes, out += lanes)
    store_vectors<T>(displacements(frame, load(frame, motion, cell, i), cell, by), cell.end - i, out);
}

// Highway's dispatch does not support templates.
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

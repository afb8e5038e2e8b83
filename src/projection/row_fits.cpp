// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/row_fits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/row_fits.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include "projection/row_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// What a fit needs to know about the positions of its particles.
struct SpreadVectors {
  V per_n;
  V3 mean;
  std::array<V, 6> inverse;  // of the variance: xx, yy, zz, xy, xz, yz
};

using Symmetric = std::array<V, 6>;
HWY_INLINE V dot(V a, V b, V c, V x, V y, V z) { return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::Mul(c, z))); }
// Product of two symmetric matrices that commute.
HWY_INLINE Symmetric product(const Symmetric& a, const Symmetric& b) {
  return {dot(a[0], a[3], a[4], b[0], b[3], b[4]), dot(a[3], a[1], a[5], b[3], b[1], b[5]),
          dot(a[4], a[5], a[2], b[4], b[5], b[2]), dot(a[0], a[3], a[4], b[3], b[1], b[5]),
          dot(a[0], a[3], a[4], b[4], b[5], b[2]), dot(a[3], a[1], a[5], b[4], b[5], b[2])};
}

// The inverse P of a variance to which the damping e, cells², has been added. What the damping leaves out of a fit is
// fitted in turn, twice: P + e P² + e² P³. Where there is a variance, only (e P)³ of the damping's effect remains;
// where there is none, the inverse is bounded by 3/e.
HWY_INLINE Symmetric inverse_of(const Symmetric& v, V e) {
  const V xx = v[0], yy = v[1], zz = v[2], xy = v[3], xz = v[4], yz = v[5];
  const auto minor = [](V a, V b, V c, V d) { return hn::NegMulAdd(c, d, hn::Mul(a, b)); };
  Symmetric once = {minor(yy, zz, yz, yz), minor(xx, zz, xz, xz), minor(xx, yy, xy, xy),
                    minor(xz, yz, xy, zz), minor(xy, yz, xz, yy), minor(xy, xz, xx, yz)};
  const V determinant = dot(xx, xy, xz, once[0], once[3], once[4]);
  const V per = hn::Div(set(1), hn::Max(determinant, hn::Mul(hn::Mul(hn::Mul(set(0.5), e), e), e)));
  for (V& one : once) one = hn::Mul(one, per);
  const Symmetric twice = product(once, once), thrice = product(twice, once);
  Symmetric sum = once;
  for (std::size_t q = 0; q < 6; ++q) sum[q] = hn::MulAdd(e, hn::MulAdd(e, thrice[q], twice[q]), once[q]);
  return sum;
}

// Where there are no particles, the numbers are finite.
HWY_INLINE SpreadVectors spread_of(const Numbers<>& places, V damping) {
  const V n = places[0], per_n = hn::Div(set(1), hn::IfThenElse(hn::Gt(n, set(0)), n, set(1)));
  V3 mean = zeros();
  for (std::size_t a = 0; a < 3; ++a) mean[a] = hn::Mul(places[1 + a], per_n);
  const auto variance = [&](std::size_t q, V a, V b) { return hn::NegMulAdd(a, b, hn::Mul(places[4 + q], per_n)); };
  // Rounding may make the variance of a single particle, with the damping added, less than the damping itself.
  const auto own = [&](std::size_t a) { return hn::Max(hn::Add(variance(a, mean[a], mean[a]), damping), damping); };
  return {per_n, mean,
          inverse_of({own(0), own(1), own(2), variance(3, mean[0], mean[1]), variance(4, mean[0], mean[2]),
                      variance(5, mean[1], mean[2])},
                     damping)};
}

struct FitVectors {
  V3 a;
  std::array<V3, 3> b;
  V explained;  // part of the mean square of the motion that the fit explains
};

HWY_INLINE FitVectors fit_of(const SpreadVectors& s, const Numbers<>& flow) {
  FitVectors fit{zeros(), {zeros(), zeros(), zeros()}, set(0)};
  const Symmetric& p = s.inverse;
  for (std::size_t i = 0; i < 3; ++i) {
    const V mean = hn::Mul(flow[i], s.per_n);
    V3 covariance = zeros();
    for (std::size_t j = 0; j < 3; ++j)
      covariance[j] = hn::NegMulAdd(mean, s.mean[j], hn::Mul(flow[3 + 3 * i + j], s.per_n));
    const V x = covariance[0], y = covariance[1], z = covariance[2];
    fit.b[i] = {dot(x, y, z, p[0], p[3], p[4]), dot(x, y, z, p[3], p[1], p[5]), dot(x, y, z, p[4], p[5], p[2])};
    fit.a[i] = hn::Sub(mean, dot(fit.b[i][0], fit.b[i][1], fit.b[i][2], s.mean[0], s.mean[1], s.mean[2]));
    fit.explained = hn::Add(hn::MulAdd(mean, mean, fit.explained), dot(fit.b[i][0], fit.b[i][1], fit.b[i][2], x, y, z));
  }
  return fit;
}

struct MotionVectors {
  SpreadVectors spread;
  FitVectors fit;
};

HWY_INLINE MotionVectors motion_of(const Numbers<>& places, const Numbers<>& flow, V damping) {
  const SpreadVectors spread = spread_of(places, damping);
  return {spread, fit_of(spread, flow)};
}

// The rate at which a fit compresses its cell, over its strain: 1 if all of the strain is compression, -1 if it is
// expansion.
HWY_INLINE V compression_of(const FitVectors& fit, const ByAxis& per_length) {
  const auto slope = [&](std::size_t i, std::size_t j) { return hn::Mul(fit.b[i][j], set(per_length[j])); };
  const V xx = slope(0, 0), yy = slope(1, 1), zz = slope(2, 2);
  const V xy = hn::Add(slope(0, 1), slope(1, 0)), xz = hn::Add(slope(0, 2), slope(2, 0)),
          yz = hn::Add(slope(1, 2), slope(2, 1));
  const V strain2 = hn::MulAdd(set(0.5), dot(xy, xz, yz, xy, xz, yz), dot(xx, yy, zz, xx, yy, zz));
  const V strain = hn::Sqrt(hn::Max(strain2, set(1e-200)));
  return hn::Div(hn::Sub(set(0), hn::Add(xx, hn::Add(yy, zz))), strain);
}

// How flat the particles of a fit lie, from the inverse of the sum of the inverses of the variances of their positions
// along the principal axes: 0 where that is projection::flat_variance or more, 1 where it is half of that or less. In a
// layer all of them lie in its plane.
HWY_INLINE V flatness_of(const SpreadVectors& spread, bool is_layer) {
  const Symmetric& p = spread.inverse;
  const V in_plane = hn::Add(p[0], p[2]), trace = is_layer ? in_plane : hn::Add(in_plane, p[1]);
  return clamp(hn::MulSub(trace, set(projection::flat_variance), set(1)), 0, 1);
}

// Few particles that meet say little about how the faces of their cell close, and at solids about how they open (see
// projection::few_damping). The damping grows from nothing, where half of the strain or less is compression, to its
// full value, where all of it is. Away from solids, particles in a plane or on a line say little about the motion
// across it (projection::flat_damping).
HWY_INLINE MotionVectors motion_around(const RowsAround& moments, const MotionFits& out, const Part& part,
                                       const Numbers<>& places, const Numbers<>& flow) {
  const Wide d;
  const V damping = set(projection::fit_damping);
  const MotionVectors motion = motion_of(places, flow, damping);
  const auto at_solid = hn::Gt(out.at_solid != nullptr ? load(out.at_solid, part) : set(0), set(0));
  const V few = hn::IfThenElse(at_solid, set(projection::few_at_solid), set(projection::few));
  const V held = hn::Mul(places[0], set(out.frame.per_full * moments.per_tent));
  const V missing = hn::Max(hn::Sub(set(1), hn::Div(held, few)), set(0));
  if (hn::AllFalse(d, hn::Gt(missing, set(0)))) return motion;
  const V closing = compression_of(motion.fit, out.frame.per_length);
  const V told = hn::IfThenElse(at_solid, hn::Abs(closing), closing);
  const V by_strain = hn::Mul(set(projection::few_damping), clamp(hn::MulSub(set(2), told, set(1)), 0, 1));
  const V flatness = hn::IfThenZeroElse(at_solid, flatness_of(motion.spread, moments.is_layer));
  const V more = hn::Mul(missing, hn::Max(by_strain, hn::Mul(set(projection::flat_damping), flatness)));
  if (hn::AllFalse(d, hn::Gt(more, set(0)))) return motion;
  return motion_of(places, flow, hn::Add(more, damping));
}

HWY_INLINE void write(const FitVectors& fit, V factor, Real* map) {
  write(factor, map, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    write(hn::Mul(factor, fit.a[i]), map, 1 + i);
    for (std::size_t j = 0; j < 3; ++j) write(hn::Mul(factor, fit.b[i][j]), map, 4 + 3 * i + j);
  }
}

// 1 where a cell holds particles, otherwise 0.
HWY_INLINE V holds_any(const RowsAround& moments, const Part& part) {
  const V n = hn::Load(Wide(), part.of(moments.rows[1][1]));
  return hn::IfThenElse(hn::Gt(n, set(0)), set(1), set(0));
}

void fit_motion_of(const RowsAround& moments, const MotionFits& out) {
  const SixCells* const sums = sum_across<MomentSums>(moments);
  for (Part part = cells_of(moments); part.begin < part.end; ++part) {
    if (!part.is_in(out.fit)) continue;
    const TentSums<MomentSums> around(sums, part);
    const auto [spread, fit] = motion_around(moments, out, part, around.from(), around.from(10));
    write(fit, holds_any(moments, part), part.of(out.fit));
    Real* const places = part.of(out.spread);
    write(spread.per_n, places, 0);
    for (std::size_t a = 0; a < 3; ++a) write(spread.mean[a], places, 1 + a);
    for (std::size_t q = 0; q < 6; ++q) write(spread.inverse[q], places, 4 + q);
    write(hn::Max(hn::MulSub(around.from()[22], spread.per_n, fit.explained), set(0)), places, 10);
  }
}

void fit_shifts_of(const RowsAround& moments, const ShiftFits& out) {
  const SixCells* const sums = sum_across<MomentSums>(moments);
  for (Part part = cells_of(moments); part.begin < part.end; ++part) {
    if (!part.is_in(out.fit)) continue;
    const TentSums<MomentSums> around(sums, part);
    const SpreadVectors spread = spread_of(around.from(), set(projection::fit_damping));
    write(fit_of(spread, around.from(10)), load(out.factor, part), part.of(out.fit));
    store(hn::Mul(around.from()[22], spread.per_n), part, out.mean);
  }
}

void filter_motion_of(const RowsAround& maps, const RowToRead& moments, const RowToWrite& flow) {
  const SixCells* const sums = sum_across<MapSums>(maps);
  for (Part part = cells_of(maps); part.begin < part.end; ++part) {
    if (!part.is_in(flow)) continue;
    const TentSums<MapSums> around(sums, part);
    const Numbers<> map = around.from(), own{part.of(moments)};
    Real* const out = part.of(flow);
    const V weight = hn::Mul(map[0], set(maps.per_tent)), n = own[0];
    const V3 y = {own[1], own[2], own[3]};
    const Symmetric yy = {own[4], own[5], own[6], own[7], own[8], own[9]};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto scaled = [&](std::size_t q) { return hn::Mul(map[q], set(maps.per_tent)); };
      const V a = scaled(1 + i), x = scaled(4 + 3 * i), b = scaled(5 + 3 * i), z = scaled(6 + 3 * i);
      const auto less = [&](V sum, std::size_t q) { return hn::NegMulAdd(weight, own[10 + q], sum); };
      write(less(hn::MulAdd(a, n, dot(x, b, z, y[0], y[1], y[2])), i), out, i);
      const V3 slopes = {dot(x, b, z, yy[0], yy[3], yy[4]), dot(x, b, z, yy[3], yy[1], yy[5]),
                         dot(x, b, z, yy[4], yy[5], yy[2])};
      for (std::size_t j = 0; j < 3; ++j)
        write(less(hn::MulAdd(a, y[j], slopes[j]), 3 + 3 * i + j), out, 3 + 3 * i + j);
    }
  }
}

void fit_flow_of(const RowsAround& flow, const FlowFits& out) {
  const SixCells* const sums = sum_across<FlowSums>(flow);
  for (Part part = cells_of(flow); part.begin < part.end; ++part) {
    if (!part.is_in(out.fit)) continue;
    const TentSums<FlowSums> around(sums, part);
    const Numbers<> places{part.of(out.spread)};
    const SpreadVectors spread = {places[0],
                                  {places[1], places[2], places[3]},
                                  {places[4], places[5], places[6], places[7], places[8], places[9]}};
    write(fit_of(spread, around.from()), load(out.factor, part), part.of(out.fit));
  }
}

void damp_noise_of(const RowsAround& noise, const RowsAround& maps, FourCells* damping) {
  const SixCells *const noise_sums = sum_across<MapSums>(noise), *const map_sums = sum_across<MapSums>(maps);
  for (Part part = cells_of(noise); part.begin < part.end; ++part) {
    if (!part.is_in(noise.rows[1][1])) continue;
    const TentSums<MapSums> second(noise_sums, part), first(map_sums, part);
    Real* const out = part.of(damping, numbers::map);
    const V whole = set(maps.per_tent), kept = hn::Mul(hn::Mul(whole, whole), second.from()[0]);
    write(hn::Mul(kept, first.from()[0]), out, 0);
    for (std::size_t q = 1; q < numbers::map; ++q)
      write(hn::MulSub(kept, first.from()[q], hn::Mul(whole, second.from()[q])), out, q);
  }
}

void add_maps_of(const RowsAround& maps, FourCells* sum) {
  const SixCells* const sums = sum_across<MapSums>(maps);
  for (Part part = cells_of(maps); part.begin < part.end; ++part) {
    if (!part.is_in(maps.rows[1][1])) continue;
    const TentSums<MapSums> around(sums, part);
    Real* const out = part.of(sum, numbers::map);
    for (std::size_t q = 0; q < numbers::map; ++q)
      write(hn::MulAdd(set(maps.per_tent), around.from()[q], Numbers<>{out}[q]), out, q);
  }
}

void average_maps_of(const RowsAround& maps, const Real* factor, FourCells* mean) {
  const SixCells* const sums = sum_across<MapSums>(maps);
  for (Part part = cells_of(maps); part.begin < part.end; ++part) {
    if (!part.is_in(maps.rows[1][1])) continue;
    const TentSums<MapSums> around(sums, part);
    Real* const out = part.of(mean, numbers::map);
    const V weight = around.from()[0];
    const auto any = hn::Gt(weight, set(0));
    const V factor_over_weight =
        hn::IfThenElseZero(any, hn::Div(load(factor, part), hn::IfThenElse(any, weight, set(1))));
    for (std::size_t q = 0; q < numbers::map; ++q) write(hn::Mul(factor_over_weight, around.from()[q]), out, q);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(fit_motion_of);
HWY_EXPORT(fit_shifts_of);
HWY_EXPORT(filter_motion_of);
HWY_EXPORT(fit_flow_of);
HWY_EXPORT(damp_noise_of);
HWY_EXPORT(add_maps_of);
HWY_EXPORT(average_maps_of);

// 1 over the weight of a whole tent, which extends along two axes in two dimensions.
template <int axes>
constexpr Real per_tent_of = 1 / ((axes == 2 ? 1 : 1 + 2 * projection::tent) * (1 + 2 * projection::tent) *
                                  (1 + 2 * projection::tent));

RowsAround rows_around(const ProjectionGrid& grid, const CellFields& field, RowPlace row, TentMemory& memory) {
  const bool repeats = grid.repeats()[2];
  RowsAround around{{},
                    row.k,
                    row.r,
                    {grid.axis(0), grid.axis(1)},
                    static_cast<std::size_t>(repeats ? 0 : row.cells.begin),
                    static_cast<std::size_t>(repeats ? grid.columns() : row.cells.end),
                    static_cast<std::size_t>(grid.columns()),
                    repeats,
                    memory,
                    grid.is_layer() ? per_tent_of<2> : per_tent_of<3>,
                    grid.is_layer()};
  for (LocalId i = 0; i < 3; ++i) {
    const LocalId r = grid.row_beside(row.r - 1 + i);
    for (LocalId j = 0; j < 3; ++j)
      around.rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = field.row(row.k - 1 + j, r);
  }
  return around;
}

void fit_motion(const RowsAround& moments, const MotionFits& out) { HWY_DYNAMIC_DISPATCH(fit_motion_of)(moments, out); }
void fit_shifts(const RowsAround& moments, const ShiftFits& out) { HWY_DYNAMIC_DISPATCH(fit_shifts_of)(moments, out); }
void filter_motion(const RowsAround& maps, const RowToRead& moments, const RowToWrite& flow) {
  HWY_DYNAMIC_DISPATCH(filter_motion_of)(maps, moments, flow);
}
void fit_flow(const RowsAround& flow, const FlowFits& out) { HWY_DYNAMIC_DISPATCH(fit_flow_of)(flow, out); }
void damp_noise(const RowsAround& noise, const RowsAround& maps, FourCells* damping) {
  HWY_DYNAMIC_DISPATCH(damp_noise_of)(noise, maps, damping);
}
void add_maps(const RowsAround& maps, FourCells* sum) { HWY_DYNAMIC_DISPATCH(add_maps_of)(maps, sum); }
void average_maps(const RowsAround& maps, const Real* factor, FourCells* mean) {
  HWY_DYNAMIC_DISPATCH(average_maps_of)(maps, factor, mean);
}

}  // namespace trevi
#endif

// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/cell_shifts.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/cell_shifts.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include "projection/cell_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Of particles [i, end) as many as a vector has lanes, others 0; whole vectors are read where there is something.
template <class T>
HWY_INLINE V load_scalars(std::span<const T> of, std::size_t i, std::size_t end) {
  const hn::Rebind<T, Wide> d;
  std::array<T, max_lanes> last{};
  const bool whole = i + hn::Lanes(d) <= of.size();
  if (!whole && i < of.size()) std::copy(of.begin() + static_cast<std::ptrdiff_t>(i), of.end(), last.begin());
  const auto loaded = hn::LoadU(d, whole ? &of[i] : last.data());
  const V all = [&] {
    if constexpr (sizeof(T) == sizeof(double)) {
      return loaded;
    } else {
      return hn::PromoteTo(Wide(), loaded);
    }
  }();
  return hn::IfThenElseZero(hn::FirstN(Wide(), std::min(end > i ? end - i : 0, hn::Lanes(Wide()))), all);
}

// From 1 where the density is that of water at rest down to 0 where it is that of a particle that is squeezed.
HWY_INLINE V unsqueezed(const Densities& densities, std::size_t i, std::size_t end) {
  constexpr Real range = projection::squeezed_full - projection::squeezed_begins;
  const V rho = load_scalars(densities.rho, i, end);
  const V above = hn::Sub(hn::Div(rho, set(densities.rest)), set(1 + projection::squeezed_begins));
  return hn::Sub(set(1), clamp(hn::Div(above, set(range)), 0, 1));
}

template <class T>
HWY_INLINE void remove_smooth_of(const CellFrame& frame, const Swept<T>& swept, const CellParticles& cell,
                                 const AffineMap& smooth, Vec4<T>* out) {
  const std::size_t lanes = hn::Lanes(Wide());
  for (std::size_t i = cell.begin; i < cell.end; i += lanes, out += lanes) {
    const V3 y = load(frame, swept.shifts, cell, i).y;
    const V kept = hn::Mul(load_scalars(swept.act, i, cell.end), unsqueezed(swept.densities, i, cell.end));
    const V less = hn::Neg(kept);
    V3 u = zeros();
    for (std::size_t a = 0; a < 3; ++a) {
      u[a] = set(smooth.a[a]);
      for (std::size_t b = 0; b < 3; ++b) u[a] = hn::MulAdd(set(smooth.b[a][b]), y[b], u[a]);
      u[a] = hn::Mul(less, u[a]);
    }
    store_vectors<T>({u, hn::Zero(Wide())}, cell.end - i, out);
  }
}

// Shifts Δ.
HWY_INLINE V3 load_path(const Motion& shifts, std::size_t i) {
  const V3 p = load(shifts.p, i), x = load(shifts.x, i);
  return {hn::Sub(p[0], x[0]), hn::Sub(p[1], x[1]), hn::Sub(p[2], x[2])};
}

// Σ act Δ and Σ act.
template <class T>
HWY_INLINE std::array<Real, 4> sum_shifts(const Motion& shifts, const CellParticles& cell, std::span<const T> act) {
  alignas(64) Real lanes[4][virtual_lanes];
  const auto add_eight = [&]<bool first>(std::size_t i) {
    for (std::size_t lane = 0; lane < virtual_lanes; lane += hn::Lanes(Wide())) {
      const V3 path = load_path(shifts, i + lane);
      const V weight = load_scalars(act, i + lane, cell.end);
      for (std::size_t a = 0; a < 3; ++a) add_to_lanes<first>(&lanes[a][lane], hn::Mul(weight, path[a]));
      add_to_lanes<first>(&lanes[3][lane], weight);
    }
  };
  add_eight.template operator()<true>(cell.begin);
  for (std::size_t i = cell.begin + virtual_lanes; i < cell.end; i += virtual_lanes)
    add_eight.template operator()<false>(i);
  std::array<Real, 4> sums;
  fold_all<4>(lanes, sums.data());
  return sums;
}

template <class T>
HWY_INLINE void carry_cell_of(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                              std::span<const T> act, std::span<Vec3> velocity) {
  const Wide d;
  const std::array<Real, 4> sums = sum_shifts(shifts, cell, act);
  if (sums[3] == 0) return;
  for (std::size_t i = cell.begin; i < cell.end; i += hn::Lanes(d)) {
    V3 off = load_path(shifts, i), v = load(std::span<const Vec3>(velocity), i);
    const V weight = load_scalars(act, i, cell.end);
    for (std::size_t a = 0; a < 3; ++a) off[a] = hn::Sub(off[a], set(sums[a] / sums[3]));
    for (std::size_t a = 0; a < 3; ++a) {
      V carried = hn::Mul(set(slope[a][0]), off[0]);
      for (std::size_t b = 1; b < 3; ++b) carried = hn::MulAdd(set(slope[a][b]), off[b], carried);
      v[a] = hn::MulAdd(weight, carried, v[a]);
    }
    if (i + hn::Lanes(d) <= cell.end) {
      hn::StoreInterleaved3(v[0], v[1], v[2], d, velocity[i].data());
    } else {
      std::array<Vec3, max_lanes> last;
      hn::StoreInterleaved3(v[0], v[1], v[2], d, last[0].data());
      std::copy_n(last.begin(), cell.end - i, &velocity[i]);
    }
  }
}

// Highway's dispatch takes no templates.
void remove_smooth_single(const CellFrame& frame, const Swept<float>& swept, const CellParticles& cell,
                          const AffineMap& smooth, Vec4<float>* out) {
  remove_smooth_of(frame, swept, cell, smooth, out);
}
void remove_smooth_double(const CellFrame& frame, const Swept<double>& swept, const CellParticles& cell,
                          const AffineMap& smooth, Vec4<double>* out) {
  remove_smooth_of(frame, swept, cell, smooth, out);
}
void carry_single(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                  std::span<const float> act, std::span<Vec3> velocity) {
  carry_cell_of(shifts, cell, slope, act, velocity);
}
void carry_double(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                  std::span<const double> act, std::span<Vec3> velocity) {
  carry_cell_of(shifts, cell, slope, act, velocity);
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(remove_smooth_single);
HWY_EXPORT(remove_smooth_double);
HWY_EXPORT(carry_single);
HWY_EXPORT(carry_double);

template <>
void remove_smooth(const CellFrame& frame, const Swept<float>& swept, const CellParticles& cell,
                   const AffineMap& smooth, Vec4<float>* out) {
  HWY_DYNAMIC_DISPATCH(remove_smooth_single)(frame, swept, cell, smooth, out);
}
template <>
void remove_smooth(const CellFrame& frame, const Swept<double>& swept, const CellParticles& cell,
                   const AffineMap& smooth, Vec4<double>* out) {
  HWY_DYNAMIC_DISPATCH(remove_smooth_double)(frame, swept, cell, smooth, out);
}
template <>
void carry_cell(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                std::span<const float> act, std::span<Vec3> velocity) {
  HWY_DYNAMIC_DISPATCH(carry_single)(shifts, cell, slope, act, velocity);
}
template <>
void carry_cell(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                std::span<const double> act, std::span<Vec3> velocity) {
  HWY_DYNAMIC_DISPATCH(carry_double)(shifts, cell, slope, act, velocity);
}

}  // namespace trevi
#endif

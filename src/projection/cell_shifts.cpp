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
HWY_INLINE V load_act(std::span<const T> act, std::size_t i, std::size_t end) {
  const hn::Rebind<T, Wide> d;
  std::array<T, max_lanes> last{};
  const bool whole = i + hn::Lanes(d) <= act.size();
  if (!whole && i < act.size()) std::copy(act.begin() + static_cast<std::ptrdiff_t>(i), act.end(), last.begin());
  const auto loaded = hn::LoadU(d, whole ? &act[i] : last.data());
  const V all = [&] {
    if constexpr (sizeof(T) == sizeof(double)) {
      return loaded;
    } else {
      return hn::PromoteTo(Wide(), loaded);
    }
  }();
  return hn::IfThenElseZero(hn::FirstN(Wide(), std::min(end > i ? end - i : 0, hn::Lanes(Wide()))), all);
}

template <class T>
HWY_INLINE void remove_smooth_of(const CellFrame& frame, const Motion& shifts, const CellParticles& cell,
                                 const AffineMap& smooth, std::span<const T> act, Vec4<T>* out) {
  const std::size_t lanes = hn::Lanes(Wide());
  for (std::size_t i = cell.begin; i < cell.end; i += lanes, out += lanes) {
    const V3 y = load(frame, shifts, cell, i).y;
    const V less = hn::Neg(load_act(act, i, cell.end));
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
      const V weight = load_act(act, i + lane, cell.end);
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
    const V weight = load_act(act, i, cell.end);
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
void remove_smooth_single(const CellFrame& frame, const Motion& shifts, const CellParticles& cell,
                          const AffineMap& smooth, std::span<const float> act, Vec4<float>* out) {
  remove_smooth_of(frame, shifts, cell, smooth, act, out);
}
void remove_smooth_double(const CellFrame& frame, const Motion& shifts, const CellParticles& cell,
                          const AffineMap& smooth, std::span<const double> act, Vec4<double>* out) {
  remove_smooth_of(frame, shifts, cell, smooth, act, out);
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
void remove_smooth(const CellFrame& frame, const Motion& shifts, const CellParticles& cell, const AffineMap& smooth,
                   std::span<const float> act, Vec4<float>* out) {
  HWY_DYNAMIC_DISPATCH(remove_smooth_single)(frame, shifts, cell, smooth, act, out);
}
template <>
void remove_smooth(const CellFrame& frame, const Motion& shifts, const CellParticles& cell, const AffineMap& smooth,
                   std::span<const double> act, Vec4<double>* out) {
  HWY_DYNAMIC_DISPATCH(remove_smooth_double)(frame, shifts, cell, smooth, act, out);
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

// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/cell_shifts.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/cell_shifts.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include "projection/cell_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Values of as many of the particles [i, end) as a vector has lanes, 0 in other lanes; whole vectors are read where
// possible.
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

// From 1 at the density of water at rest down to 0 at that of a squeezed particle.
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

// Sums over the particles of a cell: of(i) returns the terms of the particles from i on, and 0 beyond the last one.
template <std::size_t count, class Of>
HWY_INLINE std::array<Real, count> sum_cell(const CellParticles& cell, const Of& of) {
  alignas(64) Real lanes[count][virtual_lanes];
  const auto add_vector = [&]<bool first>(std::size_t i) {
    for (std::size_t lane = 0; lane < virtual_lanes; lane += hn::Lanes(Wide())) {
      const std::array<V, count> terms = of(i + lane);
      for (std::size_t q = 0; q < count; ++q) add_to_lanes<first>(&lanes[q][lane], terms[q]);
    }
  };
  add_vector.template operator()<true>(cell.begin);
  for (std::size_t i = cell.begin + virtual_lanes; i < cell.end; i += virtual_lanes)
    add_vector.template operator()<false>(i);
  std::array<Real, count> sums;
  fold_all<count>(lanes, sums.data());
  return sums;
}

// B y
HWY_INLINE V3 along(const std::array<ByAxis, 3>& slope, const V3& y) {
  V3 u = zeros();
  for (std::size_t a = 0; a < 3; ++a) {
    u[a] = hn::Mul(set(slope[a][0]), y[0]);
    for (std::size_t b = 1; b < 3; ++b) u[a] = hn::MulAdd(set(slope[a][b]), y[b], u[a]);
  }
  return u;
}

HWY_INLINE V3 less(const V3& u, const Real* mean) {
  return {hn::Sub(u[0], set(mean[0])), hn::Sub(u[1], set(mean[1])), hn::Sub(u[2], set(mean[2]))};
}

HWY_INLINE V dot(const V3& u, const V3& w) {
  return hn::MulAdd(u[0], w[0], hn::MulAdd(u[1], w[1], hn::Mul(u[2], w[2])));
}

// The particles of a cell that take on the velocities of their new positions.
template <class T>
struct Carry {
  const Motion& shifts;
  const CellParticles& cell;
  const std::array<ByAxis, 3>& slope;
  std::span<const T> act;
  std::span<const Vec3> velocity;
  std::array<Real, 9> mean;  // of shifts, positions and velocities

  V weight(std::size_t i) const { return load_scalars(act, i, cell.end); }
  V3 carried(std::size_t i) const { return along(slope, less(load_path(shifts, i), &mean[0])); }
  // Relative to the first particle: exact along periodic axes, wherever the box begins.
  V3 place(std::size_t i) const { return less(load(shifts.x, i), shifts.x[cell.begin].data()); }
  V3 affine(std::size_t i) const { return along(slope, less(place(i), &mean[3])); }
  V3 noise(std::size_t i, const V3& affine) const {
    const V3 v = less(load(velocity, i), &mean[6]);
    return {hn::Sub(v[0], affine[0]), hn::Sub(v[1], affine[1]), hn::Sub(v[2], affine[2])};
  }
  // Returns whether there is any weight.
  bool find_means() {
    const auto sums = sum_cell<10>(cell, [&](std::size_t i) {
      const V w = weight(i);
      const V3 path = load_path(shifts, i), x = place(i), v = load(velocity, i);
      std::array<V, 10> terms;
      for (std::size_t a = 0; a < 3; ++a) {
        terms[a] = hn::Mul(w, path[a]);
        terms[3 + a] = hn::Mul(w, x[a]);
        terms[6 + a] = hn::Mul(w, v[a]);
      }
      terms[9] = w;
      return terms;
    });
    if (sums[9] == 0) return false;
    for (std::size_t q = 0; q < 9; ++q) mean[q] = sums[q] / sums[9];
    return true;
  }
  // The gain of the noise, as a fraction of noise and affine motion; and that part of the gain of the affine motion
  // that is withheld, as a fraction of the affine motion.
  struct Gains {
    Real noise, smooth;
  };
  Gains gains() const {
    const auto sums = sum_cell<4>(cell, [&](std::size_t i) {
      const V w = weight(i);
      const V3 smooth = affine(i), rest = noise(i, smooth), c = carried(i);
      return std::array<V, 4>{hn::Mul(w, dot(rest, c)), hn::Mul(w, hn::Add(dot(rest, rest), dot(smooth, smooth))),
                              hn::Mul(w, dot(smooth, c)), hn::Mul(w, dot(smooth, smooth))};
    });
    return {sums[1] > 0 ? sums[0] / sums[1] : 0, sums[3] > 0 ? projection::withheld * sums[2] / sums[3] : 0};
  }
};

template <class T>
HWY_INLINE void carry_cell_of(const Motion& shifts, const CellParticles& cell, const std::array<ByAxis, 3>& slope,
                              std::span<const T> act, std::span<Vec3> velocity) {
  const Wide d;
  Carry<T> carry{shifts, cell, slope, act, velocity, {}};
  if (!carry.find_means()) return;
  const auto [of_noise, of_smooth] = carry.gains();
  const V less_noise = set(of_noise), less_smooth = set(of_smooth);
  for (std::size_t i = cell.begin; i < cell.end; i += hn::Lanes(d)) {
    const V3 carried = carry.carried(i), smooth = carry.affine(i), noise = carry.noise(i, smooth);
    const V weight = carry.weight(i);
    V3 v = load(std::span<const Vec3>(velocity), i);
    for (std::size_t a = 0; a < 3; ++a) {
      const V taken = hn::NegMulAdd(less_smooth, smooth[a], hn::NegMulAdd(less_noise, noise[a], carried[a]));
      v[a] = hn::MulAdd(weight, taken, v[a]);
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

// Highway's dispatch does not support templates.
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

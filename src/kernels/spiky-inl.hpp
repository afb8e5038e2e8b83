// Spiky (Müller et al. 2003, eq. 21), whose slope is largest where particles are nearest:
//   W(r)     = 15/(π h⁶) (h − r)³ = 15/(π h³) (1 − u)³,  u = r/h        [1/m³]
//   −dW/dr   = 45/(π h⁴) (1 − u)²                                       [1/m⁴]
// The scalar type is compiled once, the shape for the pair loops once per instruction set.
#ifndef TREVI_FLUID_KERNELS_SPIKY
#define TREVI_FLUID_KERNELS_SPIKY

#include <numbers>
#include <string_view>

#include "trevi/types.hpp"

namespace trevi {

struct Spiky {
  static constexpr std::string_view name = "spiky";
  using Gradient = Spiky;

  /// Of W in the plane, 10/(π h²) (1 − u)³, over h times the one in space.
  static constexpr Real in_plane = 2.0 / 3;

  static constexpr Real factor(Real h) { return 15 / (std::numbers::pi * h * h * h); }
  static constexpr Real slope_factor(Real h) { return 45 / (std::numbers::pi * h * h * h * h); }
  /// The slope is largest in the limit u = 0.
  static constexpr Real steepest(Real h) { return slope_factor(h); }

  static Real value(const Vec3& r, Real h) {
    const Real t = 1 - r.norm() / h;
    return t > 0 ? factor(h) * t * t * t : 0;
  }
  /// Zero at r = 0, where it has no direction.
  static Vec3 gradient(const Vec3& r, Real h) {
    const Real length = r.norm();
    if (length <= 0 || length >= h) return Vec3::Zero();
    const Real t = 1 - length / h;
    return -slope_factor(h) * t * t / length * r;
  }
};

}  // namespace trevi

#endif

#if defined(TREVI_FLUID_KERNELS_SPIKY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_KERNELS_SPIKY_INL
#undef TREVI_FLUID_KERNELS_SPIKY_INL
#else
#define TREVI_FLUID_KERNELS_SPIKY_INL
#endif

#include "kernels/shape-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <>
struct Shape<Spiky> {
  template <class D>
  static HWY_INLINE Product<D> value(D d, const Distance<D>& distance) {
    const auto t = rest_to_one(d, distance.u);
    return {hn::Mul(t, t), t};
  }
  // At u = 0 the factor is finite; it multiplies a zero vector.
  template <class D>
  static HWY_INLINE Slope<D> slope(D d, const Distance<D>& distance) {
    const auto t = rest_to_one(d, distance.u), t2 = hn::Mul(t, t);
    return {t2, hn::Div(t2, hn::Max(distance.u, hn::Set(d, static_cast<hn::TFromD<D>>(1e-18))))};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

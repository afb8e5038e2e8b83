// Wendland's C2 function in two and three dimensions (Wendland 1995; Dehnen & Aly 2012), with support h, not 2h:
//   W(r)     = 21/(2 π h³) (1 − u)⁴ (1 + 4u),  u = r/h        [1/m³]
//   −dW/dr   = 210/(π h⁴) u (1 − u)³                          [1/m⁴]
// Its Fourier transform is positive, so that particles do not pair, however large h is; its slope vanishes at the
// centre. The scalar type is compiled once, the shape for the pair loops once per instruction set.
#ifndef TREVI_FLUID_KERNELS_WENDLAND_C2
#define TREVI_FLUID_KERNELS_WENDLAND_C2

#include <numbers>
#include <string_view>

#include "trevi/types.hpp"

namespace trevi {

struct WendlandC2 {
  static constexpr std::string_view name = "wendland_c2";
  using Gradient = WendlandC2;

  /// Of W in the plane, 7/(π h²) (1 − u)⁴ (1 + 4u), over h times the one in space.
  static constexpr Real in_plane = 2.0 / 3;

  static constexpr Real factor(Real h) { return 21 / (2 * std::numbers::pi * h * h * h); }
  static constexpr Real slope_factor(Real h) { return 210 / (std::numbers::pi * h * h * h * h); }
  /// The slope is largest at u = 1/4.
  static constexpr Real steepest(Real h) { return slope_factor(h) * 27 / 256; }

  static Real value(const Vec3& r, Real h) {
    const Real u = r.norm() / h, t = 1 - u;
    return t > 0 ? factor(h) * t * t * t * t * (1 + 4 * u) : 0;
  }
  static Vec3 gradient(const Vec3& r, Real h) {
    const Real t = 1 - r.norm() / h;
    return t > 0 ? Vec3(-slope_factor(h) / h * t * t * t * r) : Vec3::Zero();
  }
};

}  // namespace trevi

#endif

#if defined(TREVI_FLUID_KERNELS_WENDLAND_C2_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_KERNELS_WENDLAND_C2_INL
#undef TREVI_FLUID_KERNELS_WENDLAND_C2_INL
#else
#define TREVI_FLUID_KERNELS_WENDLAND_C2_INL
#endif

#include "kernels/shape-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <>
struct Shape<WendlandC2> {
  template <class D>
  static HWY_INLINE Product<D> value(D d, const Distance<D>& distance) {
    using T = hn::TFromD<D>;
    const auto t = rest_to_one(d, distance.u), t2 = hn::Mul(t, t);
    return {hn::Mul(t2, t2), hn::MulAdd(hn::Set(d, T{4}), distance.u, hn::Set(d, T{1}))};
  }
  template <class D>
  static HWY_INLINE Slope<D> slope(D d, const Distance<D>& distance) {
    const auto t = rest_to_one(d, distance.u), t3 = hn::Mul(hn::Mul(t, t), t);
    return {hn::Mul(distance.u, t3), t3};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

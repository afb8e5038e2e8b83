// Poly6 (Müller et al. 2003, eq. 20), smooth and without a square root:
//   W(r)     = 315/(64 π h⁹) (h² − r²)³ = 315/(64 π h³) (1 − u²)³,  u = r/h        [1/m³]
//   −dW/dr   = 945/(32 π h⁴) u (1 − u²)²                                           [1/m⁴]
// Its gradient vanishes at the centre, where first_overfull_particle particles must be pushed apart, so the default
// gradient kernel for densities of Poly6 is Spiky. The scalar type is compiled once, the shape for the pair loops once
// per instruction set.
#ifndef TREVI_FLUID_KERNELS_POLY6
#define TREVI_FLUID_KERNELS_POLY6

#include <numbers>
#include <string_view>

#include "trevi/types.hpp"

namespace trevi {

struct Spiky;

struct Poly6 {
  static constexpr std::string_view name = "poly6";
  using Gradient = Spiky;

  /// Of W in the plane, 4/(π h²) (1 − u²)³, over h times the one in space.
  static constexpr Real in_plane = 256.0 / 315;

  static constexpr Real factor(Real h) { return 315 / (64 * std::numbers::pi * h * h * h); }
  static constexpr Real slope_factor(Real h) { return 6 * factor(h) / h; }
  /// The maximum is at u² = 1/5, where u (1 − u²)² = 16/(25 √5).
  static constexpr Real steepest(Real h) { return 0.28621670111997307 * slope_factor(h); }

  static Real value(const Vec3& r, Real h) {
    const Real t = 1 - r.squaredNorm() / (h * h);
    return t > 0 ? factor(h) * t * t * t : 0;
  }
  static Vec3 gradient(const Vec3& r, Real h) {
    const Real t = 1 - r.squaredNorm() / (h * h);
    return t > 0 ? Vec3(-6 * factor(h) / (h * h) * t * t * r) : Vec3::Zero();
  }
};

}  // namespace trevi

#endif

#if defined(TREVI_FLUID_KERNELS_POLY6_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_KERNELS_POLY6_INL
#undef TREVI_FLUID_KERNELS_POLY6_INL
#else
#define TREVI_FLUID_KERNELS_POLY6_INL
#endif

#include "kernels/shape-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <>
struct Shape<Poly6> {
  // 1 − u²; the artificial pressure also uses powers of it.
  template <class D>
  static HWY_INLINE hn::Vec<D> base(D d, const Distance<D>& distance) {
    return rest_to_one(d, distance.u2);
  }
  template <class D>
  static HWY_INLINE Product<D> value(D d, const Distance<D>& distance) {
    const auto q = base(d, distance);
    return {hn::Mul(q, q), q};
  }
  template <class D>
  static HWY_INLINE Slope<D> slope(D d, const Distance<D>& distance) {
    const auto q = base(d, distance), q2 = hn::Mul(q, q);
    return {hn::Mul(distance.u, q2), q2};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

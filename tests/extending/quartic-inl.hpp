// A smoothing kernel: W(r) = 105/(32 π h³) (1 − u²)², u = r/h. The scalar type is compiled once, the shape for the pair
// loops once per instruction set.
#ifndef TREVI_KERNELS_QUARTIC
#define TREVI_KERNELS_QUARTIC

#include <numbers>
#include <string_view>

#include "trevi/types.hpp"

namespace trevi {

struct Quartic {
  static constexpr std::string_view name = "quartic";
  using Gradient = Quartic;

  /// Of W in the plane, 3/(π h²) (1 − u²)², over h times the one in space.
  static constexpr Real in_plane = 32.0 / 35;
  static constexpr Real factor(Real h) { return 105 / (32 * std::numbers::pi * h * h * h); }
  static constexpr Real slope_factor(Real h) { return 4 * factor(h) / h; }
  /// The slope is largest at u² = 1/3.
  static constexpr Real steepest(Real h) { return slope_factor(h) * 2 / (3 * std::numbers::sqrt3); }

  static Real value(const Vec3& r, Real h) {
    const Real t = 1 - r.squaredNorm() / (h * h);
    return t > 0 ? factor(h) * t * t : 0;
  }
  static Vec3 gradient(const Vec3& r, Real h) {
    const Real t = 1 - r.squaredNorm() / (h * h);
    return t > 0 ? Vec3(-slope_factor(h) / h * t * r) : Vec3::Zero();
  }
};

}  // namespace trevi

#endif

#if defined(TREVI_KERNELS_QUARTIC_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_KERNELS_QUARTIC_INL
#undef TREVI_KERNELS_QUARTIC_INL
#else
#define TREVI_KERNELS_QUARTIC_INL
#endif

#include "kernels/shape-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <>
struct Shape<Quartic> {
  template <class D>
  static HWY_INLINE Product<D> value(D d, const Distance<D>& distance) {
    const auto t = rest_to_one(d, distance.u2);
    return {t, t};
  }
  template <class D>
  static HWY_INLINE Slope<D> slope(D d, const Distance<D>& distance) {
    const auto t = rest_to_one(d, distance.u2);
    return {hn::Mul(distance.u, t), t};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

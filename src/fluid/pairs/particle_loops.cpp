// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "fluid/pairs/particle_loops.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fluid/pairs/particle_loops.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include <bit>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Vectors of doubles, and what has as many lanes.
using Wide = hn::ScalableTag<double>;
template <class T>
using As = hn::Rebind<T, Wide>;

template <class T>
HWY_INLINE auto widened(hn::Vec<As<T>> v) {
  if constexpr (sizeof(T) == sizeof(double)) {
    return v;
  } else {
    return hn::PromoteTo(Wide(), v);
  }
}

struct WideVec3 {  // always made with its values: the default constructor would not be of this instruction set
  hn::Vec<Wide> x, y, z;
};

HWY_INLINE WideVec3 load(const Vec3* p) {
  hn::Vec<Wide> x, y, z;
  hn::LoadInterleaved3(Wide(), p->data(), x, y, z);
  return {x, y, z};
}

HWY_INLINE auto is_outside(const Box& box, const WideVec3& p) {
  const Wide d;
  const auto beyond = [d](hn::Vec<Wide> v, Real low, Real high) {
    return hn::Or(hn::Lt(v, hn::Set(d, low)), hn::Gt(v, hn::Set(d, high)));
  };
  return hn::Or(hn::Or(beyond(p.x, box.min.x(), box.max.x()), beyond(p.y, box.min.y(), box.max.y())),
                beyond(p.z, box.min.z(), box.max.z()));
}

// Whether a NaN is among them: it is not inside of any box, nor outside.
HWY_INLINE bool all_inside(const Box& box, const WideVec3& p) {
  const Wide d;
  const auto within = [d](hn::Vec<Wide> v, Real low, Real high) {
    return hn::And(hn::Ge(v, hn::Set(d, low)), hn::Le(v, hn::Set(d, high)));
  };
  return hn::AllTrue(d, hn::And(hn::And(within(p.x, box.min.x(), box.max.x()), within(p.y, box.min.y(), box.max.y())),
                                within(p.z, box.min.z(), box.max.z())));
}

// The multipliers of as many particles as a vector has lanes, at k.
template <class T>
HWY_INLINE void multipliers(const MultiplierLaw& law, const DensitySums<T>& in, std::size_t k, Real* rho, T* lambda) {
  const Wide wide;
  const As<T> d;
  hn::Vec<As<T>> x, y, z, w;
  hn::LoadInterleaved4(d, &in.sums[k].x, x, y, z, w);
  const auto alone = static_cast<T>(law.alone), rest = static_cast<T>(law.alone - 1);
  const auto c = hn::MulAdd(w, hn::Set(d, alone), hn::Set(d, rest));
  const auto g2 = hn::Add(hn::MulAdd(z, z, hn::MulAdd(y, y, hn::Mul(x, x))), hn::LoadU(d, in.squares + k));
  // A particle without neighbours has no gradient; with epsilon = 0 that would be 0/0.
  const auto stiffness =
      hn::Max(hn::MulAdd(g2, hn::Set(d, static_cast<T>(law.slope2)), hn::Set(d, static_cast<T>(law.epsilon))),
              hn::Set(d, static_cast<T>(1e-30)));
  const auto least = hn::Set(d, static_cast<T>(law.least));
  hn::StoreU(hn::IfThenElseZero(hn::Gt(c, least), hn::Div(hn::Neg(c), stiffness)), d, lambda + k);
  const auto density = hn::Set(wide, law.rest_density * law.alone);
  hn::StoreU(hn::MulAdd(widened<T>(w), density, density), wide, rho + k);
}

template <class T>
void find_multipliers_of(const MultiplierLaw& law, const DensitySums<T>& in, Real* rho, T* lambda) {
  const std::size_t lanes = hn::Lanes(Wide()), count = in.sums.size();
  std::size_t k = 0;
  for (; k + lanes <= count; k += lanes) multipliers<T>(law, in, k, rho, lambda);
  if (k == count) return;
  constexpr std::size_t most = hn::MaxLanes(Wide());
  std::array<Vec4<T>, most> sums{};
  std::array<T, most> squares{}, last_lambda{};
  std::array<Real, most> last_rho{};
  std::copy_n(in.sums.begin() + static_cast<std::ptrdiff_t>(k), count - k, sums.begin());
  std::copy_n(in.squares + k, count - k, squares.begin());
  multipliers<T>(law, {sums, squares.data()}, 0, last_rho.data(), last_lambda.data());
  std::copy_n(last_rho.begin(), count - k, rho + k);
  std::copy_n(last_lambda.begin(), count - k, lambda + k);
}

std::size_t find_outside_of(const Box& box, std::span<const Vec3> p, LocalId* found) {
  const Wide d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t count = 0, k = 0;
  for (; k + lanes <= p.size(); k += lanes) {
    std::array<std::uint8_t, 8> bytes{};
    hn::StoreMaskBits(d, is_outside(box, load(&p[k])), bytes.data());
    for (unsigned bits = bytes[0]; bits != 0; bits &= bits - 1)
      found[count++] = static_cast<LocalId>(k) + std::countr_zero(bits);
  }
  for (; k < p.size(); ++k) {
    if ((p[k].array() < box.min.array()).any() || (p[k].array() > box.max.array()).any())
      found[count++] = static_cast<LocalId>(k);
  }
  return count;
}

// In integers as Encoding has it: the sum with 1.5 · 2^52 has the rounded number modulo 2^32 in its lower half.
HWY_INLINE auto rounded(hn::Vec<Wide> u) {
  constexpr double shift = 6755399441055744.0;
  const auto bits = hn::BitCast(As<std::uint64_t>(), hn::Add(u, hn::Set(Wide(), shift)));
  return hn::BitCast(As<std::int32_t>(), hn::TruncateTo(As<std::uint32_t>(), bits));
}

template <class T>
HWY_INLINE void store_records(const Encoding<T>& encoding, const WideVec3& p, Packed<T>* records) {
  const Wide d;
  const auto per_metre = hn::Set(d, encoding.per_metre());
  const auto in_units = [&](hn::Vec<Wide> v, Real origin) {
    return hn::Mul(hn::Sub(v, hn::Set(d, origin)), per_metre);
  };
  const Vec3& origin = encoding.origin();
  const auto x = in_units(p.x, origin.x()), y = in_units(p.y, origin.y()), z = in_units(p.z, origin.z());
  if constexpr (sizeof(T) == sizeof(double)) {
    hn::StoreInterleaved4(x, y, z, hn::Zero(d), d, &records->x);
  } else {
    const As<std::int32_t> di;
    hn::StoreInterleaved4(rounded(x), rounded(y), rounded(z), hn::Zero(di), di, &records->x);
  }
}

// For most vectors all paths are inside of the box.
template <class T>
HWY_INLINE bool moved_inside(const Shift<T>& shift, const Vec4<T>* delta, Vec3* p, Packed<T>* records) {
  const Wide d;
  const auto factor = hn::Set(d, shift.factor);
  hn::Vec<As<T>> x, y, z, w;
  hn::LoadInterleaved4(As<T>(), &delta->x, x, y, z, w);
  const WideVec3 from = load(p);
  const WideVec3 to = {hn::Add(from.x, hn::Mul(factor, widened<T>(x))), hn::Add(from.y, hn::Mul(factor, widened<T>(y))),
                       hn::Add(from.z, hn::Mul(factor, widened<T>(z)))};
  if (!all_inside(shift.open, to) || (!shift.from_inside && !all_inside(shift.open, from))) return false;
  hn::StoreInterleaved3(to.x, to.y, to.z, d, p->data());
  store_records(shift.encoding, to, records);
  return true;
}

template <class T>
std::size_t move_particles_of(const Shift<T>& shift, const Vec4<T>* delta, const Moved<T>& moved, LocalId* left) {
  const std::size_t lanes = hn::Lanes(Wide()), count = moved.p.size();
  std::size_t stay = 0;
  for (std::size_t k = 0; k < count; k += lanes) {
    if (k + lanes <= count && moved_inside(shift, delta + k, &moved.p[k], moved.records + k)) continue;
    for (std::size_t i = k; i < std::min(k + lanes, count); ++i) left[stay++] = static_cast<LocalId>(i);
  }
  return stay;
}

// Highway's dispatch takes no templates.
void multipliers_single(const MultiplierLaw& law, const DensitySums<float>& in, Real* rho, float* lambda) {
  find_multipliers_of(law, in, rho, lambda);
}
void multipliers_double(const MultiplierLaw& law, const DensitySums<double>& in, Real* rho, double* lambda) {
  find_multipliers_of(law, in, rho, lambda);
}
std::size_t move_single(const Shift<float>& shift, const Vec4<float>* delta, const Moved<float>& moved, LocalId* left) {
  return move_particles_of(shift, delta, moved, left);
}
std::size_t move_double(const Shift<double>& shift, const Vec4<double>* delta, const Moved<double>& moved,
                        LocalId* left) {
  return move_particles_of(shift, delta, moved, left);
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(multipliers_single);
HWY_EXPORT(multipliers_double);
HWY_EXPORT(find_outside_of);
HWY_EXPORT(move_single);
HWY_EXPORT(move_double);

template <>
void find_multipliers(const MultiplierLaw& law, const DensitySums<float>& in, Real* rho, float* lambda) {
  HWY_DYNAMIC_DISPATCH(multipliers_single)(law, in, rho, lambda);
}
template <>
void find_multipliers(const MultiplierLaw& law, const DensitySums<double>& in, Real* rho, double* lambda) {
  HWY_DYNAMIC_DISPATCH(multipliers_double)(law, in, rho, lambda);
}

std::size_t find_outside(const Box& box, std::span<const Vec3> p, LocalId* found) {
  return HWY_DYNAMIC_DISPATCH(find_outside_of)(box, p, found);
}

template <>
std::size_t move_particles(const Shift<float>& shift, const Vec4<float>* delta, const Moved<float>& moved,
                           LocalId* left) {
  return HWY_DYNAMIC_DISPATCH(move_single)(shift, delta, moved, left);
}
template <>
std::size_t move_particles(const Shift<double>& shift, const Vec4<double>* delta, const Moved<double>& moved,
                           LocalId* left) {
  return HWY_DYNAMIC_DISPATCH(move_double)(shift, delta, moved, left);
}

}  // namespace trevi
#endif

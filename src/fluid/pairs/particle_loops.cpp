// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "fluid/pairs/particle_loops.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fluid/pairs/particle_loops.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include <cstdint>

#include "boundary/obstacles/open_space-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// A tag with as many lanes as vectors of doubles have.
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

// The multipliers of as many particles as a vector has lanes, from k on.
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

// Rounded to integers as in Encoding: the sum with 1.5 · 2^52 contains the rounded number modulo 2^32 in its lower
// half.
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

// For most vectors all paths lie in open space.
template <bool any_closed, class T>
HWY_INLINE bool moved_inside(const Shift<T>& shift, const Vec4<T>* delta, Vec3* p, Packed<T>* records) {
  const Wide d;
  const auto factor = hn::Set(d, shift.factor);
  hn::Vec<As<T>> x, y, z, w;
  hn::LoadInterleaved4(As<T>(), &delta->x, x, y, z, w);
  const WideVec3 from = load(p);
  const WideVec3 to = {hn::Add(from.x, hn::Mul(factor, widened<T>(x))), hn::Add(from.y, hn::Mul(factor, widened<T>(y))),
                       hn::Add(from.z, hn::Mul(factor, widened<T>(z)))};
  const Box& box = shift.open.box();
  if (shift.from_inside) {
    if (!hn::AllTrue(d, is_inside(box, to))) return false;
  } else if (!hn::AllTrue(d, are_inside(box, from, to))) {
    return false;
  }
  if (any_closed && !hn::AllFalse(d, is_closed(shift.open, from, to))) return false;
  hn::StoreInterleaved3(to.x, to.y, to.z, d, p->data());
  store_records(shift.encoding, to, records);
  return true;
}

template <bool any_closed, class T>
HWY_INLINE std::size_t move_most(const Shift<T>& shift, const Vec4<T>* delta, const Moved<T>& moved, LocalId* left) {
  const std::size_t lanes = hn::Lanes(Wide()), count = moved.p.size();
  std::size_t stay = 0;
  for (std::size_t k = 0; k < count; k += lanes) {
    if (k + lanes <= count && moved_inside<any_closed>(shift, delta + k, &moved.p[k], moved.records + k)) continue;
    for (std::size_t i = k; i < std::min(k + lanes, count); ++i) left[stay++] = static_cast<LocalId>(i);
  }
  return stay;
}

template <class T>
std::size_t move_particles_of(const Shift<T>& shift, const Vec4<T>* delta, const Moved<T>& moved, LocalId* left) {
  return shift.open.closed_parts() > 0 ? move_most<true>(shift, delta, moved, left)
                                       : move_most<false>(shift, delta, moved, left);
}

// Compares each position with those that come 1, 2, ... after it. Twice the square is used, because the test itself may
// round differently.
bool may_coincide_of(std::span<const Vec3> p, Real squared) {
  const Wide d;
  constexpr std::size_t most = 64, pad = hn::MaxLanes(Wide());
  const std::size_t lanes = hn::Lanes(d), count = p.size();
  if (count > most) return true;
  std::array<Real, most + pad> x, y, z;
  std::size_t k = 0;
  for (; k + lanes <= count; k += lanes) {
    const WideVec3 here = load(&p[k]);
    hn::StoreU(here.x, d, &x[k]);
    hn::StoreU(here.y, d, &y[k]);
    hn::StoreU(here.z, d, &z[k]);
  }
  for (; k < count; ++k) x[k] = p[k].x(), y[k] = p[k].y(), z[k] = p[k].z();
  for (auto* of : {&x, &y, &z}) hn::StoreU(hn::Inf(d), d, of->data() + count);
  const auto near = hn::Set(d, 2 * squared);
  auto any = hn::MaskFromVec(hn::Zero(d));
  for (std::size_t after = 1; after < count; ++after) {
    for (std::size_t i = 0; i + after < count; i += lanes) {
      const auto off = [&](const auto& of) { return hn::Sub(hn::LoadU(d, &of[i]), hn::LoadU(d, &of[i + after])); };
      const auto dx = off(x), dy = off(y), dz = off(z);
      any = hn::Or(any, hn::Lt(hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx))), near));
    }
  }
  return !hn::AllFalse(d, any);
}

// Highway's dispatch does not support templates.
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

HWY_EXPORT(may_coincide_of);
HWY_EXPORT(multipliers_single);
HWY_EXPORT(multipliers_double);
HWY_EXPORT(move_single);
HWY_EXPORT(move_double);

bool may_coincide(std::span<const Vec3> p, Real squared) { return HWY_DYNAMIC_DISPATCH(may_coincide_of)(p, squared); }

template <>
void find_multipliers(const MultiplierLaw& law, const DensitySums<float>& in, Real* rho, float* lambda) {
  HWY_DYNAMIC_DISPATCH(multipliers_single)(law, in, rho, lambda);
}
template <>
void find_multipliers(const MultiplierLaw& law, const DensitySums<double>& in, Real* rho, double* lambda) {
  HWY_DYNAMIC_DISPATCH(multipliers_double)(law, in, rho, lambda);
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

// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "boundary/obstacles/open_space.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boundary/obstacles/open_space.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "boundary/obstacles/open_space-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Appends the numbers of those that are marked, from the first on.
template <class Mask>
HWY_INLINE std::size_t append(Mask mask, std::size_t first, LocalId* found) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Wide(), mask, bytes.data());
  std::size_t count = 0;
  for (unsigned bits = bytes[0]; bits != 0; bits &= bits - 1)
    found[count++] = static_cast<LocalId>(first) + std::countr_zero(bits);
  return count;
}

std::size_t find_outside_of(const OpenSpace& open, std::span<const Vec3> p, LocalId* found) {
  const std::size_t lanes = hn::Lanes(Wide());
  std::size_t count = 0, k = 0;
  for (; k + lanes <= p.size(); k += lanes) {
    const WideVec3 here = load(&p[k]);
    count += append(hn::Or(is_outside(open.box(), here), is_closed(open, here, here)), k, found + count);
  }
  const auto is_beyond = [&](const Vec3& one) {
    return (one.array() < open.box().min.array()).any() || (one.array() > open.box().max.array()).any();
  };
  for (; k < p.size(); ++k)
    if (is_beyond(p[k]) || open.closes(p[k], p[k])) found[count++] = static_cast<LocalId>(k);
  return count;
}

std::size_t go_straight_by(const OpenSpace& open, const Straight& way, Vec3* end, LocalId* found) {
  const Wide d;
  const auto dt = hn::Set(d, way.dt);
  const std::size_t lanes = hn::Lanes(d), all = way.p.size();
  std::size_t count = 0, k = 0;
  for (; k + lanes <= all; k += lanes) {
    const WideVec3 from = load(&way.p[k]), v = load(&way.v[k]);
    const WideVec3 to = {hn::Add(from.x, hn::Mul(v.x, dt)), hn::Add(from.y, hn::Mul(v.y, dt)),
                         hn::Add(from.z, hn::Mul(v.z, dt))};
    hn::StoreInterleaved3(to.x, to.y, to.z, d, end[k].data());
    const auto inside = hn::And(is_inside(open.box(), from), is_inside(open.box(), to));
    count += append(hn::Or(hn::Not(inside), is_closed(open, from, to)), k, found + count);
  }
  for (; k < all; ++k) {
    end[k] = way.p[k] + way.v[k] * way.dt;
    if (!open.contains(way.p[k], end[k])) found[count++] = static_cast<LocalId>(k);
  }
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(find_outside_of);
HWY_EXPORT(go_straight_by);

std::size_t find_outside(const OpenSpace& open, std::span<const Vec3> p, LocalId* found) {
  return HWY_DYNAMIC_DISPATCH(find_outside_of)(open, p, found);
}

std::size_t go_straight(const OpenSpace& open, const Straight& way, Vec3* end, LocalId* found) {
  return HWY_DYNAMIC_DISPATCH(go_straight_by)(open, way, end, found);
}

}  // namespace trevi
#endif

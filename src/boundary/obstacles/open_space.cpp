// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "boundary/obstacles/open_space.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boundary/obstacles/open_space.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "boundary/obstacles/open_space-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <class Mask>
HWY_INLINE unsigned bits_of(Mask mask) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(Wide(), mask, bytes.data());
  return bytes[0];
}

// Appends the numbers of the marked lanes, counted from `first`.
template <class Mask>
HWY_INLINE std::size_t append(Mask mask, std::size_t first, LocalId* found) {
  std::size_t count = 0;
  for (unsigned bits = bits_of(mask); bits != 0; bits &= bits - 1)
    found[count++] = static_cast<LocalId>(first) + std::countr_zero(bits);
  return count;
}

// False for a NaN.
HWY_INLINE bool is_beyond(const Box& box, const Vec3& p) {
  return (p.array() < box.min.array()).any() || (p.array() > box.max.array()).any();
}

// Four numbers at a time where there are vectors of this width; the number that follows z is not used.
Box box_around_of(std::span<const Vec3> p, std::size_t each) {
  const std::size_t last = p.size() - 1;
#if HWY_MAX_BYTES >= 32
  const hn::FixedTag<double, 4> d;
  std::array<Real, 4> low_of{p[last].x(), p[last].y(), p[last].z(), 0}, high_of;
  auto low = hn::LoadU(d, low_of.data()), high = low;
  for (std::size_t k = 0; k < last; k += each) {
    const auto here = hn::LoadU(d, p[k].data());
    low = hn::Min(low, here);
    high = hn::Max(high, here);
  }
  hn::StoreU(low, d, low_of.data());
  hn::StoreU(high, d, high_of.data());
  return {Vec3(low_of[0], low_of[1], low_of[2]), Vec3(high_of[0], high_of[1], high_of[2])};
#else
  Box box{p[last], p[last]};
  for (std::size_t k = 0; k < last; k += each) box = {box.min.cwiseMin(p[k]), box.max.cwiseMax(p[k])};
  return box;
#endif
}

std::size_t find_outside_of(const OpenSpace& open, std::span<const Vec3> p, LocalId* found) {
  const std::size_t lanes = hn::Lanes(Wide());
  std::size_t count = 0, k = 0;
  for (; k + lanes <= p.size(); k += lanes) {
    const WideVec3 here = load(&p[k]);
    count += append(hn::Or(is_outside(open.box(), here), is_closed(open, here)), k, found + count);
  }
  for (; k < p.size(); ++k)
    if (is_beyond(open.box(), p[k]) || open.closes(p[k], p[k])) found[count++] = static_cast<LocalId>(k);
  return count;
}

std::size_t find_outside_both(const OpenSpace& open, const Box& box, std::span<const Vec3> p, OutsideOf* found) {
  const Box both{open.box().min.cwiseMax(box.min), open.box().max.cwiseMin(box.max)};
  const std::size_t lanes = hn::Lanes(Wide());
  std::size_t count = 0, k = 0;
  for (; k + lanes <= p.size(); k += lanes) {
    const WideVec3 here = load(&p[k]);
    const auto closed = is_closed(open, here), any = hn::Or(is_outside(both, here), closed);
    if (hn::AllFalse(Wide(), any)) continue;
    const unsigned space = bits_of(hn::Or(is_outside(open.box(), here), closed));
    for (unsigned bits = bits_of(any); bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      found[count++] = {static_cast<LocalId>(k) + lane, (space >> lane & 1U) != 0};
    }
  }
  for (; k < p.size(); ++k) {
    const bool of_space = is_beyond(open.box(), p[k]) || open.closes(p[k], p[k]);
    if (of_space || is_beyond(box, p[k])) found[count++] = {static_cast<LocalId>(k), of_space};
  }
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

HWY_EXPORT(box_around_of);
HWY_EXPORT(find_outside_of);
HWY_EXPORT(find_outside_both);
HWY_EXPORT(go_straight_by);

Box box_around(std::span<const Vec3> p, std::size_t each) { return HWY_DYNAMIC_DISPATCH(box_around_of)(p, each); }

std::size_t find_outside(const OpenSpace& open, std::span<const Vec3> p, LocalId* found) {
  return HWY_DYNAMIC_DISPATCH(find_outside_of)(open, p, found);
}

std::size_t find_outside(const OpenSpace& open, const Box& box, std::span<const Vec3> p, OutsideOf* found) {
  return HWY_DYNAMIC_DISPATCH(find_outside_both)(open, box, p, found);
}

std::size_t go_straight(const OpenSpace& open, const Straight& way, Vec3* end, LocalId* found) {
  return HWY_DYNAMIC_DISPATCH(go_straight_by)(open, way, end, found);
}

}  // namespace trevi
#endif

// Tests of particles and their paths against boxes, for as many at a time as a vector has doubles. Included once per
// instruction set.
#if defined(TREVI_BOUNDARY_OPEN_SPACE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_BOUNDARY_OPEN_SPACE_INL
#undef TREVI_BOUNDARY_OPEN_SPACE_INL
#else
#define TREVI_BOUNDARY_OPEN_SPACE_INL
#endif

#include <hwy/highway.h>

#include "boundary/obstacles/open_space.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Wide = hn::ScalableTag<double>;

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

// A NaN is neither inside nor outside any box.
HWY_INLINE auto is_inside(const Box& box, const WideVec3& p) {
  const Wide d;
  const auto within = [d](hn::Vec<Wide> v, Real low, Real high) {
    return hn::And(hn::Ge(v, hn::Set(d, low)), hn::Le(v, hn::Set(d, high)));
  };
  return hn::And(hn::And(within(p.x, box.min.x(), box.max.x()), within(p.y, box.min.y(), box.max.y())),
                 within(p.z, box.min.z(), box.max.z()));
}

// The same for both ends of paths; a NaN may count as inside if the other end is inside.
HWY_INLINE auto are_inside(const Box& box, const WideVec3& from, const WideVec3& to) {
  const Wide d;
  const auto within = [d](hn::Vec<Wide> a, hn::Vec<Wide> b, Real low, Real high) {
    return hn::And(hn::Ge(hn::Min(a, b), hn::Set(d, low)), hn::Le(hn::Max(a, b), hn::Set(d, high)));
  };
  return hn::And(
      hn::And(within(from.x, to.x, box.min.x(), box.max.x()), within(from.y, to.y, box.min.y(), box.max.y())),
      within(from.z, to.z, box.min.z(), box.max.z()));
}

HWY_INLINE auto is_in(const Ball& ball, hn::Vec<Wide> off_x, hn::Vec<Wide> off_y, hn::Vec<Wide> off_z) {
  const auto in_plane = hn::Add(hn::Mul(off_x, off_x), hn::Mul(off_y, off_y));
  return hn::Le(hn::Add(in_plane, hn::Mul(off_z, off_z)), hn::Set(Wide(), ball.radius * ball.radius));
}

// Whether positions are in closed parts. Most of the water is below all of them.
HWY_INLINE auto is_closed(const OpenSpace& open, const WideVec3& p) {
  const Wide d;
  const auto within = [d](hn::Vec<Wide> v, Real low, Real high) {
    return hn::And(hn::Ge(v, hn::Set(d, low)), hn::Le(v, hn::Set(d, high)));
  };
  auto met = hn::MaskFromVec(hn::Zero(d));
  if (hn::AllFalse(d, hn::Ge(p.z, hn::Set(d, open.lowest_closed())))) return met;
  for (std::size_t k = 0; k < open.closed_parts(); ++k) {
    const auto& [box, ball] = open.closed(k);
    const auto in_z = within(p.z, box.min.z(), box.max.z());
    if (hn::AllFalse(d, in_z)) continue;
    const auto in_box =
        hn::And(in_z, hn::And(within(p.x, box.min.x(), box.max.x()), within(p.y, box.min.y(), box.max.y())));
    if (hn::AllFalse(d, in_box)) continue;
    const auto off = [d](hn::Vec<Wide> v, Real middle) { return hn::Sub(v, hn::Set(d, middle)); };
    const Vec3& middle = ball.center;
    met = hn::Or(met, hn::And(in_box, is_in(ball, off(p.x, middle.x()), off(p.y, middle.y()), off(p.z, middle.z()))));
  }
  return met;
}

// Whether the box around a path extends into a closed part.
HWY_INLINE auto is_closed(const OpenSpace& open, const WideVec3& from, const WideVec3& to) {
  const Wide d;
  const auto across = [d](hn::Vec<Wide> a, hn::Vec<Wide> b, Real low, Real high) {
    return hn::And(hn::Ge(hn::Max(a, b), hn::Set(d, low)), hn::Le(hn::Min(a, b), hn::Set(d, high)));
  };
  auto met = hn::MaskFromVec(hn::Zero(d));
  if (hn::AllFalse(d, hn::Ge(hn::Max(from.z, to.z), hn::Set(d, open.lowest_closed())))) return met;
  for (std::size_t k = 0; k < open.closed_parts(); ++k) {
    const auto& [box, ball] = open.closed(k);
    const auto in_z = across(from.z, to.z, box.min.z(), box.max.z());
    if (hn::AllFalse(d, in_z)) continue;
    const auto in_box = hn::And(
        in_z, hn::And(across(from.x, to.x, box.min.x(), box.max.x()), across(from.y, to.y, box.min.y(), box.max.y())));
    if (hn::AllFalse(d, in_box)) continue;
    const auto gap = [d](hn::Vec<Wide> a, hn::Vec<Wide> b, Real middle) {
      const auto at = hn::Set(d, middle);
      return hn::Max(hn::Max(hn::Sub(at, hn::Max(a, b)), hn::Sub(hn::Min(a, b), at)), hn::Zero(d));
    };
    const Vec3& middle = ball.center;
    met = hn::Or(met, hn::And(in_box, is_in(ball, gap(from.x, to.x, middle.x()), gap(from.y, to.y, middle.y()),
                                            gap(from.z, to.z, middle.z()))));
  }
  return met;
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();
#endif

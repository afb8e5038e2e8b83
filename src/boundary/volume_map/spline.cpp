// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "boundary/volume_map/spline.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boundary/volume_map/spline.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include <array>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Vectors of two doubles take as long as one by one.
#if HWY_MAX_BYTES >= 32

using Four = hn::FixedTag<double, 4>;
using FourReals = hn::Vec<Four>;

// What each of the four nodes along an axis weighs, and the derivatives: by node, then by axis.
struct Weights {
  std::array<std::array<Real, 4>, 4> value, slope;
};

HWY_INLINE void find_weights(const Vec3& at, Weights& weights) {
  const Four d;
  const std::array<Real, 4> by_axis{at.x(), at.y(), at.z(), 0};
  const auto t = hn::LoadU(d, by_axis.data());
  const auto number = [&](Real x) { return hn::Set(d, x); };
  const auto store = [&](FourReals v, std::array<Real, 4>& to) { hn::StoreU(v, d, to.data()); };
  const auto half = hn::Mul(number(0.5), t), thrice = hn::Mul(number(1.5), t), tt = hn::Mul(t, t);
  store(hn::Mul(t, hn::Add(number(-0.5), hn::Mul(t, hn::Sub(number(1), half)))), weights.value[0]);
  store(hn::Add(number(1), hn::Mul(tt, hn::Add(number(-2.5), thrice))), weights.value[1]);
  store(hn::Mul(t, hn::Add(number(0.5), hn::Mul(t, hn::Sub(number(2), thrice)))), weights.value[2]);
  store(hn::Mul(tt, hn::Add(number(-0.5), half)), weights.value[3]);
  const auto large = hn::Mul(number(4.5), t);
  store(hn::Add(number(-0.5), hn::Mul(t, hn::Sub(number(2), thrice))), weights.slope[0]);
  store(hn::Mul(t, hn::Add(number(-5), large)), weights.slope[1]);
  store(hn::Add(number(0.5), hn::Mul(t, hn::Sub(number(4), large))), weights.slope[2]);
  store(hn::Mul(t, hn::Add(number(-1), thrice)), weights.slope[3]);
}

// A lane for each plane of nodes.
SplineValue interpolate_of(const SplineNodes& nodes, const Vec3& t) {
  const Four d;
  Weights weights;
  find_weights(t, weights);
  const auto along_x = [&](const std::array<std::array<Real, 4>, 4>& of, const std::array<FourReals, 4>& node) {
    const auto part = [&](std::size_t n) { return hn::Mul(hn::Set(d, of[n][0]), node[n]); };
    return hn::Add(hn::Add(part(0), part(1)), hn::Add(part(2), part(3)));
  };
  auto value = hn::Zero(d), slope_x = value, slope_y = value;
  for (std::size_t j = 0; j < 4; ++j) {
    const Real* const row = nodes.first + j * nodes.row;
    const auto a = hn::LoadU(d, row), b = hn::LoadU(d, row + nodes.plane);
    const auto e = hn::LoadU(d, row + 2 * nodes.plane), f = hn::LoadU(d, row + 3 * nodes.plane);
    const auto even = hn::InterleaveLower(d, a, b), odd = hn::InterleaveUpper(d, a, b);
    const auto even_up = hn::InterleaveLower(d, e, f), odd_up = hn::InterleaveUpper(d, e, f);
    const std::array<FourReals, 4> node{hn::ConcatLowerLower(d, even_up, even), hn::ConcatLowerLower(d, odd_up, odd),
                                        hn::ConcatUpperUpper(d, even_up, even), hn::ConcatUpperUpper(d, odd_up, odd)};
    const auto line = along_x(weights.value, node), line_slope = along_x(weights.slope, node);
    const auto weight = hn::Set(d, weights.value[j][1]);
    value = hn::Add(value, hn::Mul(weight, line));
    slope_x = hn::Add(slope_x, hn::Mul(weight, line_slope));
    slope_y = hn::Add(slope_y, hn::Mul(hn::Set(d, weights.slope[j][1]), line));
  }
  std::array<Real, 4> of_plane, of_plane_x, of_plane_y;
  hn::StoreU(value, d, of_plane.data());
  hn::StoreU(slope_x, d, of_plane_x.data());
  hn::StoreU(slope_y, d, of_plane_y.data());
  SplineValue sum{0, Vec3::Zero()};
  for (std::size_t k = 0; k < 4; ++k) {
    const Real weight = weights.value[k][2];
    sum.value += weight * of_plane[k];
    sum.slope += Vec3(weight * of_plane_x[k], weight * of_plane_y[k], weights.slope[k][2] * of_plane[k]);
  }
  return sum;
}

#else

// What each of four nodes weighs at t between the second and the third, and the derivatives.
struct Spline {
  std::array<Real, 4> value, slope;
};
HWY_INLINE Spline spline_at(Real t) {
  return {{t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2 - 1.5 * t)),
           t * t * (-0.5 + 0.5 * t)},
          {-0.5 + t * (2 - 1.5 * t), t * (-5 + 4.5 * t), 0.5 + t * (4 - 4.5 * t), t * (-1 + 1.5 * t)}};
}

SplineValue interpolate_of(const SplineNodes& nodes, const Vec3& t) {
  const Spline sx = spline_at(t.x()), sy = spline_at(t.y()), sz = spline_at(t.z());
  SplineValue sum{0, Vec3::Zero()};
  for (std::size_t k = 0; k < 4; ++k) {
    Real plane = 0, plane_x = 0, plane_y = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      const Real* const d = nodes.first + k * nodes.plane + j * nodes.row;
      const auto along_x = [&](const std::array<Real, 4>& x) {
        return (x[0] * d[0] + x[1] * d[1]) + (x[2] * d[2] + x[3] * d[3]);
      };
      const Real line = along_x(sx.value);
      plane += sy.value[j] * line;
      plane_x += sy.value[j] * along_x(sx.slope);
      plane_y += sy.slope[j] * line;
    }
    sum.value += sz.value[k] * plane;
    sum.slope += Vec3(sz.value[k] * plane_x, sz.value[k] * plane_y, sz.slope[k] * plane);
  }
  return sum;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(interpolate_of);

SplineValue interpolate(const SplineNodes& nodes, const Vec3& t) {
  return HWY_DYNAMIC_DISPATCH(interpolate_of)(nodes, t);
}

}  // namespace trevi
#endif

// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "boundary/volume_map/spline.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boundary/volume_map/spline.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include <array>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Vectors of two doubles are no faster than single numbers.
#if HWY_MAX_BYTES >= 32

using Four = hn::FixedTag<double, 4>;
using FourReals = hn::Vec<Four>;

// The weights of the four nodes along each axis, or the derivatives of these: by node, then by axis.
using Weights = std::array<std::array<Real, 4>, 4>;

HWY_INLINE FourReals by_axis(const Vec3& at) {
  const std::array<Real, 4> of{at.x(), at.y(), at.z(), 0};
  return hn::LoadU(Four(), of.data());
}

HWY_INLINE void find_weights(FourReals t, Weights& weights) {
  const Four d;
  const auto number = [&](Real x) { return hn::Set(d, x); };
  const auto store = [&](FourReals v, std::size_t n) { hn::StoreU(v, d, weights[n].data()); };
  const auto half = hn::Mul(number(0.5), t), thrice = hn::Mul(number(1.5), t), tt = hn::Mul(t, t);
  store(hn::Mul(t, hn::Add(number(-0.5), hn::Mul(t, hn::Sub(number(1), half)))), 0);
  store(hn::Add(number(1), hn::Mul(tt, hn::Add(number(-2.5), thrice))), 1);
  store(hn::Mul(t, hn::Add(number(0.5), hn::Mul(t, hn::Sub(number(2), thrice)))), 2);
  store(hn::Mul(tt, hn::Add(number(-0.5), half)), 3);
}

HWY_INLINE void find_slopes(FourReals t, Weights& slopes) {
  const Four d;
  const auto number = [&](Real x) { return hn::Set(d, x); };
  const auto store = [&](FourReals v, std::size_t n) { hn::StoreU(v, d, slopes[n].data()); };
  const auto thrice = hn::Mul(number(1.5), t), large = hn::Mul(number(4.5), t);
  store(hn::Add(number(-0.5), hn::Mul(t, hn::Sub(number(2), thrice))), 0);
  store(hn::Mul(t, hn::Add(number(-5), large)), 1);
  store(hn::Add(number(0.5), hn::Mul(t, hn::Sub(number(4), large))), 2);
  store(hn::Mul(t, hn::Add(number(-1), thrice)), 3);
}

// Interpolates along x in the j-th rows of four planes.
HWY_INLINE FourReals along_x(const SplineNodes& nodes, std::size_t j, const Weights& of) {
  const Four d;
  const Real* const row = nodes.first + j * nodes.row;
  const auto a = hn::LoadU(d, row), b = hn::LoadU(d, row + nodes.plane);
  const auto e = hn::LoadU(d, row + 2 * nodes.plane), f = hn::LoadU(d, row + 3 * nodes.plane);
  const auto even = hn::InterleaveLower(d, a, b), odd = hn::InterleaveUpper(d, a, b);
  const auto even_up = hn::InterleaveLower(d, e, f), odd_up = hn::InterleaveUpper(d, e, f);
  const auto part = [&](std::size_t n, FourReals node) { return hn::Mul(hn::Set(d, of[n][0]), node); };
  return hn::Add(
      hn::Add(part(0, hn::ConcatLowerLower(d, even_up, even)), part(1, hn::ConcatLowerLower(d, odd_up, odd))),
      hn::Add(part(2, hn::ConcatUpperUpper(d, even_up, even)), part(3, hn::ConcatUpperUpper(d, odd_up, odd))));
}

// One lane for each plane of nodes.
SplineValue interpolate_of(const SplineNodes& nodes, const Vec3& at, Real flat) {
  const Four d;
  const FourReals t = by_axis(at);
  Weights weights, slopes;
  find_weights(t, weights);
  std::array<FourReals, 4> line{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  auto value = hn::Zero(d);
  for (std::size_t j = 0; j < 4; ++j) {
    line[j] = along_x(nodes, j, weights);
    value = hn::Add(value, hn::Mul(hn::Set(d, weights[j][1]), line[j]));
  }
  std::array<Real, 4> of_plane, of_plane_x, of_plane_y;
  hn::StoreU(value, d, of_plane.data());
  SplineValue sum{0, Vec3::Zero()};
  for (std::size_t k = 0; k < 4; ++k) sum.value += weights[k][2] * of_plane[k];
  if (sum.value >= flat) return sum;
  find_slopes(t, slopes);
  auto slope_x = hn::Zero(d), slope_y = slope_x;
  for (std::size_t j = 0; j < 4; ++j) {
    slope_x = hn::Add(slope_x, hn::Mul(hn::Set(d, weights[j][1]), along_x(nodes, j, slopes)));
    slope_y = hn::Add(slope_y, hn::Mul(hn::Set(d, slopes[j][1]), line[j]));
  }
  hn::StoreU(slope_x, d, of_plane_x.data());
  hn::StoreU(slope_y, d, of_plane_y.data());
  for (std::size_t k = 0; k < 4; ++k)
    sum.slope += Vec3(weights[k][2] * of_plane_x[k], weights[k][2] * of_plane_y[k], slopes[k][2] * of_plane[k]);
  return sum;
}

#else

// The weights of four nodes at t between the second and the third one, and their derivatives.
struct Spline {
  std::array<Real, 4> value, slope;
};
HWY_INLINE Spline spline_at(Real t) {
  return {{t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2 - 1.5 * t)),
           t * t * (-0.5 + 0.5 * t)},
          {-0.5 + t * (2 - 1.5 * t), t * (-5 + 4.5 * t), 0.5 + t * (4 - 4.5 * t), t * (-1 + 1.5 * t)}};
}

SplineValue interpolate_of(const SplineNodes& nodes, const Vec3& t, Real flat) {
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
  if (sum.value >= flat) sum.slope.setZero();
  return sum;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(interpolate_of);

SplineValue interpolate(const SplineNodes& nodes, const Vec3& t, Real flat) {
  return HWY_DYNAMIC_DISPATCH(interpolate_of)(nodes, t, flat);
}

}  // namespace trevi
#endif

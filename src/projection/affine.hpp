// Affine fits of the motion in a cell, u(y) = a + B y, with y in cells from the cell's corner and u in metres: the
// least squares fit of the particles of the cell and of its neighbours with the weights 1, projection::tent along each
// axis. A translation, a rotation and a shear are their own fits (the affine part of Jiang et al., The affine
// particle-in-cell method, ACM Trans. Graph. 34, 2015, here of cells rather than of particles, so that particles carry
// nothing along). By coordinate x, y, z. Not collective.
#pragma once

#include <algorithm>
#include <array>

#include "projection/cell_sums.hpp"
#include "projection/parameters.hpp"

namespace trevi {

/// The weight w of something that lies z = −1, 0 or 1 cells away along a coordinate axis.
struct Beside {
  Real w;
  std::size_t axis;
  Real z;
};

namespace affine {

// to += w from, number by number.
template <class T>
void add_weighted(T& to, const T& from, Real w) {
  constexpr std::size_t numbers = sizeof(T) / sizeof(Real);
  auto* out = reinterpret_cast<Real*>(&to);
  const auto* in = reinterpret_cast<const Real*>(&from);
  for (std::size_t i = 0; i < numbers; ++i) out[i] += w * in[i];
}

}  // namespace affine

/// Where particles are: their number, Σ y and Σ y yᵀ (xx, yy, zz, xy, xz, yz).
struct Places {
  Real n = 0;
  ByAxis y{};
  std::array<Real, 6> yy{};

  /// What more there is to add of a cell that is beside this one: y + z.
  void shift(const Places& from, const Beside& by) {
    const auto [w, b, z] = by;
    const std::size_t c = (b + 1) % 3, d = (b + 2) % 3;
    y[b] += w * z * from.n;
    yy[b] += w * (2 * z * from.y[b] + from.n);
    yy[b + c + 2] += w * z * from.y[c];
    yy[b + d + 2] += w * z * from.y[d];
  }
  /// Σ y_a y_b.
  Real second(std::size_t a, std::size_t b) const { return a == b ? yy[a] : yy[a + b + 2]; }
};

/// How they move: Σ u and Σ u_a y_b.
struct Flow {
  ByAxis u{};
  std::array<ByAxis, 3> uy{};

  void shift(const Flow& from, const Beside& by) {
    for (std::size_t a = 0; a < 3; ++a) uy[a][by.axis] += by.w * by.z * from.u[a];
  }
};

/// Both, of the same particles, and Σ of whatever else is wanted of them.
struct Moments {
  Places at;
  Flow flow;
  Real more = 0;

  void shift(const Moments& from, const Beside& by) {
    at.shift(from.at, by);
    flow.shift(from.flow, by);
  }
};
inline bool is_empty(const Moments& moments) { return moments.at.n == 0; }

/// u(y) = a + B y of one cell or, with weights, the sum of such of several; `weight` is the sum of these.
struct AffineMap {
  Real weight = 0;
  ByAxis a{};
  std::array<ByAxis, 3> b{};

  void shift(const AffineMap& from, const Beside& by) {
    for (std::size_t i = 0; i < 3; ++i) a[i] -= by.w * by.z * from.b[i][by.axis];
  }
  void add(const AffineMap& from, Real factor) { affine::add_weighted(*this, from, factor); }
  Real at(std::size_t i, const ByAxis& y) const { return a[i] + (b[i][0] * y[0] + b[i][1] * y[1] + b[i][2] * y[2]); }
};

/// Whether there is nothing to add.
inline bool is_empty(const AffineMap& map) { return map.weight == 0; }

/// Adds what is in a cell beside this one, in this one's coordinates.
template <class T>
void add_beside(T& to, const T& from, const Beside& by) {
  affine::add_weighted(to, from, by.w);
  if (by.z != 0) to.shift(from, by);
}

/// The places of a fit as it needs them: mean and inverse of the variance.
struct Spread {
  Real n = 0;
  ByAxis mean{};
  std::array<Real, 6> inverse{};
};

using Matrix3 = std::array<ByAxis, 3>;

inline Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 c{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  }
  return c;
}

inline Spread spread_of(const Places& places) {
  Spread s;
  s.n = places.n;
  if (s.n <= 0) return s;
  for (std::size_t a = 0; a < 3; ++a) s.mean[a] = places.y[a] / s.n;
  const auto variance = [&](std::size_t a, std::size_t b) {
    return places.second(a, b) / s.n - s.mean[a] * s.mean[b] + (a == b ? projection::fit_damping : 0);
  };
  // Rounding may leave a variance of a single particle below what is added.
  const auto own = [&](std::size_t a) { return std::max(variance(a, a), projection::fit_damping); };
  const Real xx = own(0), yy = own(1), zz = own(2), xy = variance(0, 1), xz = variance(0, 2), yz = variance(1, 2);
  const Real cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - xz * yy;
  const Real least = 0.5 * projection::fit_damping * projection::fit_damping * projection::fit_damping;
  const Real per = 1 / std::max(xx * cxx + xy * cxy + xz * cxz, least);
  const Matrix3 once = {{{cxx * per, cxy * per, cxz * per},
                         {cxy * per, (xx * zz - xz * xz) * per, (xy * xz - xx * yz) * per},
                         {cxz * per, (xy * xz - xx * yz) * per, (xx * yy - xy * xy) * per}}};
  // What the damping leaves out of a fit is fitted, too, twice: P + e P² + e² P³ with the damped inverse P. Where there
  // is a variance the damping is gone to (e P)³, and where there is none the inverse is bounded by 3/e.
  constexpr Real e = projection::fit_damping;
  const Matrix3 twice = product(once, once), thrice = product(twice, once);
  const auto sum = [&](std::size_t a, std::size_t b) { return once[a][b] + e * (twice[a][b] + e * thrice[a][b]); };
  s.inverse = {sum(0, 0), sum(1, 1), sum(2, 2), sum(0, 1), sum(0, 2), sum(1, 2)};
  return s;
}

/// The fit of the summed motion; `rest2`, if it is asked for, gets the variance of the motion less what the slopes
/// explain of it, m², where `uu` is the sum of squares.
inline AffineMap fit_of(const Spread& s, const Flow& flow, Real uu = 0, Real* rest2 = nullptr) {
  AffineMap fit;
  if (s.n <= 0) return fit;
  fit.weight = 1;
  const auto inverse = [&](std::size_t a, std::size_t b) { return a == b ? s.inverse[a] : s.inverse[a + b + 2]; };
  Real explained = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Real mean = flow.u[i] / s.n;
    ByAxis covariance{};
    for (std::size_t j = 0; j < 3; ++j) covariance[j] = flow.uy[i][j] / s.n - mean * s.mean[j];
    for (std::size_t j = 0; j < 3; ++j) {
      fit.b[i][j] = covariance[0] * inverse(0, j) + covariance[1] * inverse(1, j) + covariance[2] * inverse(2, j);
      explained += fit.b[i][j] * covariance[j];
    }
    fit.a[i] = mean - (fit.b[i][0] * s.mean[0] + fit.b[i][1] * s.mean[1] + fit.b[i][2] * s.mean[2]);
    explained += mean * mean;
  }
  if (rest2 != nullptr) *rest2 = std::max(uu / s.n - explained, 0.0);
  return fit;
}

}  // namespace trevi

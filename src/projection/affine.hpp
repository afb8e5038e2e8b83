// Affine fits of the motion in a cell, u(y) = a + B y, with y in cells from the cell's corner and u in metres: the least
// squares fit of the particles of the cell and of its neighbours with the weights 1, 1/2 of a tent along each axis. A
// translation, a rotation and a shear are their own fits (the affine part of Jiang et al., The affine particle-in-cell
// method, ACM Trans. Graph. 34, 2015, here of cells rather than of particles, so that particles carry nothing along).
// By coordinate x, y, z. Not collective.
#pragma once

#include <algorithm>
#include <array>

#include "projection/cell_sums.hpp"
#include "projection/parameters.hpp"

namespace trevi {

/// Where particles are: their number, Σ y and Σ y yᵀ (xx, yy, zz, xy, xz, yz).
struct Places {
  Real n = 0;
  ByAxis y{};
  std::array<Real, 6> yy{};

  /// Adds those of the neighbour cell that is `z` cells away, with a weight.
  void add(const Places& from, Real weight, const ByAxis& z) {
    n += weight * from.n;
    for (std::size_t a = 0; a < 3; ++a) {
      y[a] += weight * (from.y[a] + z[a] * from.n);
      yy[a] += weight * (from.yy[a] + z[a] * (2 * from.y[a] + z[a] * from.n));
    }
    const auto mixed = [&](std::size_t a, std::size_t b) {
      return z[a] * from.y[b] + z[b] * (from.y[a] + z[a] * from.n);
    };
    yy[3] += weight * (from.yy[3] + mixed(0, 1));
    yy[4] += weight * (from.yy[4] + mixed(0, 2));
    yy[5] += weight * (from.yy[5] + mixed(1, 2));
  }
  /// Σ y_a y_b.
  Real second(std::size_t a, std::size_t b) const { return a == b ? yy[a] : yy[a + b + 2]; }
};

/// How they move: Σ u and Σ u_a y_b.
struct Flow {
  ByAxis u{};
  std::array<ByAxis, 3> uy{};

  void add(const Flow& from, Real weight, const ByAxis& z) {
    for (std::size_t a = 0; a < 3; ++a) {
      u[a] += weight * from.u[a];
      for (std::size_t b = 0; b < 3; ++b) uy[a][b] += weight * (from.uy[a][b] + from.u[a] * z[b]);
    }
  }
};

/// u(y) = a + B y of one cell or, with weights, the sum of such of several; `weight` is the sum of these.
struct AffineMap {
  Real weight = 0;
  ByAxis a{};
  std::array<ByAxis, 3> b{};

  void add(const AffineMap& from, Real factor, const ByAxis& z) {
    weight += factor * from.weight;
    for (std::size_t i = 0; i < 3; ++i) {
      a[i] += factor * (from.a[i] - (from.b[i][0] * z[0] + from.b[i][1] * z[1] + from.b[i][2] * z[2]));
      for (std::size_t j = 0; j < 3; ++j) b[i][j] += factor * from.b[i][j];
    }
  }
  Real at(std::size_t i, const ByAxis& y) const { return a[i] + (b[i][0] * y[0] + b[i][1] * y[1] + b[i][2] * y[2]); }
};

/// The places of a fit as it needs them: mean and inverse of the variance.
struct Spread {
  Real n = 0;
  ByAxis mean{};
  std::array<Real, 6> inverse{};
};

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
  s.inverse = {cxx * per,           (xx * zz - xz * xz) * per, (xx * yy - xy * xy) * per,
               cxy * per,           cxz * per,                 (xy * xz - xx * yz) * per};
  return s;
}

/// The fit of the summed motion; `rest2`, if it is asked for, gets the mean square of what it leaves, m², where `uu` is
/// the sum of squares.
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

// Affine fits of the motion in a cell, u(y) = a + B y, with y in cells from the cell's corner and u in metres: the
// least squares fit of the particles of the cell and of its neighbours with the weights 1, projection::tent along each
// axis. A translation, a rotation and a shear are their own fits (the affine part of Jiang et al., The affine
// particle-in-cell method, ACM Trans. Graph. 34, 2015, here of cells rather than of particles, so that particles carry
// nothing along). By coordinate x, y, z. What fits are made of and what they say, as the numbers of one cell; they are
// found row by row (row_fits.hpp).
#pragma once

#include <array>

#include "projection/cell_sums.hpp"

namespace trevi {

/// Where particles are: their number, Σ y and Σ y yᵀ (xx, yy, zz, xy, xz, yz).
struct Places {
  Real n = 0;
  ByAxis y{};
  std::array<Real, 6> yy{};
};

/// How they move: Σ u and Σ u_a y_b.
struct Flow {
  ByAxis u{};
  std::array<ByAxis, 3> uy{};
};

/// Both, of the same particles, and Σ of whatever else is wanted of them.
struct Moments {
  Places at;
  Flow flow;
  Real more = 0;
};

/// u(y) = a + B y of one cell or, with weights, the sum of such of several; `weight` is the sum of these.
struct AffineMap {
  Real weight = 0;
  ByAxis a{};
  std::array<ByAxis, 3> b{};

  Real at(std::size_t i, const ByAxis& y) const { return a[i] + (b[i][0] * y[0] + b[i][1] * y[1] + b[i][2] * y[2]); }
};

/// How many numbers a cell has in CellFields: Moments, an AffineMap, a Flow; and of the places of a fit, as it needs
/// them, 1 over the weight, mean, and inverse of the variance, and the mean square of the motion that the fit leaves,
/// m². Where planes are exchanged the volumes that a cell's particles add to planes go with its moments.
namespace numbers {
constexpr std::size_t moments = 23, map = 13, flow = 12, spread = 11, volumes = 3;
static_assert(sizeof(Moments) == moments * sizeof(Real) && sizeof(AffineMap) == map * sizeof(Real) &&
              sizeof(Flow) == flow * sizeof(Real));
}  // namespace numbers

}  // namespace trevi

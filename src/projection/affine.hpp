// Affine fits of the motion in a cell, u(y) = a + B y, with y in cells from the corner of the cell and u in metres:
// least squares fits to the particles of the cell and of its neighbours, with the weights 1, projection::tent along
// each axis. The fit of a translation, a rotation or a shear is exact (compare the affine part of Jiang et al., The
// affine particle-in-cell method, ACM Trans. Graph. 34, 2015; here it belongs to cells rather than to particles, so
// that particles carry no additional state). Components are along x, y, z. This file has the input and the result of a
// fit for one cell; the fits are computed row by row (row_fits.hpp).
#pragma once

#include <array>

#include "projection/cell_sums.hpp"

namespace trevi {

/// Sums over the positions of particles: their number, Σ y and Σ y yᵀ (xx, yy, zz, xy, xz, yz).
struct Places {
  Real n = 0;
  ByAxis y{};
  std::array<Real, 6> yy{};
};

/// Sums over their motion: Σ u and Σ u_a y_b.
struct Flow {
  ByAxis u{};
  std::array<ByAxis, 3> uy{};
};

/// Both for the same particles, and the sum of one further quantity.
struct Moments {
  Places at;
  Flow flow;
  Real more = 0;
};

/// u(y) = a + B y of one cell, or a weighted sum over several cells; `weight` is the sum of the weights.
struct AffineMap {
  Real weight = 0;
  ByAxis a{};
  std::array<ByAxis, 3> b{};

  Real at(std::size_t i, const ByAxis& y) const { return a[i] + (b[i][0] * y[0] + b[i][1] * y[1] + b[i][2] * y[2]); }
};

/// The number of values per cell in CellFields: for Moments, an AffineMap and a Flow. The spread of a fit holds 1 over
/// the weight, the mean of the positions, the inverse of their variance, and the mean square of the residual motion,
/// m². Where planes are exchanged, the volumes that the particles of a cell add to planes are sent with its moments.
namespace numbers {
constexpr std::size_t moments = 23, map = 13, flow = 12, spread = 11, volumes = 3;
static_assert(sizeof(Moments) == moments * sizeof(Real) && sizeof(AffineMap) == map * sizeof(Real) &&
              sizeof(Flow) == flow * sizeof(Real));
}  // namespace numbers

}  // namespace trevi

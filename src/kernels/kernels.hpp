// The smoothing kernels at run time: one Kernel describes each type of the list (kernels/list-inl.hpp), so that no
// other code depends on which kernel it uses. The pair loops sum the dimensionless shapes W(r)/W(0) and
// (−dW/dr)/slope_factor r̂; the factors here give these sums their units. A density constraint has two kernels, one for
// the density and one for the gradient along which particles are shifted; if they are the same, shifts are along the
// gradient of the constraint itself. Each kernel has a two-dimensional form with the same shape: its integral over the
// plane is 1, and its unit 1/m². Not collective.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trevi/settings.hpp"

namespace trevi {

/// The initial lattice of the water: cubic, or, in two dimensions, square in the plane of x and z.
struct PointLattice {
  PointLattice(Real edge, int axes = 3) : spacing(edge), dimensions(axes) {}
  Real spacing;    ///< m
  int dimensions;  ///< 2 or 3
};
PointLattice lattice_of(const FluidSettings& fluid);

/// All lengths in metres. In two dimensions the denominators of units have one metre less.
struct Kernel {
  std::string_view name;                    ///< the name in scenes
  int dimensions;                           ///< in which its integral is 1: 2 or 3
  std::size_t index;                        ///< in the list
  std::size_t gradient_index;               ///< of the gradient kernel to use by default with this density kernel
  Real (*factor)(Real h);                   ///< W(0), 1/m³
  Real (*slope_factor)(Real h);             ///< −dW/dr over its dimensionless shape, 1/m⁴
  Real (*steepest)(Real h);                 ///< largest −dW/dr over all distances, 1/m⁴
  Real (*value)(const Vec3& r, Real h);     ///< W, 1/m³; zero from h on
  Vec3 (*gradient)(const Vec3& r, Real h);  ///< ∇W, 1/m⁴; zero from h on, and at r = 0
};

/// In the order of the list.
std::span<const Kernel> all_kernels(int dimensions = 3);
std::vector<std::string> kernel_names();
/// Throws InputError if there is no kernel of this name.
const Kernel& kernel_named(std::string_view name, int dimensions = 3);

/// The two kernels of a density constraint.
struct Kernels {
  Kernel density, gradient;
};
Kernels kernels_of(const FluidSettings& fluid);

/// Sum of the kernel over a lattice of as many dimensions around one of its points, itself included, 1/m³; h in metres.
Real lattice_density_sum(const Kernel& kernel, const PointLattice& lattice, Real h);
/// The weight F of the friction between two particles a distance u h apart: (1 − u²)^(3/2), in two dimensions (1 −
/// u²)²; zero from u = 1 on. Over a plane, or line, at distance z it adds up to a multiple of (1 − z²/h²)^(5/2). Σ F x²
/// and Σ F z² over layers one spacing apart along z therefore agree within 1.5 % at h = 2 s and 0.4 % from 2.5 s on,
/// however the particles are arranged in their layers. With Poly6 they differ by 7 % at h = 2 s.
Real friction_weight(Real u2, int dimensions);
/// Σ F over the lattice around one of its points, itself included.
Real lattice_friction_sum(const PointLattice& lattice, Real h);
/// ½ Σ F x² over the same points, m²: Σ_j (v_j − v_i) F(p_ij) is this times ∇²v, to the second order of v's Taylor
/// series (the first vanishes by symmetry, and x², y², z² have the same sums).
Real lattice_laplacian_moment(const PointLattice& lattice, Real h);
/// The ε, m², for which the sum divided by this moment is ∇²v + ε ∇⁴v, averaged over all directions.
Real lattice_laplacian_truncation(const PointLattice& lattice, Real h);
/// Number of lattice points nearer than h, without the point itself.
int lattice_neighbours(const PointLattice& lattice, Real h);

/// Largest eigenvalue mu of a Jacobi sweep with relaxation 1 on the infinite lattice. `volume` V is the mass of a
/// particle over the rest density, m³; epsilon in 1/m². A sweep multiplies a wave e^{ik·x} in C by 1 − relaxation
/// mu(k), with
///   mu(k) = V Σ_r ∇W sin(k·r) · V Σ_r ∇G sin(k·r) / (V² Σ_r |∇G|² + epsilon), W of the density, G of the gradient,
/// so that with a relaxation above 2/mu some wave grows. IEEE operations only: the same bits on any processor.
Real lattice_jacobi_eigenvalue(const Kernels& kernels, const PointLattice& lattice, Real h, Real volume, Real epsilon);

}  // namespace trevi

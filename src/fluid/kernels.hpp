// The smoothing kernels as the program knows them at run time: one description of each type of the list
// (kernels/list-inl.hpp), taken from the type alone. Nothing asks which kernel it has.
// The pair loops sum the dimensionless shapes W(r)/W(0) and (−dW/dr)/slope_factor r̂; the factors here give them their
// units. A density constraint has two kernels, that of the density and that of the gradient which shifts follow: where
// they are one, the shifts follow the constraint's own gradient. Not collective.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trevi/settings.hpp"

namespace trevi {

/// All lengths in metres.
struct Kernel {
  std::string_view name;                    ///< that a scene gives
  std::size_t index;                        ///< in the list
  std::size_t gradient_index;               ///< of the kernel whose gradient goes with densities of this one
  Real (*factor)(Real h);                   ///< W(0), 1/m³
  Real (*slope_factor)(Real h);             ///< what the shape of −dW/dr is multiplied by, 1/m⁴
  Real (*steepest)(Real h);                 ///< the largest −dW/dr there is, 1/m⁴
  Real (*value)(const Vec3& r, Real h);     ///< W, 1/m³; zero from h on
  Vec3 (*gradient)(const Vec3& r, Real h);  ///< ∇W, 1/m⁴; zero from h on, and at r = 0
};

/// In the order of the list.
std::span<const Kernel> all_kernels();
std::vector<std::string> kernel_names();
/// Throws InputError where there is none of this name.
const Kernel& kernel_named(std::string_view name);

/// Those of a density constraint.
struct Kernels {
  Kernel density, gradient;
};
Kernels kernels_of(const FluidSettings& fluid);

/// Sum of the kernel over a cubic lattice around one of its points, itself included, 1/m³; spacing and h in metres.
Real lattice_density_sum(const Kernel& kernel, Real spacing, Real h);
/// ½ Σ W6(r) x² over the same points, 1/m: Σ_j (v_j − v_i) W6(p_ij) is this times ∇²v, to the second order of v's
/// Taylor series (the first vanishes by symmetry, and x², y², z² have the same sums). W6 is Poly6.
Real lattice_laplacian_moment(Real spacing, Real h);
/// Points of the lattice nearer than h, without the point itself.
int lattice_neighbours(Real spacing, Real h);

/// Largest eigenvalue of a Jacobi sweep with relaxation 1 on the endless lattice, `volume` the mass of a particle over
/// rest density, m³, and epsilon in 1/m². A wave e^{ik·x} in C leaves the sweep as 1 − relaxation mu(k) times itself,
///   mu(k) = V Σ_r ∇W sin(k·r) · V Σ_r ∇G sin(k·r) / (V² Σ_r |∇G|² + epsilon), W of the density, G of the gradient,
/// so a relaxation of 2/mu or more makes some wave grow. Only IEEE operations: the same bits on any processor.
Real lattice_jacobi_eigenvalue(const Kernels& kernels, Real spacing, Real h, Real volume, Real epsilon);

}  // namespace trevi

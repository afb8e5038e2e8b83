// The two smoothing kernels of the method (Müller 2003; report, section 2.2), for one pair.
//   Poly6  W(r)  = 315/(64 π h⁹) (h² − r²)³                     [1/m³]
//   Spiky  W(r)  = 15/(π h⁶) (h − r)³                           [1/m³]
//          ∇W(r) = −45/(π h⁶) (h − r)² r̂,  0 < r < h            [1/m⁴]
// The pair loops sum the dimensionless shapes (1 − u²)³, (1 − u)³ and (1 − u)² r̂, u = r/h; the factors here give them
// their units. The method takes densities from Poly6 and gradients from Spiky. With densities from Spiky, too
// (fluid.density_kernel), the shifts follow the constraint's own gradient.
#pragma once

#include <numbers>

#include "trevi/settings.hpp"

namespace trevi {

/// W(0) of Poly6, 1/m³: the factor of (1 − u²)³.
constexpr Real poly6_factor(Real h) { return 315 / (64 * std::numbers::pi * h * h * h); }
/// 1/m⁴: the factor of (1 − u)² r̂ in −∇W of Spiky.
constexpr Real spiky_gradient_factor(Real h) { return 45 / (std::numbers::pi * h * h * h * h); }

/// W(0) of Spiky, 1/m³: the factor of (1 − u)³.
constexpr Real spiky_factor(Real h) { return 15 / (std::numbers::pi * h * h * h); }
/// W(0) of the kernel that densities are taken from, 1/m³.
constexpr Real density_factor(Kernel kernel, Real h) {
  return kernel == Kernel::poly6 ? poly6_factor(h) : spiky_factor(h);
}

Real poly6(const Vec3& r, Real h);
Vec3 poly6_gradient(const Vec3& r, Real h);
Real spiky(const Vec3& r, Real h);
Vec3 spiky_gradient(const Vec3& r, Real h);  ///< zero at r = 0

Real density_kernel(Kernel kernel, const Vec3& r, Real h);
Vec3 density_gradient(Kernel kernel, const Vec3& r, Real h);

/// Sum of the kernel over a cubic lattice around one of its points, itself included, 1/m³; spacing and h in metres.
Real lattice_density_sum(Kernel kernel, Real spacing, Real h);
/// ½ Σ W6(r) x² over the same points, 1/m: Σ_j (v_j − v_i) W6(p_ij) is this times ∇²v, to the second order of v's
/// Taylor series (the first vanishes by symmetry, and x², y², z² have the same sums).
Real lattice_laplacian_moment(Real spacing, Real h);
/// Points of the lattice nearer than h, without the point itself.
int lattice_neighbours(Real spacing, Real h);

/// Largest eigenvalue of a Jacobi sweep with relaxation 1 on the endless lattice, `volume` the mass of a particle over
/// rest density, m³, and epsilon in 1/m². A wave e^{ik·x} in C leaves the sweep as 1 − relaxation mu(k) times itself,
///   mu(k) = V Σ_r ∇W sin(k·r) · V Σ_r ∇W_spiky sin(k·r) / (V² Σ_r |∇W_spiky|² + epsilon), W that of the density,
/// so a relaxation of 2/mu or more makes some wave grow. Only IEEE operations: the same bits on any processor.
Real lattice_jacobi_eigenvalue(Kernel kernel, Real spacing, Real h, Real volume, Real epsilon);

}  // namespace trevi

// The two smoothing kernels of the method (Müller 2003; report, section 2.2), for one pair.
//   Poly6  W(r)  = 315/(64 π h⁹) (h² − r²)³                     [1/m³]
//   Spiky  ∇W(r) = −45/(π h⁶) (h − r)² r̂,  0 < r < h            [1/m⁴]
// The pair loops sum the dimensionless shapes (1 − u²)³ and (1 − u)² r̂, u = r/h; the factors here give them their
// units.
#pragma once

#include <numbers>

#include "trevi/base/types.hpp"

namespace trevi {

/// W(0) of Poly6, 1/m³: the factor of (1 − u²)³.
constexpr Real poly6_factor(Real h) { return 315 / (64 * std::numbers::pi * h * h * h); }
/// 1/m⁴: the factor of (1 − u)² r̂ in −∇W of Spiky.
constexpr Real spiky_gradient_factor(Real h) { return 45 / (std::numbers::pi * h * h * h * h); }

Real poly6(const Vec3& r, Real h);
Vec3 spiky_gradient(const Vec3& r, Real h);  ///< zero at r = 0

/// Sum of Poly6 over a cubic lattice around one of its points, itself included, 1/m³; spacing and h in metres.
Real lattice_poly6_sum(Real spacing, Real h);
/// Points of the lattice nearer than h, without the point itself.
int lattice_neighbours(Real spacing, Real h);

}  // namespace trevi

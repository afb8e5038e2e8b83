// The density constraint of position based fluids (Macklin & Müller 2013, eqs. 1, 11, 12 and 14); units as in the
// scene:
//   rho_i = m Σ_j W(p_ij);  C_i = rho_i/rho0 − 1 (inequality: 0 where that is not above no_compression)
//   lambda_i = −C_i / (Σ_k |∇_k C_i|² + epsilon)
//   delta_i = (m/rho0) Σ_j (lambda_i + lambda_j + s_corr) ∇G(p_ij) [+ lambda_i times the gradient of the walls'
//   contribution]
// W is the kernel of fluid.density_kernel, G that of fluid.gradient_kernel, with which the gradients in lambda_i are
// formed, too. Not collective: the caller exchanges lambda, the scalar of the records, between the two loops.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "boundary/obstacles/obstacles.hpp"
#include "boundary/wall_density.hpp"
#include "fluid/constraint/walls_or_shifts.hpp"
#include "fluid/pairs/pair_sums.hpp"
#include "kernels/kernels.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// Physical constants of the constraint, already scaled to the resolution of the scene.
struct DensityModel {
  Real mass = 1;             ///< of a particle in kernel sums, kg
  Real rest_density = 1000;  ///< kg/m³
  Real h = 0.2;              ///< m
  Real epsilon = 1;          ///< 1/m²
  Constraint constraint = Constraint::equality;
  Kernels kernels = kernels_of(FluidSettings{});
};

/// Mass of the water that a particle represents, kg: rest_density · spacing³. Everything that is reported is based on
/// it.
Real water_mass(const FluidSettings& fluid);
/// The weight of a particle in kernel sums, kg: with mass "volume" that of its water; with "calibrated" such that the
/// interior of the lattice is at rest density. In two dimensions kg/m, for a layer one metre thick.
Real particle_mass(const FluidSettings& fluid);

/// Physical constants, with epsilon and artificial pressure scaled to the spacing: settings give their values at a
/// spacing of 0.1 m (inputs/README.md, Resolution). `settings` are those of resolved(), but the under-relaxation may be
/// missing.
DensityModel density_model(const Settings& settings);
std::optional<Tensile> tensile_of(const Settings& settings);

/// Compression that sums of this precision cannot distinguish from zero: water at rest on its lattice has a third of it
/// by rounding. An inequality treats anything smaller as zero, so that nothing is swept there.
template <class T>
inline constexpr Real no_compression = 32 * std::numeric_limits<T>::epsilon();

/// The multiplier lambda_i, m², of a constraint C_i that is above `least`, else 0; from gradient = ∇_i C_i, 1/m, and
/// neighbours = Σ_j |∇_j C_i|², 1/m².
Real lambda(const DensityModel& model, Real least, Real rho, const Vec3& gradient, Real neighbours);

template <class T>
class DensityConstraint {
 public:
  /// Without `walls`, a particle at a wall lacks the neighbours that water behind it would provide, as in the paper.
  DensityConstraint(const DensityModel& model, const std::optional<Tensile>& tensile,
                    std::optional<AnalyticWallDensity> walls, std::shared_ptr<Obstacles> obstacles = nullptr);

  const DensityModel& model() const { return model_; }
  /// Whether there is artificial pressure, which shifts particles without multipliers.
  bool is_tensile() const { return is_tensile_; }

  /// Writes rho_i, kg/m³, for the range; p and rho are arrays of all owned particles.
  void densities(const Pairs<T>& pairs, Range range, std::span<const Vec3> p, std::span<Real> rho) const;

  /// The output of lambdas(); arrays of all owned particles. use(here, multipliers) is called with lambda_i of a few
  /// particles at a time, by several threads at once. They cannot be written to the records there, because other
  /// threads load whole records.
  struct Lambdas {
    std::span<Real> rho;      ///< rho_i, kg/m³
    WallsOrShifts<T>& field;  ///< walls, for deltas()
    std::function<void(Range here, const T* multipliers)> use;
  };
  /// Finds rho_i and lambda_i for the range; p is an array of all owned particles.
  void lambdas(const Pairs<T>& pairs, Range range, std::span<const Vec3> p, const Lambdas& out) const;

  /// Writes delta_i in metres for the range, in place of the contributions of walls that lambdas() wrote there for the
  /// same positions, and records in the obstacles' ledger the part of walls and obstacles.
  void deltas(const Pairs<T>& pairs, Range range, std::span<const Vec3> p, WallsOrShifts<T>& field) const {
    sum_deltas(delta_loop_, pairs, range, p, field);
  }
  /// Writes delta_i in metres for the range, like deltas() without the tensile term: the effect of the multipliers
  /// alone on particles with these velocities, m/s, in the substep dt, s. Walls and obstacles stop what approaches
  /// them, and do no more.
  void deltas_in_flight(const Pairs<T>& pairs, Range range, std::span<const Vec3> p, std::span<const Vec3> velocity,
                        Real dt, WallsOrShifts<T>& field) const;

  /// Floating-point operations per pair in each loop, for the log.
  static constexpr double value_flops = 15, density_flops = 27, delta_flops = 24;

 private:
  using DeltaLoop = std::function<void(const Pairs<T>&, Range, Vec4<T>*)>;
  void sum_deltas(const DeltaLoop& delta_loop, const Pairs<T>& pairs, Range range, std::span<const Vec3> p,
                  WallsOrShifts<T>& field) const;
  template <class Wants, class Visit>
  void for_each_near_wall(Range range, std::span<const Vec3> p, const Wants& wants, const Visit& visit) const;
  void record_obstacles(Range range, const Packed<T>* records, std::span<const Vec3> p,
                        const WallsOrShifts<T>& field) const;

  DensityModel model_;
  Real density_factor_;   // m W(0), kg/m³: the density of a particle without neighbours
  Real gradient_factor_;  // m/rho0 times the slope factor of the gradient kernel, 1/m
  ConstraintLoops<T> loops_;
  DeltaLoop delta_loop_;
  bool is_tensile_;
  std::optional<AnalyticWallDensity> walls_;
  std::shared_ptr<Obstacles> obstacles_;
};

extern template class DensityConstraint<float>;
extern template class DensityConstraint<double>;

}  // namespace trevi

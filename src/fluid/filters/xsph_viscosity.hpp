// XSPH viscosity (Macklin & Müller 2013, eq. 17): v_i += c m Σ_j (v_j − v_i) W6(p_ij), with c given; or a step of
// explicit diffusion by the stress ρ nu (∇v + (∇v)ᵀ), with the kinematic viscosity nu, for any step and spacing:
//   v_i += nu dt L(v + (½ nu dt − ε) L(v))_i,
//   L(v)_i = Σ_j ½ (1/M_i + 1/M_j) F(p_ij) (v_j − v_i + ½ (∇v_i + ∇v_j)ᵀ (p_j − p_i)),
//   M_i = 1/(2 dimensions) Σ_j F(p_ij) p_ij²
// F is friction_weight(), with which water in layers has as much friction along them as across them; ∇v_i is that of
// the linear velocity field that best fits those of the neighbours, with the weights F.
//   Inside of water that conserves its volume the transposed gradients add up to zero, and L(v) is ∇²v + ε ∇⁴v with the
// ε of lattice_laplacian_truncation(): with the inner L a step is accurate to the second order of dt and the fourth of
// the spacing. The inner L is left out within reach of walls, because L does not know of water behind them. At a
// surface the gradients remove the stress that differences alone would leave there: a standing wave decays as Lamb says
// (Hydrodynamics, § 348), instead of half as fast (Colagrossi et al. 2011, Phys. Rev. E 84, 026705), and water that
// rotates as a whole has no friction. M_i is the second moment of the existing neighbours, per axis, so that a particle
// at a surface has the friction of its half of a neighbourhood. What one particle of a pair gets the other gives:
// momentum is conserved; angular momentum is conserved to 0.5 % of what friction could take. Walls by themselves would
// be surfaces: M_i has a share of the moment of what would be behind them, and viscous_walls.hpp adds the friction.
// Collective.
#pragma once

#include <array>
#include <optional>

#include "fluid/filters/velocity_filter.hpp"
#include "fluid/filters/viscous_walls.hpp"

namespace trevi {

template <class T>
class XsphViscosity : public VelocityFilter<T> {
 public:
  /// `c` in m³/kg, a fraction of each step.
  XsphViscosity(Real c, const DensityModel& model);
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;

 private:
  Event event_{"XsphViscosity"};
  FilterLoops<T> loops_;
  Real factor_;
};

/// The longest step, s: 2 over the largest eigenvalue of the sums, from which on explicit diffusion is unstable.
Real longest_viscous_step(Real nu, const PointLattice& lattice, Real h);

template <class T>
class KinematicViscosity : public VelocityFilter<T> {
 public:
  /// `nu` in m²/s; without `walls` the water ends at a wall with a surface.
  KinematicViscosity(Real nu, const PointLattice& lattice, Real h, std::optional<ViscousWalls> walls = {});
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;

 private:
  using Gradients = std::array<Borrowed<Vec4<T>>, 3>;
  // Calls use(i, Laplacian of the velocities at particle i, 1/(m s)). Uses the memory of the gradients.
  template <class Use>
  void for_each_laplacian(Neighbourhood<T>& near, const std::vector<Vec3>& positions, const Vec4<T>* velocities,
                          Gradients& gradients, const Use& use) const;
  void fit(Neighbourhood<T>& near, const Vec4<T>* velocities, const std::vector<Vec3>& positions,
           const std::array<Vec4<T>*, 3>& gradients) const;

  Event event_{"XsphViscosity"};
  FrictionLoops<T> loops_;
  std::optional<ViscousWalls> walls_;
  Real moment_, per_moment_, deficient_, nu_, truncation_;  // m², 1, 1, m²/s, m²
};

extern template class XsphViscosity<float>;
extern template class XsphViscosity<double>;
extern template class KinematicViscosity<float>;
extern template class KinematicViscosity<double>;

}  // namespace trevi

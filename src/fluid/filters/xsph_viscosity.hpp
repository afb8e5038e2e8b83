// XSPH viscosity (Macklin & Müller 2013, eq. 17): v_i += c m Σ_j (v_j − v_i) W6(p_ij), with c given; or a step of
// explicit diffusion, nu dt ∇²v with the kinematic viscosity nu, for any step and spacing:
//   v_i += nu dt Σ_j ½ (1/M_i + 1/M_j) (v_j − v_i) F(p_ij),  M_i = 1/6 Σ_j F(p_ij) p_ij², 1/4 in two dimensions
// F is friction_weight(). M_i is the second moment of the neighbours that the particle has, per axis: on the lattice
// that of the lattice (lattice_laplacian_moment), in water without order nearly as much. As pairs take the mean of 1/M
// they keep momentum, and the friction of a uniform shear is right in the mean of all directions, wherever the
// particles are; with F that of water in layers is the same along and across them.
//   Neighbours must not stand in for those that are missing at walls and surfaces: where M_i is below
// min_second_moment() the lattice's takes its place. Walls are frictionless: a vortex between walls a distance L
// apart keeps its rate to 5 % at 10 across (tests/fluid/test_viscosity.cpp). Collective.
#pragma once

#include "fluid/filters/velocity_filter.hpp"

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

/// The longest step, s, in which this viscosity takes no velocity past the mean of its neighbours, for a particle that
/// has all the neighbours of the lattice but the least M_i. Explicit diffusion is unstable from about twice that.
Real longest_viscous_step(Real nu, const PointLattice& lattice, Real h);

/// The M_i, over that of the lattice, below which neighbours are missing: that of the lattice or of water without
/// order, π² h⁵/(128 s³), or π h⁴/(48 s²) in the plane, whichever is less, without the contribution of three
/// neighbours, two in the plane, which is what M_i scatters by in flowing water.
Real min_second_moment(const PointLattice& lattice, Real h);

template <class T>
class KinematicViscosity : public VelocityFilter<T> {
 public:
  /// `nu` in m²/s.
  KinematicViscosity(Real nu, const PointLattice& lattice, Real h);
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;

 private:
  void weigh(const Pairs<T>& pairs, Range all, Vec4<T>* velocities) const;

  Event event_{"XsphViscosity"};
  FrictionLoops<T> loops_;
  Real per_second_;
  T moment_factor_;  // makes M_i/M_lattice of the sum
  T least_;
};

extern template class XsphViscosity<float>;
extern template class XsphViscosity<double>;
extern template class KinematicViscosity<float>;
extern template class KinematicViscosity<double>;

}  // namespace trevi

// XSPH viscosity (Macklin & Müller 2013, eq. 17): v_i += c m Σ_j (v_j − v_i) W6(p_ij), with c given or computed from
// the kinematic viscosity nu. On the lattice the sum is M ∇²v (lattice_laplacian_moment), so that c m = nu dt / M makes
// it nu dt ∇²v, a step of explicit diffusion, for any step and spacing. Walls are frictionless. Neighbours that would
// be behind a wall are missing, so that a vortex between walls a distance L apart is damped less by a share of 2.5 s/L,
// s being the spacing (tests/mpi/test_viscosity.cpp). Collective.
#pragma once

#include "fluid/velocity_filter.hpp"

namespace trevi {

/// The factor c m of the sum: a constant, plus a part in proportion to the length of the step.
struct XsphFactor {
  Real each_step = 0;   ///< m³
  Real per_second = 0;  ///< m³/s
  Real of_step(Real dt) const { return each_step + per_second * dt; }
};

/// The factor for c, m³/kg: the same in every step.
XsphFactor xsph_of_share(Real c, const DensityModel& model);
/// The factor for the kinematic viscosity nu, m²/s.
XsphFactor xsph_of_viscosity(Real nu, Real spacing, Real h);
/// The longest step, s, in which this viscosity takes no velocity past the mean of its neighbours, i.e. c rho0 ≤ 1
/// where the lattice is at rest density. Explicit diffusion is unstable from about twice that.
Real longest_viscous_step(Real nu, Real spacing, Real h);

template <class T>
class XsphViscosity : public VelocityFilter<T> {
 public:
  XsphViscosity(const XsphFactor& factor, Real h, std::shared_ptr<VelocityField<T>> velocity);
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;
  std::size_t bytes() const override { return share_of(velocity_); }

 private:
  Event event_{"XsphViscosity"};
  FilterLoops<T> loops_;
  XsphFactor factor_;
  Real kernel_factor_;  // W6(0), 1/m³
  std::shared_ptr<VelocityField<T>> velocity_;
};

extern template class XsphViscosity<float>;
extern template class XsphViscosity<double>;

}  // namespace trevi

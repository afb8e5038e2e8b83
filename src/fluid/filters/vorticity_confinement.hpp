// Vorticity confinement (Macklin & Müller 2013, eqs. 15 and 16):
//   omega_i = m Σ_j (v_j − v_i) × ∇_{p_j}W_spiky,  eta_i = (m/rho0) Σ_j (|omega_j| − |omega_i|) ∇_{p_i}W_spiky
//   v_i += dt epsilon (eta_i/|eta_i| × omega_i), nothing where |eta_i| = 0
// Collective.
#pragma once

#include "fluid/filters/velocity_filter.hpp"

namespace trevi {

template <class T>
class VorticityConfinement : public VelocityFilter<T> {
 public:
  VorticityConfinement(const DensityModel& model, Real epsilon);
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;

 private:
  Borrowed<Vec4<T>> compute_omega(Neighbourhood<T>& near, const std::vector<Vec3>& velocity);

  Event event_{"Vorticity"};
  FilterLoops<T> loops_;
  Real omega_factor_;  // m times the slope factor, kg/m⁴: turns the dimensionless sum into omega
  Real epsilon_;
};

extern template class VorticityConfinement<float>;
extern template class VorticityConfinement<double>;

}  // namespace trevi

// What smooths or stirs velocities after the density solve, on the frozen neighbour list (report, section 2.3):
//   vorticity confinement   omega_i = m Σ_j (v_j − v_i) × ∇_{p_j}W_spiky,  eta_i = (m/rho0) Σ_j (|omega_j| − |omega_i|)
//   ∇_{p_i}W_spiky
//                           v_i += dt epsilon (eta_i/|eta_i| × omega_i), nothing where |eta_i| = 0
//   XSPH viscosity          v_i += c m Σ_j (v_j − v_i) W6(p_ij), c given, or from the kinematic viscosity nu:
//                           on the lattice the sum is M ∇²v (lattice_laplacian_moment), so c m = nu dt / M makes it
//                           nu dt ∇²v, a step of explicit diffusion, whatever the step and the spacing. Walls are
//                           frictionless; neighbours that they hide are missing, so that a vortex between walls L
//                           apart lacks 2.5 s/L of the damping, s the spacing (tests/mpi/test_viscosity.cpp)
// A filter reads only the velocities the one before left, never half-updated ones. It refreshes the ghosts it reads and
// uses the scalar of the records as it likes. Collective.
#pragma once

#include <memory>

#include "domain/neighbourhood.hpp"
#include "fluid/density.hpp"

namespace trevi {

template <class T>
class VelocityFilter {
 public:
  virtual ~VelocityFilter() = default;
  virtual void apply(Neighbourhood<T>& near, Particles& particles, Real dt) = 0;
  virtual std::size_t bytes() const = 0;
};

/// Velocities of all particles, ghosts included, as the pair loops read them. Filters share one: each refreshes it.
template <class T>
class VelocityField {
 public:
  /// Collective.
  const Quad<T>* refresh(Neighbourhood<T>& near, const std::vector<Vec3>& velocity);
  std::size_t bytes() const { return quads_.capacity() * sizeof(Quad<T>); }

 private:
  std::vector<Quad<T>> quads_;
};

/// What one of the filters that share a field answers for.
template <class T>
std::size_t share_of(const std::shared_ptr<VelocityField<T>>& field) {
  return field->bytes() / static_cast<std::size_t>(field.use_count());
}

template <class T>
class VorticityConfinement : public VelocityFilter<T> {
 public:
  VorticityConfinement(const DensityModel& model, Real epsilon, std::shared_ptr<VelocityField<T>> velocity);
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;
  std::size_t bytes() const override { return omega_.capacity() * sizeof(Quad<T>) + share_of(velocity_); }

 private:
  void compute_omega(Neighbourhood<T>& near, const std::vector<Vec3>& velocity);

  Event event_{"Vorticity"};
  FilterLoops<T> loops_;
  Real omega_factor_;  // kg/m⁴ from the dimensionless sum
  Real epsilon_;
  std::shared_ptr<VelocityField<T>> velocity_;
  std::vector<Quad<T>> omega_;
};

/// What the sum of XSPH is multiplied by, m³: the same in every step, or in proportion to its length.
struct XsphFactor {
  Real each_step = 0;   ///< m³
  Real per_second = 0;  ///< m³/s
  Real of_step(Real dt) const { return each_step + per_second * dt; }
};

/// c m, the share that a step takes; c in m³/kg.
XsphFactor xsph_of_share(Real c, const DensityModel& model);
/// That of the kinematic viscosity nu, m²/s.
XsphFactor xsph_of_viscosity(Real nu, Real spacing, Real h);
/// The longest step, s, in which this viscosity takes no velocity past the mean of its neighbours: c rho0 ≤ 1 where the
/// lattice is at rest density. Explicit diffusion grows from about twice that.
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

extern template class VorticityConfinement<float>;
extern template class VorticityConfinement<double>;
extern template class XsphViscosity<float>;
extern template class XsphViscosity<double>;

}  // namespace trevi

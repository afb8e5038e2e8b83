// The energy supplied to the water from outside other than by gravity, in J since the start of a run: by the pumps of
// fountains and by nozzles, by the water that inlets bring and drains take, and by moving obstacles. Any further gain
// of a run is due to the method itself (io/tables/energy_rise.hpp). Sums over particles are integers, so that they
// depend neither on the order nor on the number of ranks. Collective: end_step().
#pragma once

#include <cstdint>
#include <functional>

#include "projection/openings.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"

namespace trevi {

class SuppliedEnergy {
 public:
  /// `mass`: of a particle, kg. `corner`: origin of potential energies, as for those of the water (diagnostics).
  /// `before`: that of the run that is continued, J.
  SuppliedEnergy(MPI_Comm comm, Real mass, const Vec3& gravity, const Vec3& corner, Real before)
      : comm_(comm), mass_(mass), gravity_(gravity), corner_(corner), joules_(before) {}

  /// Measures by how much `work` changes the kinetic and potential energy of this rank's particles, with their
  /// velocities `ago` seconds earlier, before gravity had acted for that time.
  void measure(const Particles& particles, const std::function<void()>& work, Real ago = 0);
  /// Adds energy that this rank's water was given otherwise, in units per particle.
  void add_measured(std::int64_t units) { measured_ += units; }
  static constexpr Real unit = Openings::work_unit;  ///< of the energy per kilogram, m²/s²
  /// Adds energy that is the same on all ranks.
  void add(Real joules) { joules_ += joules; }
  /// Adds what all ranks have measured in a step.
  void end_step();

  Real joules() const { return joules_; }

 private:
  std::int64_t units(const Particles& particles, const Vec3& more) const;

  MPI_Comm comm_;
  Real mass_;
  Vec3 gravity_, corner_;
  Real joules_;
  std::int64_t measured_ = 0;
};

}  // namespace trevi

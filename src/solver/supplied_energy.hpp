// The energy that the water is given from outside beside gravity, J since the start of a run: by the pumps of fountains
// and by nozzles, by what inlets bring and drains take, and by obstacles that move. What a run gains beyond that is the
// method's own (io/tables/energy_rise.hpp). Sums over particles are integers, so that neither their order nor the
// number of ranks is seen in them. Collective: end_step().
#pragma once

#include <cstdint>
#include <functional>

#include "projection/openings.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"

namespace trevi {

class SuppliedEnergy {
 public:
  /// Of particles of that mass, kg. `corner`: from which potential energies count, as those of the water (diagnostics).
  /// `before`: J, of the run that goes on.
  SuppliedEnergy(MPI_Comm comm, Real mass, const Vec3& gravity, const Vec3& corner, Real before)
      : comm_(comm), mass_(mass), gravity_(gravity), corner_(corner), joules_(before) {}

  /// Counts by how much `work` changes the kinetic and potential energy of this rank's particles, by their velocities
  /// so many seconds ago, when gravity had given less.
  void measure(const Particles& particles, const std::function<void()>& work, Real ago = 0);
  /// What this rank's water was given beside, in units of a particle.
  void add_measured(std::int64_t units) { measured_ += units; }
  static constexpr Real unit = Openings::work_unit;  ///< of the energy of a kilogram, m²/s²
  /// The same on all ranks.
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

// Checks that make_solver() makes before it builds anything. The scene reader has made the same checks, and names the
// line at fault; a program may pass anything. Each error names the member of the settings and its rule.
#pragma once

#include "trevi/particles.hpp"
#include "trevi/settings.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// The settings with a value for every derived setting, and a periodic box that fits its cells. Throws InputError on
/// any rank for invalid settings. Not collective; the same on all ranks for the same settings.
Settings checked_and_resolved(const Settings& settings);

/// Throw InputError on all ranks alike for fields of different lengths, a position outside the box, numbers that are
/// not finite, ids that are negative or not unique, and extras that are null. Collective.
void check_particles(MPI_Comm comm, const Settings& settings, const Particles& particles);
void check_extras(MPI_Comm comm, const SolverExtras& extras);

/// Whether two obstacles are the same solid in the same place. Obstacles add up, so it would count twice.
bool is_same_solid(const ObstacleSettings& one, const ObstacleSettings& other);

}  // namespace trevi

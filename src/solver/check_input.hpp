// What make_solver() refuses before it builds anything. The reader of a scene has checked the same with the line at
// fault; a program may hand over anything. Each refusal names the member of the settings and its rule.
#pragma once

#include "trevi/particles.hpp"
#include "trevi/settings.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// Settings with a value for every derived one, and a periodic box that fits its cells. InputError on any rank for
/// settings that cannot be. Not collective; the same on all ranks for the same settings.
Settings checked_and_resolved(const Settings& settings);

/// InputError on all ranks alike for fields of different lengths, a place outside the box, numbers that are not finite,
/// ids that are negative or there twice, and extras that are null. Collective.
void check_particles(MPI_Comm comm, const Settings& settings, const Particles& particles);
void check_extras(MPI_Comm comm, const SolverExtras& extras);

/// Whether two obstacles are the same solid in the same place. The solids of obstacles add up, so it would count twice.
bool is_same_solid(const ObstacleSettings& one, const ObstacleSettings& other);

}  // namespace trevi

// The stability envelope: settings with which the stress study found the solver stable
// (postprocess/results/stability.md). Outside of it a run is not refused, because short or damped runs may well be
// fine, but this is reported at its start and in run.json. Not collective.
#pragma once

#include <string>
#include <vector>

#include "io/tables/energy_rise.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// One sentence with the remedy for each setting outside the envelope; none for a scene without gravity.
std::vector<std::string> envelope_warnings(const Scene& scene);

/// The warnings at the start of a run: one sentence for each feature whose results depend on the processor or the
/// number of ranks, then envelope_warnings().
std::vector<std::string> start_warnings(const Scene& scene);

/// The warning at the end of a run whose energy rose by this fraction (EnergyRise): one sentence with remedies above
/// 0.5 %, the criterion of the stability study, otherwise none.
std::vector<std::string> energy_warnings(const Scene& scene, const EnergyRise& energy);

/// The warning about crushed water (DensitySettings::crush_limit), when that begins and at the end.
std::vector<std::string> crush_warnings(const Scene& scene, const Solver::Counters::Compression& seen);

/// A warning for each inlet that produced less than 98 % of what was requested, and at least a layer less: how much,
/// and why. An inlet that waits for what drains take works as intended. `flow` may be null.
std::vector<std::string> flow_warnings(const Scene& scene, const FlowState* flow);

}  // namespace trevi

// The stability envelope: settings under which the stress study found the solver stable
// (postprocess/results/stability.md). Outside of it a run is not refused, as short or damped runs may well be fine, but
// it says so at its start and in run.json. Not collective.
#pragma once

#include <string>
#include <vector>

#include "io/tables/energy_rise.hpp"
#include "trevi/scene.hpp"
#include "trevi/solver.hpp"

namespace trevi {

/// A sentence with the remedy for each setting outside the envelope; none for a scene without gravity.
std::vector<std::string> envelope_warnings(const Scene& scene);

/// What is said at the start of a run: one sentence for each feature whose results depend on the processor or the
/// number of ranks, then envelope_warnings().
std::vector<std::string> start_warnings(const Scene& scene);

/// What is said at the end of a run whose energy rose by this fraction (EnergyRise): one sentence with
/// remedies above 0.5 %, the mark of the stability study, else none.
std::vector<std::string> energy_warnings(const Scene& scene, const EnergyRise& energy);

/// What is said of water that was crushed (DensitySettings::crush_limit), when that begins and at the end.
std::vector<std::string> crush_warnings(const Scene& scene, const Solver::Counters::Compression& seen);

/// What is said of each inlet that made less than 98 % of what was asked of it, and at least a layer less: how much,
/// and why. One that waits for what drains take is as it should be. `flow` may be null.
std::vector<std::string> flow_warnings(const Scene& scene, const FlowState* flow);

}  // namespace trevi

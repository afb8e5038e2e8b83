// The stability envelope: settings under which the stress study found the solver stable
// (postprocess/results/stability.md). Outside of it a run is not refused, as short or damped runs may well be fine, but
// it says so at its start and in run.json. Not collective.
#pragma once

#include <string>
#include <vector>

#include "trevi/app/scene.hpp"

namespace trevi {

/// A sentence with the remedy for each setting outside the envelope; none for a scene without gravity.
std::vector<std::string> envelope_warnings(const Scene& scene);

}  // namespace trevi

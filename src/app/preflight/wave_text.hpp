// Theory of the waves that a scene's wavemakers make, for a dry run, and warnings, also for a run. Not collective.
#pragma once

#include <string>
#include <vector>

#include "trevi/scene.hpp"

namespace trevi {

/// One line for the waves and one for the paddle of each wavemaker, one for each damping zone; empty if there are none.
std::string wave_text(const Scene& scene);

/// Waves that the spacing does not resolve, that are too steep, or that have no damping zone before the far end.
std::vector<std::string> wave_warnings(const Scene& scene);

}  // namespace trevi

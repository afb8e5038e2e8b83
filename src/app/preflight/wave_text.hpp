// What theory says of the waves that a scene's wavemakers make, for a dry run, and warnings, for a run, too. Not
// collective.
#pragma once

#include <string>
#include <vector>

#include "trevi/scene.hpp"

namespace trevi {

/// A line for the waves and one for the paddle of each wavemaker, one for each damping zone; empty without any.
std::string wave_text(const Scene& scene);

/// Waves that the spacing does not resolve, are too steep, or have no zone before the far end.
std::vector<std::string> wave_warnings(const Scene& scene);

}  // namespace trevi

// Obstacles in a box that is periodic along some axes. Not collective.
#pragma once

#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// An obstacle has no images beyond the ends of a periodic axis. It must therefore have no effect there, or be the same
/// at both: a box or a cylinder along the axis through both ends. Returns what is wrong with it and the remedy; empty
/// if it fits.
std::string why_not_periodic(const ObstacleSettings& obstacle, const Settings& settings);

}  // namespace trevi

// Obstacles in a box that is periodic along some axes. Not collective.
#pragma once

#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// An obstacle has no images beyond the ends of a periodic axis, so that it must not be felt there, or be the same
/// there: a box or a cylinder along the axis through both ends. What is wrong with it and the remedy; empty where it
/// fits.
std::string why_not_periodic(const ObstacleSettings& obstacle, const Settings& settings);

}  // namespace trevi

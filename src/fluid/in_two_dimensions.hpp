// Scenes in two dimensions ([domain] dimensions = 2): one layer of particles in the plane y = 0, which never leave it.
// The domain is one spacing thick, its cells are as thick, and it has no walls along y; kernels are normalised in the
// plane (kernels.hpp). Nothing else of a step knows of it: with all places and velocities in the plane, every sum and
// every solve is that of the plane. Not collective.
#pragma once

#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// Puts what the settings place in space into the plane, where they are in two dimensions: domain and drains have their
/// extent along y, openings the edge of one spacing, obstacles go on along y. It is what resolved() does first; done
/// twice it is as done once.
void lay_in_plane(Settings& settings);
/// One of these alone.
void lay_in_plane(ObstacleSettings& obstacle, const FluidSettings& fluid);
void lay_in_plane(InletSettings& inlet, const FluidSettings& fluid);
void lay_in_plane(DrainSettings& drain, const FluidSettings& fluid);
void lay_in_plane(DampingSettings& zone, const FluidSettings& fluid);
void lay_in_plane(GaugeSettings& gauge, const FluidSettings& fluid);
void lay_in_plane(FrameSetSettings& frames, const FluidSettings& fluid);

/// Why these cannot be in a scene of two dimensions, with a remedy; empty where they can.
std::string why_not_in_plane(const ObstacleSettings& obstacle);
/// Of a direction, a velocity or an acceleration, and of a rotation.
std::string why_not_along_plane(const Vec3& vector);
std::string why_not_about_y(const Vec3& rotation);

}  // namespace trevi

// Scenes in two dimensions ([domain] dimensions = 2): one layer of particles in the plane y = 0, which never leave it.
// The domain is one spacing thick, its cells are as thick, and it has no walls along y; kernels are normalised in the
// plane (kernels.hpp). No other part of a step takes account of this: with all positions and velocities in the plane,
// every sum and every solve is that of the plane. Not collective.
#pragma once

#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// Moves what the settings define in space into the plane, if they are in two dimensions: domain and drains get their
/// extent along y, openings an edge of one spacing, and solids extend without end along y. A body keeps its degrees of
/// freedom in the plane, which are x, z and pitch, and has the mass of the layer. resolved() does this first; doing it
/// twice has the same result as once.
void lay_in_plane(Settings& settings);
/// The same for one of these alone.
void lay_in_plane(ObstacleSettings& obstacle, const FluidSettings& fluid);
void lay_in_plane(BodySettings& body, const FluidSettings& fluid);
void lay_in_plane(InletSettings& inlet, const FluidSettings& fluid);
void lay_in_plane(DrainSettings& drain, const FluidSettings& fluid);
void lay_in_plane(DampingSettings& zone, const FluidSettings& fluid);
void lay_in_plane(GaugeSettings& gauge, const FluidSettings& fluid);
void lay_in_plane(FrameSetSettings& frames, const FluidSettings& fluid);

/// Why these cannot be in a two-dimensional scene, with a remedy; empty if they can.
std::string why_not_in_plane(const ObstacleSettings& obstacle);
/// For a direction, a velocity or an acceleration, and for a rotation.
std::string why_not_along_plane(const Vec3& vector);
std::string why_not_about_y(const Vec3& rotation);

}  // namespace trevi

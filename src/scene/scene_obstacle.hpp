// The table [[obstacle]] of a scene. Nothing is read but the scene: meshes and tables of motion are read by
// obstacle_files.hpp.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// m/s along each axis, as for inlets, and rad/s about it.
inline constexpr Real fastest_obstacle = 1e4;

/// Whether an obstacle may be there: not farther from the origin than a million km, along any axis.
inline bool is_place(const Vec3& center) { return (center.array().abs() <= 1e9).all(); }

void read_obstacle(Section& section, Scene& scene);

/// The parts of the table that [[body]] shares. Type, lengths and position; false if the type is not known.
bool read_solid(Section& section, const Scene& scene, ObstacleSettings& obstacle);
void read_velocities(Section& section, ObstacleSettings& obstacle);
/// Restitution and friction.
void read_surface(Section& section, const Scene& scene, ObstacleSettings& obstacle);

}  // namespace trevi

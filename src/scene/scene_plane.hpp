// Scenes in two dimensions: [domain] dimensions, and what a scene cannot contain in this case. Vectors are [x, z], or
// [x, y, z] as in three dimensions: the y of positions and sizes is not used, that of directions and velocities must be
// 0. Not collective.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// To be called first, because it changes what vectors are.
void read_dimensions(Section& domain, Scene& scene);
/// Checks the box, when its spacing is known.
void check_plane(Section& domain, Scene& scene);

/// Rules of two dimensions for the value of a key; in three dimensions there are none.
void check_along_plane(Section& section, const Scene& scene, const char* key, const Vec3& vector);
void check_about_y(Section& section, const Scene& scene, const char* key, const Vec3& rotation);
void check_in_plane(Section& section, const Scene& scene, const ObstacleSettings& obstacle);
/// Makes a block of water a layer.
void lay_in_plane(Section& section, const Scene& scene, ParticleSource& block);

}  // namespace trevi

// Properties of a scene that are allowed but hardly ever intended, as in a beginner's scene: reported at the start of a
// run and by a dry run. A scene is never refused for them. Not collective.
#pragma once

#include <string>
#include <vector>

#include "trevi/scene.hpp"

namespace trevi {

/// The highest speed that a particle may reach: pumped, thrown, or fallen from the top of the water, m/s.
Real expected_speed(const Scene& scene);

/// The longest time step at that speed, s.
Real longest_step(const Scene& scene, Real cfl);

/// One sentence with the remedy for each.
std::vector<std::string> scene_advice(const Scene& scene);

/// The bounds of an obstacle's surface at the start, m.
Box place_of(const ObstacleSettings& obstacle);

/// The volume of the box without its obstacles at the start, m³; with obstacles it is sampled, to one per cent.
Real open_volume(const Scene& scene);

/// If there is more water than space: one sentence; otherwise none.
std::vector<std::string> volume_warnings(const Scene& scene, double particles);

}  // namespace trevi

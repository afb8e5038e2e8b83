// What a beginner's scene has that is allowed, and hardly ever meant: said at the start of a run and by a dry run. A
// scene is never refused for it. Not collective.
#pragma once

#include <string>
#include <vector>

#include "trevi/scene.hpp"

namespace trevi {

/// The fastest a particle may get: pumped, thrown, or fallen from the top of the water, m/s.
Real expected_speed(const Scene& scene);

/// The longest step at that speed, s.
Real longest_step(const Scene& scene, Real cfl);

/// A sentence with the remedy for each.
std::vector<std::string> scene_advice(const Scene& scene);

/// The bounds of an obstacle's surface at the start, m.
Box place_of(const ObstacleSettings& obstacle);

/// What the box holds beside its obstacles at the start, m³; with obstacles by samples, to a per cent.
Real open_volume(const Scene& scene);

/// More water than space: one sentence, or none.
std::vector<std::string> volume_warnings(const Scene& scene, double particles);

}  // namespace trevi

// The tables [[inlet]] and [[drain]] of a scene.
#pragma once

#include "scene/free_places.hpp"
#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// Adds them to the scene, whose box, spacing and fountains have already been read.
void read_inlet(Section& section, Scene& scene, const KnownGood& known);
void read_drain(Section& section, Scene& scene, const KnownGood& known);

/// Rules between the tables, once all have been read.
void check_flow(Section& root, const Scene& scene);

/// Checks that no opening is in an obstacle at the start, where its water would be made inside the solid; once the
/// obstacles' files have been read.
void check_openings(const Scene& scene, const FreePlaces& places);
/// The same for solids in the boxes of drains in walls.
void check_drains(const Scene& scene, const FreePlaces& places);

}  // namespace trevi

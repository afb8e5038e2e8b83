// The key [domain] periodic of a scene.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

void read_periodic(Section& domain, Scene& scene);

/// The rules for it, once the box, the kernel radius and gravity are known and resolved.
void check_periodic(Section& domain, const Scene& scene);

/// Checks that obstacles and inlets need no images beyond the ends; once the obstacles' files have been read.
void check_no_images(const Scene& scene);

}  // namespace trevi

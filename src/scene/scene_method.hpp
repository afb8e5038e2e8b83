// The tables of a scene that determine how the water is moved: gravity, density, walls, artificial pressure and
// vorticity. Each is independent, because none of their rules refers to another table.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// A number whose absence means that it follows from others.
void read_derived(Section& section, const Key& key, Derived<Real>& target, const Interval& range);

/// `density` is the table [density] of `root`, whose preset has been read.
void read_method(Section& root, Section& density, Scene& scene);

}  // namespace trevi

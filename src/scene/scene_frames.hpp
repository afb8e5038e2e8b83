// The tables [output.vtu], [output.vtkhdf] and [[output.frames]] of a scene, and the keys of schedules.
#pragma once

#include "scene/scene_reader.hpp"
#include "trevi/scene.hpp"

namespace trevi {

Schedule read_schedule(Section& section);

std::optional<FrameSettings> read_frames(Section frames, bool has_colour);

/// Reads all of them, after the box has been read.
void read_frame_sets(Section& output, Scene& scene, bool has_colour);

}  // namespace trevi

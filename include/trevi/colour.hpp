// The quantities that the colour of a particle may show. The list serves colour.by of a scene, the frames that a run
// writes, and --colour of trevi-view. Invariant: colour_list[k].colour is the k-th of the enumeration. Plain data.
#pragma once

#include <array>

namespace trevi {

enum class Colour { rainbow, rainbow_x, rainbow_height, rainbow_id, speed, blue, density, rank };

struct ColourEntry {
  Colour colour;
  const char* name;
  bool in_scenes, in_viewer;
};

inline constexpr std::array<ColourEntry, 8> colour_list = {{
    {Colour::rainbow, "rainbow", false, true},  // in the viewer: the colours of the run, or by id
    {Colour::rainbow_x, "rainbow_x", true, false},
    {Colour::rainbow_height, "rainbow_height", true, false},
    {Colour::rainbow_id, "rainbow_id", true, false},
    {Colour::speed, "speed", true, true},
    {Colour::blue, "blue", true, false},
    {Colour::density, "density", false, true},
    {Colour::rank, "rank", false, true},
}};

}  // namespace trevi

// Colours of a picture's particles, three bytes each. Grey if a frame does not contain what is asked for.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/frames/viewed_frame.hpp"
#include "trevi/colour.hpp"

namespace trevi {

/// The next colour of colour_list in the viewer; after the last one it starts again.
Colour next_colour(Colour colour);

/// What the ends of a scale represent: kept over frames, so that a colour means the same in all of them.
struct ColourRange {
  double fastest = 1;          ///< m/s; the fastest particle so far
  double rest_density = 1000;  ///< kg/m³, white; blue and red are 10 % below and above
};

/// Fills `rgb` (three bytes per particle) and widens the range if necessary.
void colour_particles(const ViewedFrame& frame, Colour by, ColourRange& range, std::vector<unsigned char>& rgb);

/// What the colours mean, for the status line: "speed 0 to 12 m/s".
std::string legend(const ViewedFrame& frame, Colour by, const ColourRange& range);

}  // namespace trevi

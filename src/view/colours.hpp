// Colours of a picture's particles, three bytes each. Grey where a frame does not hold what is asked for.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "io/frames/viewed_frame.hpp"
#include "trevi/colour.hpp"

namespace trevi {

/// The colour of colour_list that follows in the viewer, which begins again after the last.
Colour next_colour(Colour colour);

/// What the ends of a scale stand for: kept over frames, so that a colour means the same in all of them.
struct ColourRange {
  double fastest = 1;          ///< m/s; the fastest particle so far
  double rest_density = 1000;  ///< kg/m³, white; blue and red are 10 % below and above
};

/// Fills `rgb` (three bytes a particle) and widens the range where need be.
void colour_particles(const ViewedFrame& frame, Colour by, ColourRange& range, std::vector<unsigned char>& rgb);

/// What the colours mean, for the status line: "speed 0 to 12 m/s".
std::string legend(const ViewedFrame& frame, Colour by, const ColourRange& range);

}  // namespace trevi

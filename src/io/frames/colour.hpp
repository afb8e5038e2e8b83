// Colours of particles as three bytes, for pictures only: nothing in the simulation reads them. The rainbow runs over
// the hues from red (0) to violet (1) at full saturation and brightness. Rank-local, but all ranks call colours_of()
// alike, because it is logged. One rule for all frame formats, so that VTU and VTKHDF show the same colours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "trevi/colour.hpp"
#include "trevi/particles.hpp"

namespace trevi {

using Rgb = std::array<std::uint8_t, 3>;

/// The scale of the colours; fixed for a run, so that a colour means the same in all frames.
struct ColourScale {
  Colour by = Colour::blue;
  Real bottom = 0, top = 1;  ///< z of the domain, m: rainbow_height
  Real speed_max = 10;       ///< m/s: shown red; slow is violet
  GlobalId total = 1;        ///< particles of all ranks: rainbow_id
};

/// Red at 0 to violet at 1; values outside are clamped, nan is red.
Rgb rainbow(Real position);

/// Colour of particle i. rainbow_x needs Particles::hue.
Rgb colour_of(const ColourScale& scale, const Particles& particles, LocalId i);

/// Colours of all particles of this rank, same order.
std::vector<Rgb> colours_of(const ColourScale& scale, const Particles& particles);

}  // namespace trevi

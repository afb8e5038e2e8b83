#include "io/frames/colour.hpp"

#include <algorithm>
#include <cmath>

#include "base/threads.hpp"
#include "parallel/log.hpp"

namespace trevi {

namespace {

constexpr Rgb water{40, 120, 220};
constexpr Real violet = 0.75;  ///< hue of the rainbow's end, as a fraction of the colour circle

std::uint8_t byte_of(Real value) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))); }

Real part_of(Real value, Real from, Real to) { return to > from ? (value - from) / (to - from) : 0; }

Real id_part(GlobalId id, GlobalId total) {
  const GlobalId n = std::max<GlobalId>(1, total);
  const GlobalId within = (id % n + n) % n;  // ids of a file may be negative
  return static_cast<Real>(within) / static_cast<Real>(n);
}

}  // namespace

Rgb rainbow(Real position) {
  const Real hue = 6 * violet * (position > 0 ? std::min<Real>(position, 1) : 0);
  // Full saturation and brightness: each channel is a trapezium over the circle of six sectors.
  const Real red = std::abs(hue - 3) - 1;
  const Real green = 2 - std::abs(hue - 2);
  const Real blue = 2 - std::abs(hue - 4);
  return {byte_of(red), byte_of(green), byte_of(blue)};
}

Rgb colour_of(const ColourScale& scale, const Particles& particles, LocalId i) {
  const auto k = static_cast<std::size_t>(i);
  switch (scale.by) {
    case Colour::rainbow_x:
      return rainbow(static_cast<Real>(particles.hue[k]));
    case Colour::rainbow_height:
      return rainbow(part_of(particles.position[k].z(), scale.bottom, scale.top));
    case Colour::rainbow_id:
      return rainbow(id_part(particles.id[k], scale.total));
    case Colour::speed:
      return rainbow(1 - part_of(particles.velocity[k].norm(), 0, scale.speed_max));
    default:
      return water;
  }
}

std::vector<Rgb> colours_of(const ColourScale& scale, const Particles& particles) {
  const Event event("Colour");
  const ScopedEvent timed(event);
  std::vector<Rgb> colours(particles.id.size());
  for_each_index({0, particles.size()},
                 [&](std::size_t i) { colours[i] = colour_of(scale, particles, static_cast<LocalId>(i)); });
  return colours;
}

}  // namespace trevi

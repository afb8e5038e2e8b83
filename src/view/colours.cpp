#include "view/colours.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

using Bytes = std::array<unsigned char, 3>;
using Scale = std::span<const Bytes>;

constexpr Bytes unknown = {150, 150, 150};
constexpr double density_margin = 0.1;
// Deep water to foam.
constexpr std::array<Bytes, 5> water = {
    {{20, 50, 140}, {25, 110, 205}, {40, 180, 225}, {160, 230, 235}, {255, 255, 255}}};
// Blue, white, red (Moreland 2009, diverging).
constexpr std::array<Bytes, 5> diverging = {
    {{59, 76, 192}, {140, 175, 254}, {235, 235, 235}, {245, 156, 125}, {180, 4, 38}}};
// Okabe and Ito: distinguishable with any colour vision.
constexpr std::array<Bytes, 8> distinct = {{{86, 180, 233},
                                            {230, 159, 0},
                                            {0, 158, 115},
                                            {204, 121, 167},
                                            {240, 228, 66},
                                            {0, 114, 178},
                                            {213, 94, 0},
                                            {220, 220, 220}}};

Bytes on_scale(Scale scale, double part) {
  if (std::isnan(part)) return unknown;
  const double position = std::clamp(part, 0.0, 1.0) * static_cast<double>(scale.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(position), scale.size() - 2);
  Bytes mixed{};
  for (std::size_t c = 0; c < 3; ++c)
    mixed[c] = static_cast<unsigned char>(std::lerp(scale[k][c], scale[k + 1][c], position - static_cast<double>(k)));
  return mixed;
}

Bytes colour_of(const ViewedParticle& particle, Colour by, const ColourRange& range) {
  switch (by) {
    case Colour::speed:
      return on_scale(water, particle.speed / range.fastest);
    case Colour::density:
      return on_scale(diverging, (particle.density / range.rest_density - 1) / (2 * density_margin) + 0.5);
    default:
      return {particle.rgb[0], particle.rgb[1], particle.rgb[2]};
  }
}

bool has(const ViewedFrame& frame, float ViewedParticle::*field) {
  return frame.shown.empty() || !std::isnan(frame.shown.front().*field);
}

}  // namespace

void colour_particles(const ViewedFrame& frame, Colour by, ColourRange& range, std::vector<unsigned char>& rgb) {
  for (const ViewedParticle& particle : frame.shown) {
    if (particle.speed > range.fastest) range.fastest = particle.speed;
  }
  rgb.resize(3 * frame.shown.size());
  auto* to = rgb.data();
  std::size_t i = 0;
  for (std::size_t rank = 0; rank < frame.rank_counts.size(); ++rank) {
    for (const std::size_t end = i + static_cast<std::size_t>(frame.rank_counts[rank]); i < end; ++i, to += 3) {
      const Bytes colour = by == Colour::rank ? distinct[rank % distinct.size()] : colour_of(frame.shown[i], by, range);
      std::copy(colour.begin(), colour.end(), to);
    }
  }
}

std::string legend(const ViewedFrame& frame, Colour by, const ColourRange& range) {
  const double rest = range.rest_density;
  switch (by) {
    case Colour::speed:
      if (!has(frame, &ViewedParticle::speed)) return "speed: not in this frame";
      return fmt::format("speed 0 (blue) to {:.1f} m/s (white)", range.fastest);
    case Colour::density:
      if (!has(frame, &ViewedParticle::density)) return "density: not in this frame";
      return fmt::format("density {:.0f} (blue) to {:.0f} kg/m3 (red)", (1 - density_margin) * rest,
                         (1 + density_margin) * rest);
    case Colour::rank:
      return fmt::format("rank 0 to {}", frame.rank_counts.empty() ? 0 : frame.rank_counts.size() - 1);
    default:
      return colour_list[static_cast<std::size_t>(by)].name;
  }
}

Colour next_colour(Colour colour) {
  auto k = static_cast<std::size_t>(colour);
  do k = (k + 1) % colour_list.size();
  while (!colour_list[k].in_viewer);
  return colour_list[k].colour;
}

}  // namespace trevi

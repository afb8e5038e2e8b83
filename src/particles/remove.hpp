// Taking particles out of the arrays of a rank. Not collective.
#pragma once

#include <span>

#include "trevi/particles.hpp"

namespace trevi {

/// Removes the particles at these places, which ascend. The last particles take the places of those that leave, so that
/// only these cost; the next sort makes the order anew.
inline void remove_particles(Particles& particles, std::span<const LocalId> places) {
  particles.for_each_field([&](auto& field) {
    for (auto place = places.rbegin(); place != places.rend(); ++place) {
      field[static_cast<std::size_t>(*place)] = field.back();
      field.pop_back();
    }
  });
}

}  // namespace trevi

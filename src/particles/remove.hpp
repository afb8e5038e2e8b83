// Removal of particles from the arrays of a rank. Not collective.
#pragma once

#include <span>

#include "base/threads.hpp"
#include "trevi/particles.hpp"

namespace trevi {

/// Removes the particles at these places, which are in ascending order. The last particles move to the places of those
/// that leave, so that the cost depends only on their number; the next sort restores the order.
inline void remove_particles(Particles& particles, std::span<const LocalId> places) {
  const auto left = static_cast<std::size_t>(particles.size()) - places.size();
  std::vector<LocalId> moved;  // the particles at the end that stay, one for each place before them
  auto next = std::lower_bound(places.begin(), places.end(), static_cast<LocalId>(left));
  const auto holes = static_cast<LocalId>(next - places.begin());
  for (LocalId i = static_cast<LocalId>(left); i < particles.size(); ++i) {
    if (next != places.end() && *next == i) {
      ++next;
    } else {
      moved.push_back(i);
    }
  }
  particles.for_each_field([&](auto& field) {
    for_each_index({0, holes}, [&field, &moved, places](std::size_t k) {
      field[static_cast<std::size_t>(places[k])] = field[static_cast<std::size_t>(moved[k])];
    });
    field.resize(left);
  });
}

}  // namespace trevi

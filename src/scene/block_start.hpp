// The initial state of a [[particles]] block: which places of its lattice contain water, and the velocity there. One
// thread at a time. Not collective.
#pragma once

#include <optional>
#include <vector>

#include "scene/formula.hpp"
#include "scene/free_places.hpp"
#include "trevi/scene.hpp"

namespace trevi {

class BlockStart {
 public:
  /// The expressions are checked; InputError if they are not valid. `places` outlives this object.
  BlockStart(const ParticleSource& block, const FreePlaces& places);

  /// Whether all places of the lattice contain water.
  bool is_whole() const { return places_.all() && !surface_; }
  /// Whether there is water: outside of obstacles, and not above the surface. Throws InputError if that is not a
  /// number.
  bool holds_water(const Vec3& place) const;
  /// The number of places with water in a layer of the lattice across an axis.
  GlobalId count(const Lattice& lattice, int axis, GlobalId layer) const;
  /// The velocity, m/s. Throws InputError if it is not a number.
  Vec3 velocity(const Vec3& place) const;
  /// The largest speed at 9 x 9 x 9 places of the block, m/s.
  Real fastest() const;

 private:
  const ParticleSource& block_;
  const FreePlaces& places_;
  std::vector<Formula> velocity_;  // of each coordinate, or none
  std::optional<Formula> surface_;
};

}  // namespace trevi

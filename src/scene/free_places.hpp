// Where water can be at the start, or when a run continues. An obstacle or a body excludes exactly the water that it
// displaces, and of places on its surface the fraction that it fills of the space around them: a vessel holds its
// volume, and there is no gap into which water falls. Not collective.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/solid_test.hpp"
#include "scene/lattice.hpp"
#include "trevi/scene.hpp"

namespace trevi {

class FreePlaces {
 public:
  /// Meshes have been read. The obstacles are where they are at this time, s; bodies count only at the start.
  explicit FreePlaces(const Scene& scene, Real time = 0);
  bool all() const { return solids_.empty(); }
  bool is_free(const Vec3& p) const;
  /// The number of the solid that contains p deeper than `depth`, m, with bodies numbered after obstacles; −1 if there
  /// is none.
  int solid_at(const Vec3& p, Real depth = 0) const;
  /// "obstacle 0", or "body 0", as they are numbered in the scene.
  std::string name_of(int solid) const;

 private:
  struct Solid {
    int number;
    std::unique_ptr<SolidTest> test;
    Pose pose;
  };
  void add(int number, const ObstacleSettings& solid, const Pose& pose);
  bool is_body(int solid) const { return solid >= obstacles_; }
  bool is_nearer(const Solid& solid, const Vec3& p, Real gap) const;
  bool displaces(const Solid& solid, const Vec3& p) const;

  Real spacing_;
  std::vector<Solid> solids_;
  int obstacles_;
};

/// Calls visit(i, j, k) for the points of a layer of a lattice across an axis, x fastest.
template <class Visit>
void for_each_point(const Lattice& lattice, int axis, GlobalId layer, const Visit& visit) {
  std::array<GlobalId, 3> begin = {0, 0, 0}, end = lattice.count;
  begin[static_cast<std::size_t>(axis)] = layer;
  end[static_cast<std::size_t>(axis)] = layer + 1;
  for (GlobalId k = begin[2]; k < end[2]; ++k) {
    for (GlobalId j = begin[1]; j < end[1]; ++j) {
      for (GlobalId i = begin[0]; i < end[0]; ++i) visit(i, j, k);
    }
  }
}

}  // namespace trevi

// The obstacles of a scene as triangles in the world, for pictures: those that stay where they are, and those that move
// at a time. Triangles look out of the solid, so that of a vessel one sees the far walls from inside. Rank-local.
#pragma once

#include <span>
#include <vector>

#include "boundary/geometry/pose.hpp"
#include "trevi/body.hpp"

namespace trevi {

struct ObstacleSurface {
  TriangleMesh mesh;                   ///< m, in the world
  std::vector<std::int32_t> obstacle;  ///< of each triangle, from 0
};

class ObstacleSurfaces {
 public:
  /// Curves are cut into chords that deviate by at most `finest`, m. Meshes are to be there (read_obstacle_files).
  /// The last `bodies` of them move freely.
  ObstacleSurfaces(const std::vector<ObstacleSettings>& obstacles, Real finest, std::size_t bodies = 0);

  bool any_stays() const { return count(false) > 0; }
  bool any_moves() const { return count(true) > 0; }
  ObstacleSurface standing() const { return placed(false, 0); }
  /// Bodies are where their states are; without any, as at the start.
  ObstacleSurface moving(Real time, std::span<const BodyState> bodies = {}) const { return placed(true, time, bodies); }

 private:
  struct One {
    BodyMotion motion;
    TriangleMesh mesh;  // in the frame of the obstacle
    bool moves;
    Vec3 center_of_mass;  // of a body, in its frame
  };
  std::size_t count(bool moves) const;
  ObstacleSurface placed(bool moves, Real time, std::span<const BodyState> bodies = {}) const;

  std::vector<One> all_;
  std::size_t bodies_;
};

}  // namespace trevi

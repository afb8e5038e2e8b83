// The obstacles of a scene as triangles in the world, for pictures: those that stay where they are, and those that move
// at a time. Triangles look out of the solid, so that of a vessel one sees the far walls from inside. Rank-local.
#pragma once

#include <vector>

#include "boundary/geometry/pose.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

struct ObstacleSurface {
  TriangleMesh mesh;                   ///< m, in the world
  std::vector<std::int32_t> obstacle;  ///< of each triangle, from 0
};

class ObstacleSurfaces {
 public:
  /// Curves are cut into chords that deviate by at most `finest`, m. Meshes are to be there (read_obstacle_files).
  ObstacleSurfaces(const std::vector<ObstacleSettings>& obstacles, Real finest);

  bool any_stays() const { return count(false) > 0; }
  bool any_moves() const { return count(true) > 0; }
  ObstacleSurface standing() const { return placed(false, 0); }
  ObstacleSurface moving(Real time) const { return placed(true, time); }

 private:
  struct One {
    BodyMotion motion;
    TriangleMesh mesh;  // in the frame of the obstacle
    bool moves;
  };
  std::size_t count(bool moves) const;
  ObstacleSurface placed(bool moves, Real time) const;

  std::vector<One> all_;
};

}  // namespace trevi

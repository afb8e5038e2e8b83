// The obstacles of a scene as triangles in the world, for pictures: those that do not move, and those that move, at a
// given time. Triangles face out of the solid, so that the far walls of a vessel are seen from inside. Rank-local.
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
  /// Curves are divided into chords that deviate by at most `finest`, m. Meshes must have been read
  /// (read_obstacle_files). The last `bodies` of the obstacles move freely.
  ObstacleSurfaces(const std::vector<ObstacleSettings>& obstacles, Real finest, std::size_t bodies = 0);

  bool any_stays() const { return count(false) > 0; }
  bool any_moves() const { return count(true) > 0; }
  ObstacleSurface standing() const { return placed(false, 0); }
  /// Bodies are where their states put them; without states, where they are at the start.
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

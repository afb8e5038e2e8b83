// The surfaces of obstacles beside the frames of a run, VTK XML "PolyData" (.vtp): obstacles.vtp, once, for those that
// do not move, and obstacles_<step>.vtp, with each frame, for those that do. Triangles face out of the solid, towards
// the water, also those of a vessel. The format needs no VTK. Rank-local: rank 0 holds the one object.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/frames/frame_list_file.hpp"
#include "io/frames/obstacle_surfaces.hpp"
#include "trevi/clock.hpp"

namespace trevi {

class ObstacleFrames {
 public:
  /// `folder`: of the frames, with a slash at its end. With `own_list`, moving obstacles have a list with their times,
  /// obstacles.vtp.series, for formats whose list of frames cannot name other files. Those past `restart_step` are set
  /// aside.
  ObstacleFrames(std::shared_ptr<const ObstacleSurfaces> surfaces, std::string folder, bool own_list,
                 std::optional<std::int64_t> restart_step);

  /// Writes moving obstacles; returns the names of all files that belong to the frame, in the folder.
  std::vector<std::string> write(const Clock& clock, std::span<const BodyState> bodies);

 private:
  std::shared_ptr<const ObstacleSurfaces> surfaces_;
  std::string folder_;
  std::optional<FrameListFile> list_;
};

/// A complete .vtp file, with the number of the obstacle for each triangle.
std::string vtp_text(const ObstacleSurface& surface);

}  // namespace trevi

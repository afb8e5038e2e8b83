// Reads one frame of a directory into the form that the painter draws: only particles that can be seen, thinned to a
// budget (io/frames/visible.hpp), in rank order. A frame without ids is thinned by the index in the file, which is not
// the same particle in each frame. May be called from any one thread at a time.
#pragma once

#include <string>

#include "io/frames/viewed_frame.hpp"
#include "view/frame_list.hpp"

namespace trevi {

/// All particles of a file; empty arrays for fields that it does not contain.
struct RawFrame {
  std::vector<Vec3> position;
  std::vector<float> speed, density;
  std::vector<std::int64_t> id;
  std::vector<std::array<std::uint8_t, 3>> rgb;
  std::vector<std::int64_t> rank_counts;
};

/// Both throw InputError for a file that is missing or damaged.
RawFrame read_vtu_frame(const std::string& path);  ///< .pvtu with its pieces, or .vtu
RawFrame read_hdf_frame(const std::string& path);
/// A surface of obstacles; throws InputError, too.
TriangleMesh read_vtp_surface(const std::string& path);

class FrameReader {
 public:
  /// `all`: include particles that cannot be seen, without a budget.
  FrameReader(const ViewedScene& scene, std::int64_t budget, bool all) : scene_(scene), budget_(budget), all_(all) {}
  ViewedFrame read(const FrameEntry& entry) const;

 private:
  std::vector<std::shared_ptr<const TriangleMesh>> solids_of(const FrameEntry& entry) const;

  ViewedScene scene_;
  std::int64_t budget_;
  bool all_;
  mutable std::shared_ptr<const TriangleMesh> still_;  ///< obstacles that do not move, once they have been read
};

/// All particles of a file, whether or not they can be seen.
RawFrame read_raw(const std::string& path);

}  // namespace trevi

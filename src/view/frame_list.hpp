// The frames of a run's directory, in order of time: particles.pvd (VTU) or particles.hdf.series (VTKHDF), which a run
// replaces in one stroke as it writes. Rank-local; no particle is read here.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/frames/frame_list_file.hpp"

namespace trevi {

class FrameList {
 public:
  /// A directory, or one of the two files. InputError when there is no frame, or the list is damaged.
  explicit FrameList(const std::string& path);

  /// A frame whose name has no step has its index as one; paths are those of this process.
  const std::vector<FrameEntry>& entries() const { return entries_; }
  const std::string& path() const { return path_; }
  std::string directory() const;
  /// Reads the list again if it has changed; true when it has. One that is unreadable for a moment is left for later.
  bool refresh();

 private:
  std::vector<FrameEntry> read() const;

  std::string path_;  ///< of the list
  std::vector<FrameEntry> entries_;
  std::filesystem::file_time_type stamp_;
};

}  // namespace trevi

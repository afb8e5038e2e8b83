// The frames of a run's directory, in order of time: particles.pvd (VTU) or particles.hdf.series (VTKHDF), which a run
// replaces as a whole when it writes. Rank-local; no particles are read here.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/frames/frame_list_file.hpp"

namespace trevi {

class FrameList {
 public:
  /// A directory, or one of the two files. InputError if there is no frame, or the list is damaged.
  explicit FrameList(const std::string& path);

  /// A frame whose name has no step has its index as its step; paths are those of this process.
  const std::vector<FrameEntry>& entries() const { return entries_; }
  const std::string& path() const { return path_; }
  std::string directory() const;
  /// Reads the list again if it has changed, and returns whether it has. A temporarily unreadable list is left for
  /// later.
  bool refresh();

 private:
  std::vector<FrameEntry> read() const;

  std::string path_;  ///< of the list
  std::vector<FrameEntry> entries_;
  std::filesystem::file_time_type stamp_;
};

}  // namespace trevi

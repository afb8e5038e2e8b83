// The list of a run's frames with their times, for ParaView and trevi-view: particles.pvd of VTU frames, or
// particles.hdf.series of VTKHDF frames. Paths are relative to the list. Invariant: the file on disk always lists
// complete frames only, as it is replaced in one stroke when a frame is added. Rank-local: rank 0 holds the one object.
// Formats: VTK XML "Collection" (VTK File Formats), and ParaView's file series, version 1.0.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trevi/clock.hpp"

namespace trevi {

struct FrameEntry {
  std::int64_t step = 0;            ///< by the file's name; -1 when the name has none
  double time = 0;                  ///< s
  std::string path;                 ///< .pvtu, .vtu or .hdf
  std::vector<std::string> others;  ///< what else there is at that time: surfaces of obstacles, in a .pvd only
};

/// Entries in the order of the file. InputError when it is damaged.
std::vector<FrameEntry> read_frame_list(const std::string& path);

class FrameListFile {
 public:
  /// The entries up to `restart_step` stay when it is given and the file exists; otherwise the list starts empty. Of a
  /// damaged file those stay that can be read, and it is set aside as .stale.
  FrameListFile(const std::string& path, std::optional<std::int64_t> restart_step);

  /// Adds a frame, with what else there is at its time, and rewrites the file.
  void add(const Clock& clock, const std::string& frame_path, const std::vector<std::string>& others = {});

  std::int64_t last_step() const { return entries_.empty() ? -1 : entries_.back().step; }

 private:
  void write() const;

  std::string path_;
  std::vector<FrameEntry> entries_;
};

}  // namespace trevi

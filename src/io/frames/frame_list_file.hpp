// The list of a run's frames with their times, for ParaView and trevi-view: particles.pvd for VTU frames, or
// particles.hdf.series for VTKHDF frames. Paths are relative to the list. Invariant: the file on disk always lists only
// complete frames, because it is replaced as a whole when a frame is added. Rank-local: rank 0 holds the one object.
// Formats: VTK XML "Collection" (VTK File Formats), and ParaView's file series, version 1.0.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trevi/clock.hpp"

namespace trevi {

struct FrameEntry {
  std::int64_t step = 0;            ///< from the file's name; -1 if the name has none
  double time = 0;                  ///< s
  std::string path;                 ///< .pvtu, .vtu or .hdf
  std::vector<std::string> others;  ///< other files for that time: surfaces of obstacles, in a .pvd only
};

/// Entries in the order of the file. InputError if it is damaged.
std::vector<FrameEntry> read_frame_list(const std::string& path);

class FrameListFile {
 public:
  /// Entries up to `restart_step` are kept if it is given and the file exists; otherwise the list starts empty. If the
  /// file is damaged, the readable entries are kept, and it is set aside as .stale.
  FrameListFile(const std::string& path, std::optional<std::int64_t> restart_step);

  /// Adds a frame, with other files for its time, and rewrites the file.
  void add(const Clock& clock, const std::string& frame_path, const std::vector<std::string>& others = {});

  std::int64_t last_step() const { return entries_.empty() ? -1 : entries_.back().step; }

 private:
  void write() const;

  std::string path_;
  std::vector<FrameEntry> entries_;
};

}  // namespace trevi

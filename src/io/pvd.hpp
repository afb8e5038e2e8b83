// particles.pvd: ParaView's list of frames with physical time (s) and paths relative to the file.
// Invariant: the file on disk always lists complete frames only; it is replaced in one stroke when a frame is added.
// Rank-local: rank 0 holds the one object. A restart at step S keeps the entries up to S.
// Format: VTK XML "Collection" (VTK file formats, ParaView Users' Guide).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trevi/clock.hpp"

namespace trevi {

class PvdFile {
 public:
  /// Reads the entries up to `restart_step` when it is given and the file exists; otherwise the list starts empty.
  PvdFile(const std::string& path, std::optional<std::int64_t> restart_step);

  /// Adds a frame and rewrites the file. `frame_path` is relative to the file's folder and has the step in its name.
  void add(const Clock& clock, const std::string& frame_path);

  std::int64_t last_step() const { return entries_.empty() ? -1 : entries_.back().step; }

 private:
  struct Entry {
    std::int64_t step;
    std::string line;
  };
  void write() const;

  std::string path_;
  std::vector<Entry> entries_;
};

}  // namespace trevi

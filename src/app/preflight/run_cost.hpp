// The disk space and time that a run would take, before it is started.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trevi/scene.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// Bytes of frames, checkpoints and series that a scene requests: an upper bound, because VTU frames are compressed.
double output_bytes(const Scene& scene, double particles);

/// For one of [[output.frames]]: the number of frames, and the bytes of one, at most.
struct FrameSetCost {
  double frames = 0, bytes = 0;
};
FrameSetCost cost_of(const Scene& scene, const FrameSetSettings& set, double particles);

/// One sentence with the remedy if `bytes` exceed the free space on the disk of `directory`, which need not exist yet;
/// otherwise none. Not collective.
std::vector<std::string> disk_warnings(double bytes, const std::string& directory);

/// Bytes in words: "3.2 GB".
std::string size_text(double bytes);

struct MeasuredSpeed {
  int particles = 0;          ///< of the sample
  double substep = 0;         ///< s, per substep and particle, on this rank with its threads
  std::int64_t substeps = 0;  ///< per step
};

/// Runs a few steps of a pool at rest with the settings of a scene, on each rank separately and on all at the same
/// time, as in the run. Writes nothing. Collective only in that all ranks should do so together.
MeasuredSpeed measured_speed(const Scene& scene);

}  // namespace trevi

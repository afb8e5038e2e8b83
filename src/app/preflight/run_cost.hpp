// What a run would take of disk and time, before it is begun.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trevi/scene.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// Bytes of frames, checkpoints and series that a scene asks for: an upper bound, as VTU frames are compressed.
double output_bytes(const Scene& scene, double particles);

/// Of one of [[output.frames]]: the number of frames, and bytes of one, at most.
struct FrameSetCost {
  double frames = 0, bytes = 0;
};
FrameSetCost cost_of(const Scene& scene, const FrameSetSettings& set, double particles);

/// A sentence with the remedy where `bytes` are more than what is free on the disk of `directory`, which need not be
/// there yet; else none. Not collective.
std::vector<std::string> disk_warnings(double bytes, const std::string& directory);

/// Bytes in words: "3.2 GB".
std::string size_text(double bytes);

struct MeasuredSpeed {
  int particles = 0;          ///< of the sample
  double substep = 0;         ///< s, of a substep of one particle, on this rank and its threads
  std::int64_t substeps = 0;  ///< of a step
};

/// Runs a few steps of a pool at rest with the settings of a scene, on each rank for itself and all at the same time,
/// as in the run. Writes nothing. Collective only in that all ranks should do so together.
MeasuredSpeed measured_speed(const Scene& scene);

}  // namespace trevi

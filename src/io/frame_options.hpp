// What the writers of frames for ParaView (vtu.hpp, vtkhdf.hpp) are told: where, when, which fields, which colours.
// Invariant: the fields mean the same in both formats: velocity (Float32 x 3), density (Float32), id (Int64), rank
// (Int32), rgb (UInt8 x 3). Plain data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/colour.hpp"
#include "trevi/clock.hpp"

namespace trevi {

struct FrameOptions {
  std::string directory;
  Schedule schedule;
  std::vector<std::string> fields;  ///< of velocity, density, id, rank, rgb
  ColourScale colour;
  std::optional<std::int64_t> restart_step;  ///< entries past it leave the list, their files are renamed *.stale
};

}  // namespace trevi

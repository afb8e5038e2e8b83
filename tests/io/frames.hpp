// What the tests of both formats of frames share: all fields every five steps, and rows found by their ids.
#pragma once

#include <vtkDataArray.h>
#include <vtkVariant.h>

#include <algorithm>
#include <string>

#include "io/frames/frame_writer.hpp"
#include "support/output_fixture.hpp"

namespace trevi {

inline FrameOptions frame_options(const std::string& folder) {
  FrameOptions options;
  options.directory = folder;
  options.schedule.every_steps = 5;
  options.fields = {"velocity", "density", "id", "rank", "rgb"};
  options.colour.by = Colour::rainbow_x;
  return options;
}

/// Row of an id in the whole cloud.
inline std::size_t row_of(const Particles& all, GlobalId id) {
  return static_cast<std::size_t>(std::lower_bound(all.id.begin(), all.id.end(), id) - all.id.begin());
}

inline GlobalId id_of(vtkDataArray* ids, vtkIdType i) {
  return static_cast<GlobalId>(ids->GetVariantValue(i).ToLongLong());
}

}  // namespace trevi

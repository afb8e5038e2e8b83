// What a failed run leaves for inspection: DIR/blowup_<step>.h5. It contains
// /particles/{id,position,velocity,predicted} as in a checkpoint, unsorted, and the same as a VTKHDF grid (positions of
// the last good state as points, p* of the failed step as the field "predicted", which may be anything).
// DIR/blowup_<step>.hdf is a link to it, because ParaView goes by the file name extension. Attributes: step and
// message. Collective.
#pragma once

#include <string>

#include "trevi/particles.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct BlowUpState {
  std::int64_t step = 0;  ///< that failed
  const Particles& particles;
  std::string message;
};

/// Returns the path of the file. RunError on all ranks alike.
std::string write_blowup(MPI_Comm comm, const std::string& directory, const BlowUpState& state);

}  // namespace trevi

// What a failed run leaves to look at: DIR/blowup_<step>.h5. /particles/{id,position,velocity,predicted} as in a
// checkpoint, unsorted; the same as a VTKHDF grid (positions of the last good state as points, p* of the failed step
// as the field "predicted", which may be anything), to which DIR/blowup_<step>.hdf is a link, as ParaView goes by the
// ending; attributes step and message. Collective.
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

// Frames for ParaView in VTK XML: DIR/particles.pvd -> vtu/particles_<step>.pvtu -> one .vtu piece per rank.
// Points are Float64, or Float32 where that is asked for; arrays, as asked for, as in fields.hpp. Pieces are appended raw binary, zlib compressed, one
// vertex cell per particle; a rank without particles writes a valid piece. Collective.
#pragma once

#include <memory>
#include <string>

#include "io/frames/frame_writer.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// Throws InputError, with the remedy, in a build without VTK (vtu_absent.cpp). To be called before anything is
/// written.
void require_vtk();

/// Requires VTK.
std::unique_ptr<Observer> make_vtu_writer(MPI_Comm comm, FrameOptions options);

/// "9.1.0", or "absent".
std::string vtk_version();

}  // namespace trevi

// Frames for ParaView in VTK XML: DIR/particles.pvd -> vtu/particles_<step>.pvtu -> one .vtu piece per rank.
// Points are Float64; arrays, as asked for: velocity (Float32 x 3), density (Float32), id (Int64), rank (Int32), rgb
// (UInt8 x 3). Pieces are appended raw binary, zlib compressed, one vertex cell per particle; a rank without particles
// writes a valid piece. Collective. Without VTK in the build (vtu_absent.cpp) make_vtu_writer throws InputError, with
// the remedy.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trevi/output/colour.hpp"
#include "trevi/parallel/session.hpp"
#include "trevi/solver/observer.hpp"

namespace trevi {

struct VtuOptions {
  std::string directory;
  Schedule schedule;
  std::vector<std::string> fields;  ///< of velocity, density, id, rank, rgb
  ColourScale colour;
  std::optional<std::int64_t> restart_step;  ///< entries past it leave the .pvd, their files are renamed *.stale
};

std::unique_ptr<Observer> make_vtu_writer(MPI_Comm comm, VtuOptions options);

/// "9.1.0", or "absent".
std::string vtk_version();

}  // namespace trevi

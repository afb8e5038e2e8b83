// Particles from an HDF5 file: /particles/position (N x 3, m), optional velocity (N x 3, m/s) and id (N, integers).
// Every rank reads an equal contiguous slice of the rows; no rank holds more than its slice.
// Collective. Every problem is an InputError on all ranks alike, naming file, dataset and remedy.
#pragma once

#include <string>
#include <vector>

#include "io/hdf5/hdf5_reader.hpp"
#include "trevi/particles.hpp"
#include "trevi/session.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// This rank's rows of a particle table: particles in file order, without predicted positions, and with those optional
/// fields that the file has.
struct ParticleRows : Particles {
  GlobalId total = 0;  ///< rows of all ranks together
  GlobalId first = 0;  ///< row number of this rank's first
};

/// For [[particles]] type = "file": velocity defaults to zero, id to the row number. Numbers are finite; ids are unique
/// and not negative.
ParticleRows read_particle_file(MPI_Comm comm, const std::string& path);

/// Rank-local part of the above: one slice of the /particles/position.rows(), values unchecked, with all fields of a
/// checkpoint that are present.
ParticleRows read_particle_rows(const Hdf5Reader& file, RowSlice slice);

/// Ids are below this limit, also those of all sources of a scene together: the sum of two does not overflow.
inline constexpr GlobalId end_of_ids = GlobalId{1} << 62;

/// Collective: throws InputError naming `path` when a number is not finite, or an id occurs twice or is out of range.
void check_particle_rows(MPI_Comm comm, const ParticleRows& rows, const std::string& path);

}  // namespace trevi

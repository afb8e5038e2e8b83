// What changed between the scene a checkpoint was made with and the scene it is restarted with, key by key.
// Times and outputs may change freely: [time] end, [output], [colour], [run]. What changes the physics may not, unless
// the command line says so with --set; and time.dt may not at all, as times are numbers of steps times dt, nor
// [[particles]], which a restart does not read, nor what gives the stored particles their mass: fluid.spacing,
// rest_density, mass, and with mass = "volume" kernel_radius.
// The texts are compared as parsed documents, so comments, order and the way a number is written do not count.
// A file of music, of a mesh or of a motion that holds something else under its old name has changed, too.
// Not collective, but for music_checksums and checkpoint_info; the same texts give the same answer on all ranks.
#pragma once

#include <string>
#include <vector>

#include "io/hdf5/checkpoint.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// One line for each change that is allowed. Throws InputError that lists every one that is not, with file, line, key
/// and remedy; `info` is that of the checkpoint `checkpoint_path`, `now` that of this run.
std::vector<std::string> scene_changes(const CheckpointInfo& info, const std::string& checkpoint_path,
                                       const Scene& scene, const CheckpointInfo& now);

/// Checksums of the music file of each fountain and each inlet; 0 for one without. Collective; InputError when a file
/// cannot be read.
std::vector<std::int64_t> music_checksums(MPI_Comm comm, const Scene& scene);

/// What a checkpoint tells of the run. To be called once, at its start: the files that it looks into may be gone later.
/// Collective; InputError as music_checksums().
CheckpointInfo checkpoint_info(MPI_Comm comm, const Scene& scene);

}  // namespace trevi

// What changed between the scene a checkpoint was made with and the scene it is restarted with, key by key. Times and
// outputs may change freely: [time] end, [output], [colour], [run]. What changes the physics may not, unless the
// command line says so with --set. Some keys may not change at all: time.dt, because times are numbers of steps times
// dt; [[particles]], which a restart does not read; and those that give the stored particles their mass: fluid.spacing,
// rest_density, mass, and with mass = "volume" kernel_radius. The texts are compared as parsed documents, so comments,
// order and the way a number is written do not count. A music, mesh or motion file whose content is different under its
// old name has changed, too. Not collective, except for music_checksums and checkpoint_info; the same texts give the
// same answer on all ranks.
#pragma once

#include <string>
#include <vector>

#include "io/hdf5/checkpoint.hpp"
#include "trevi/scene.hpp"

namespace trevi {

/// One line for each change that is allowed. Throws InputError that lists all changes that are not, with file, line,
/// key and remedy; `info` is that of the checkpoint `checkpoint_path`, `now` that of this run.
std::vector<std::string> scene_changes(const CheckpointInfo& info, const std::string& checkpoint_path,
                                       const Scene& scene, const CheckpointInfo& now);

/// Checksums of the music file of each fountain and each inlet; 0 for one without. Collective; InputError if a file
/// cannot be read.
std::vector<std::int64_t> music_checksums(MPI_Comm comm, const Scene& scene);

/// What a checkpoint records about the run. To be called once, at its start, because the files that it reads may no
/// longer exist later. Collective; InputError as for music_checksums().
CheckpointInfo checkpoint_info(MPI_Comm comm, const Scene& scene);

}  // namespace trevi

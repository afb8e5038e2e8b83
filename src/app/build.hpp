// From a scene to objects. A feature that a scene does not name is not built: it has no forcing, no filter, no array
// and no event. Collective; throws InputError on all ranks alike for what this program cannot do.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "app/command_line.hpp"
#include "io/hdf5/checkpoint.hpp"
#include "io/run_directory/output_lock.hpp"
#include "io/tables/energy_rise.hpp"
#include "live/viewer_link.hpp"
#include "scene/scene_changes.hpp"
#include "trevi/scene.hpp"
#include "trevi/session.hpp"
#include "trevi/solver.hpp"

namespace trevi {

struct BuildOptions {
  std::string directory;       ///< of the output; empty where no observer writes
  OutputLock* lock = nullptr;  ///< on it; taken once the folder is there
  ProgressMode progress = ProgressMode::automatic;
  std::int64_t last_step = 0;
  std::optional<CheckpointState> restart;
  std::function<RequestCounts()> requests;  ///< what the world outside asks of this rank
  bool viewed = false;                      ///< a viewer may watch the run
  std::shared_ptr<ViewerLink> viewer;       ///< to which rank 0 has this link
  std::shared_ptr<EnergyRise> energy;       ///< what the series tells of it
  CheckpointInfo info;                      ///< for checkpoints; of no use without a directory
};

/// For the series of a scene without fountains, inlets, drains and obstacles that move; null for others.
std::shared_ptr<EnergyRise> make_energy_rise(const Scene& scene);

/// Makes the folder of the output once the whole scene has been found good; writes nothing but what observers open. Any
/// communicator will do, so that a test can set one rank beside many.
std::unique_ptr<Solver> build_solver(MPI_Comm comm, const Scene& scene, BuildOptions options);

}  // namespace trevi

// Builds the objects of a run from a scene. A feature that a scene does not name is not built: it has no forcing, no
// filter, no array and no event. Collective; throws InputError on all ranks alike for what this program cannot do.
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
  std::string directory;       ///< of the output; empty if no observer writes
  OutputLock* lock = nullptr;  ///< on the directory; taken once that exists
  ProgressMode progress = ProgressMode::automatic;
  std::int64_t last_step = 0;
  std::optional<CheckpointState> restart;
  std::function<RequestCounts()> requests;  ///< what is requested of this rank from outside
  bool viewed = false;                      ///< a viewer may watch the run
  std::shared_ptr<ViewerLink> viewer;       ///< rank 0's link to it
  std::shared_ptr<EnergyRise> energy;       ///< receives the rows of the series
  CheckpointInfo info;                      ///< for checkpoints; not used without a directory
};

/// For the series of a scene without fountains, inlets, drains and moving obstacles; null for others.
std::shared_ptr<EnergyRise> make_energy_rise(const Scene& scene);

/// Creates the output folder once the whole scene has been found valid; writes nothing except what observers open.
/// Works with any communicator, so that a test can compare one rank with many.
std::unique_ptr<Solver> build_solver(MPI_Comm comm, const Scene& scene, BuildOptions options);

}  // namespace trevi

// The observers that write the files of a run, as the output of the settings says. Collective.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/frames/colour.hpp"
#include "io/hdf5/checkpoint.hpp"
#include "io/tables/energy_rise.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct WriterOptions {
  std::string directory;
  GlobalId particles = 0;  ///< of all ranks at the start, by which they are coloured
  std::optional<std::int64_t> restart_step;
  CheckpointInfo info;                           ///< for checkpoints
  std::shared_ptr<EnergyRise> energy = nullptr;  ///< what the series tells of it; may be null
};

/// In a folder that is there. A checkpoint is written when the run is asked to save, whether the settings have a
/// schedule for them or not.
std::vector<std::unique_ptr<Observer>> make_writers(MPI_Comm comm, const Settings& settings,
                                                    const WriterOptions& options);

/// The same in a folder that is made, locked as long as the writers live, and refused when it holds another run.
std::vector<std::unique_ptr<Observer>> make_writers_and_folder(MPI_Comm comm, const Settings& settings,
                                                               const WriterOptions& options);

/// Of rows of gauges.csv; none where nothing asks for them.
std::optional<Schedule> schedule_of_gauges(const Settings& settings);

/// Whether frames in VTU are asked for.
bool needs_vtk(const OutputSettings& output);

ColourScale colour_scale(const Settings& settings, GlobalId particles);

/// Whether something else than gravity gives the water energy: a fountain, an inlet, a drain, an obstacle or a body
/// that moves.
bool is_supplied(const Settings& settings);

}  // namespace trevi

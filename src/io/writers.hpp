// The observers that write the files of a run, according to the output settings. Collective.
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
  GlobalId particles = 0;  ///< of all ranks at the start; determines their colours
  std::optional<std::int64_t> restart_step;
  CheckpointInfo info;                           ///< for checkpoints
  std::shared_ptr<EnergyRise> energy = nullptr;  ///< receives the rows of the series; may be null
};

/// For an existing folder. A checkpoint is written when the run is asked to save, whether or not the settings have a
/// schedule for checkpoints.
std::vector<std::unique_ptr<Observer>> make_writers(MPI_Comm comm, const Settings& settings,
                                                    const WriterOptions& options);

/// The same for a folder that is created, locked as long as the writers live, and refused if it holds another run.
std::vector<std::unique_ptr<Observer>> make_writers_and_folder(MPI_Comm comm, const Settings& settings,
                                                               const WriterOptions& options);

/// The schedule of the rows of gauges.csv; none if nothing asks for them.
std::optional<Schedule> schedule_of_gauges(const Settings& settings);

/// Whether frames in VTU are asked for.
bool needs_vtk(const OutputSettings& output);

ColourScale colour_scale(const Settings& settings, GlobalId particles);

/// Whether anything other than gravity gives the water energy: a fountain, an inlet, a drain, a moving obstacle or a
/// moving body.
bool is_supplied(const Settings& settings);

}  // namespace trevi

#include "io/writers.hpp"

#include <algorithm>

#include "io/frames/cell_frames.hpp"
#include "io/frames/frame_sets.hpp"
#include "io/frames/vtkhdf.hpp"
#include "io/frames/vtu.hpp"
#include "io/run_directory/output_directory.hpp"
#include "io/run_directory/output_lock.hpp"
#include "io/tables/body_series.hpp"
#include "io/tables/gauge_series.hpp"
#include "io/tables/obstacle_series.hpp"
#include "io/tables/series.hpp"

namespace trevi {

namespace {

CheckpointOptions checkpoint_options(const OutputSettings& output, const WriterOptions& writer) {
  CheckpointOptions options;
  options.directory = writer.directory;
  options.info = writer.info;
  options.restart_step = writer.restart_step;
  options.when = output.checkpoint ? CheckpointTimes::scheduled : CheckpointTimes::asked_for;
  if (output.checkpoint) {
    options.schedule = output.checkpoint->schedule;
    options.keep = output.checkpoint->keep;
  }
  return options;
}

std::shared_ptr<const ObstacleSurfaces> obstacle_surfaces(const Settings& settings) {
  if (!has_solids(settings)) return nullptr;
  return std::make_shared<const ObstacleSurfaces>(solids_of(settings), settings.fluid.spacing / 50,
                                                  settings.bodies.size());
}

void add_tables(MPI_Comm comm, const Settings& settings, const WriterOptions& options,
                std::vector<std::unique_ptr<Observer>>& writers) {
  if (const std::optional<Schedule> gauges = schedule_of_gauges(settings))
    writers.push_back(
        std::make_unique<GaugeSeries>(comm, TableOptions{options.directory, *gauges, options.restart_step}, settings));
  if (!settings.output.series) return;
  const int fountains = static_cast<int>(settings.fountains.size() + settings.inlets.size());
  const bool flow = !settings.inlets.empty() || !settings.drains.empty();
  writers.push_back(std::make_unique<SeriesWriter>(
      comm, SeriesOptions{options.directory, *settings.output.series, fountains, options.restart_step, options.energy,
                          flow, is_supplied(settings)}));
  const TableOptions table{options.directory, *settings.output.series, options.restart_step};
  if (!settings.obstacles.empty())
    writers.push_back(std::make_unique<ObstacleSeries>(comm, table, settings.obstacles.size()));
  if (!settings.bodies.empty())
    writers.push_back(std::make_unique<BodySeries>(comm, table, settings.bodies.size(), settings.obstacles.size()));
}

FrameOptions frame_options(const Settings& settings, const WriterOptions& options, const FrameSettings& wanted,
                           const std::shared_ptr<const ObstacleSurfaces>& surfaces) {
  return {options.directory,    wanted.schedule, wanted.fields, colour_scale(settings, options.particles),
          options.restart_step, surfaces};
}

SelectionOptions selection_options(const Settings& settings, const FrameSetSettings& set) {
  SelectionOptions selection{settings.domain, set.box, thinning_of(set.one_in), std::nullopt};
  if (set.surface) selection.surface = settings.fluid.kernel_radius;
  return selection;
}

// Each set writes into its own folder.
void add_frame_set(MPI_Comm comm, const Settings& settings, std::size_t k, FrameOptions options,
                   std::vector<std::unique_ptr<Observer>>& writers) {
  const FrameSetSettings& set = settings.output.frames[k];
  options.directory += "/" + folder_of(set, k);
  if (set.what == FrameContent::cells) {
    const Real spacing = settings.fluid.spacing;
    writers.push_back(make_cell_frame_writer(comm, std::move(options), coarse_cells(settings, set), fields_of(set),
                                             spacing * spacing * spacing));
    return;
  }
  if (set.box || set.one_in > 1 || set.surface) options.selection.emplace(selection_options(settings, set));
  options.single_points = set.precision == Precision::single;
  options.short_cells = true;
  const auto make = set.format == FrameFormat::vtu ? make_vtu_writer : make_vtkhdf_writer;
  writers.push_back(make(comm, std::move(options)));
}

// Holds the lock of the folder during its lifetime.
class FolderLock : public Observer {
 public:
  FolderLock(MPI_Comm comm, const std::string& directory) : lock_(comm, directory) {}
  bool due(const Clock&) const override { return false; }
  void observe(const Frame&) override {}

 private:
  OutputLock lock_;
};

}  // namespace

std::vector<std::unique_ptr<Observer>> make_writers(MPI_Comm comm, const Settings& settings,
                                                    const WriterOptions& options) {
  std::vector<std::unique_ptr<Observer>> writers;
  add_tables(comm, settings, options, writers);
  const auto surfaces = obstacle_surfaces(settings);
  const auto frames = [&](const FrameSettings& wanted) { return frame_options(settings, options, wanted, surfaces); };
  if (settings.output.vtu) writers.push_back(make_vtu_writer(comm, frames(*settings.output.vtu)));
  if (settings.output.vtkhdf) writers.push_back(make_vtkhdf_writer(comm, frames(*settings.output.vtkhdf)));
  for (std::size_t k = 0; k < settings.output.frames.size(); ++k) {
    const FrameSetSettings& set = settings.output.frames[k];
    add_frame_set(comm, settings, k, frames({set.schedule, fields_of(set)}), writers);
  }
  writers.push_back(std::make_unique<CheckpointWriter>(comm, checkpoint_options(settings.output, options)));
  return writers;
}

std::vector<std::unique_ptr<Observer>> make_writers_and_folder(MPI_Comm comm, const Settings& settings,
                                                               const WriterOptions& options) {
  if (needs_vtk(settings.output)) require_vtk();
  // A run that continues may do so in its own folder.
  if (!options.restart_step) check_output_directory(comm, options.directory, std::nullopt);
  make_output_directory(comm, options.directory);
  auto lock = std::make_unique<FolderLock>(comm, options.directory);
  std::vector<std::unique_ptr<Observer>> writers = make_writers(comm, settings, options);
  writers.push_back(std::move(lock));
  return writers;
}

std::optional<Schedule> schedule_of_gauges(const Settings& settings) {
  if (settings.gauges.empty()) return std::nullopt;
  return settings.output.gauges ? settings.output.gauges : settings.output.series;
}

bool needs_vtk(const OutputSettings& output) {
  return output.vtu || std::any_of(output.frames.begin(), output.frames.end(),
                                   [](const auto& set) { return set.format == FrameFormat::vtu; });
}

ColourScale colour_scale(const Settings& settings, GlobalId particles) {
  ColourScale scale;
  if (settings.colour) scale.by = *settings.colour;
  scale.bottom = settings.domain.min.z();
  scale.top = settings.domain.max.z();
  for (const FountainSettings& fountain : settings.fountains)
    scale.speed_max = std::max(scale.speed_max, fountain.top_speed());
  for (const InletSettings& inlet : settings.inlets) scale.speed_max = std::max(scale.speed_max, inlet.top_speed());
  scale.total = particles;
  return scale;
}

bool is_supplied(const Settings& settings) {
  return !settings.fountains.empty() || !settings.inlets.empty() || !settings.drains.empty() ||
         !settings.bodies.empty() ||
         std::any_of(settings.obstacles.begin(), settings.obstacles.end(), [](const auto& one) { return one.moves(); });
}

}  // namespace trevi

// The observer that writes checkpoints when they are due, and removes old ones.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "io/hdf5/checkpoint.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

bool finite_everywhere(MPI_Comm comm, const Particles& particles) {
  const auto finite = [](const Vec3& row) { return row.allFinite(); };
  int good = std::all_of(particles.position.begin(), particles.position.end(), finite) &&
             std::all_of(particles.velocity.begin(), particles.velocity.end(), finite);
  MPI_Allreduce(MPI_IN_PLACE, &good, 1, MPI_INT, MPI_MIN, comm);
  return good != 0;
}

}  // namespace

std::vector<std::string> newest_checkpoints(MPI_Comm comm, const std::string& directory) {
  std::vector<std::int64_t> steps;
  on_root(comm, [&] {
    for (const SteppedFile& file : stepped_files(directory, checkpoint_files)) steps.insert(steps.begin(), file.step);
    if (!steps.empty()) return;
    throw InputError(directory + ": holds no checkpoint to restart from; name one with --restart FILE");
  });
  auto count = static_cast<int>(steps.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, comm);
  steps.resize(static_cast<std::size_t>(count));
  MPI_Bcast(steps.data(), count, MPI_INT64_T, 0, comm);
  std::vector<std::string> files;
  files.reserve(steps.size());
  for (const std::int64_t step : steps) files.push_back(directory + "/" + name_of_step(checkpoint_files, step));
  return files;
}

CheckpointWriter::CheckpointWriter(MPI_Comm comm, CheckpointOptions options)
    : comm_(comm), options_(std::move(options)) {
  if (!options_.restart_step) return;
  const std::int64_t step = *options_.restart_step;
  on_root(comm_, [&] {
    set_aside_after(options_.directory, checkpoint_files, step);
    if (std::filesystem::exists(path_of(step))) last_step_ = step;
  });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

bool CheckpointWriter::due(const Clock& clock) const {
  if (options_.when == CheckpointTimes::asked_for) return false;
  return clock.step != last_step_ && (clock.step == 0 || options_.schedule.due(clock));
}

void CheckpointWriter::write(const Frame& frame) {
  const ScopedEvent timed(event_);
  // A restart relies on the rows of these up to its checkpoint, so they must be on the disk before it is.
  on_root(comm_, [&] {
    for (const char* table : {"/series.csv", "/obstacles.csv", "/bodies.csv", "/gauges.csv"})
      sync_if_there(options_.directory + table);
  });
  write_checkpoint(comm_, path_of(frame.clock.step), options_.info, frame);
  last_step_ = frame.clock.step;
  on_root(comm_, [&] { remove_old(); });
}

void CheckpointWriter::save(const Frame& frame) {
  if (frame.clock.step != last_step_) write(frame);
}

void CheckpointWriter::finish(const Frame& frame) {
  if (options_.when == CheckpointTimes::asked_for) return;
  if (frame.clock.step != last_step_ && finite_everywhere(comm_, frame.particles)) write(frame);
}

std::string CheckpointWriter::path_of(std::int64_t step) const {
  return options_.directory + "/" + name_of_step(checkpoint_files, step);
}

void CheckpointWriter::remove_old() const {
  const auto files = stepped_files(options_.directory, checkpoint_files);
  const auto keep = static_cast<std::size_t>(std::max(1, options_.keep));
  for (std::size_t k = 0; k + keep < files.size(); ++k) {
    if (std::remove(files[k].path.c_str()) != 0) throw_file_error(files[k].path, "remove", errno);
  }
}

}  // namespace trevi

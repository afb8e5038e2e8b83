#include "trevi/output/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "trevi/base/error.hpp"
#include "trevi/output/collective.hpp"
#include "trevi/output/files.hpp"
#include "trevi/output/hdf5_writer.hpp"
#include "trevi/output/id_order.hpp"

namespace trevi {

namespace {

constexpr const char* prefix = "checkpoint_";
constexpr const char* suffix = ".h5";

void write_header(Hdf5Writer& file, const CheckpointInfo& info, const Frame& frame) {
  file.attribute("step", frame.clock.step);
  file.attribute("time", frame.clock.time());
  file.attribute("dt", frame.clock.dt);
  file.attribute("substeps", static_cast<std::int64_t>(frame.clock.substeps));
  file.attribute("seed", info.seed);
  file.attribute("program_version", info.program_version);
  if (!frame.fountains.empty()) {
    std::vector<Real> notes, speeds;
    for (const FountainState& fountain : frame.fountains) {
      notes.push_back(fountain.note);
      speeds.push_back(fountain.speed);
    }
    file.attribute("fountain_note", std::span<const Real>(notes));
    file.attribute("fountain_speed", std::span<const Real>(speeds));
  }
  file.text("/scene", info.scene_text);
}

void write_particles(MPI_Comm comm, Hdf5Writer& file, const Particles& particles) {
  // Whole chunks per rank: a chunk that two ranks share would have to travel between them to be summed.
  const IdOrder order(comm, particles.id, rows_per_chunk);
  const RowSlice slice{order.first_row(), static_cast<std::int64_t>(order.ids().size()), order.total()};
  file.write("/particles/id", order.ids(), slice);
  file.write("/particles/position", order.apply(particles.position), slice);
  file.write("/particles/velocity", order.apply(particles.velocity), slice);
  if (particles.has_hue) file.write("/particles/hue", order.apply(particles.hue), slice);
}

bool finite_everywhere(MPI_Comm comm, const Particles& particles) {
  const auto finite = [](const Vec3& row) { return row.allFinite(); };
  int good = std::all_of(particles.position.begin(), particles.position.end(), finite) &&
             std::all_of(particles.velocity.begin(), particles.velocity.end(), finite);
  MPI_Allreduce(MPI_IN_PLACE, &good, 1, MPI_INT, MPI_MIN, comm);
  return good != 0;
}

CheckpointState read_slice(const std::string& path, int rank, int size) {
  const Hdf5Reader file(path);
  for (const char* name : {"/particles/id", "/particles/velocity"}) {
    if (file.has(name)) continue;
    throw InputError(fmt::format("{}: {}: missing; a restart needs a whole checkpoint, use another file", path, name));
  }
  CheckpointState state;
  state.step = file.integer_attribute("step");
  state.dt = file.real_attribute("dt");
  state.time = file.real_attribute("time");
  state.substeps = static_cast<int>(file.integer_attribute("substeps"));
  state.info.seed = file.integer_attribute("seed");
  state.info.program_version = file.text_attribute("program_version");
  state.info.scene_text = file.text("/scene");
  state.rows = read_particle_rows(file, rank, size);
  return state;
}

}  // namespace

void write_checkpoint(MPI_Comm comm, const std::string& path, const CheckpointInfo& info, const Frame& frame) {
  const std::string temporary = path + ".tmp";
  try {
    Hdf5Writer file(comm, temporary, Storage::contiguous);
    write_header(file, info, frame);
    write_particles(comm, file, frame.particles);
    file.close();
  } catch (const Error&) {  // thrown by all ranks alike
    if (rank_of(comm) == 0) std::remove(temporary.c_str());
    throw;
  }
  on_root(comm, [&] { publish_file(temporary, path); });
}

CheckpointState read_checkpoint(MPI_Comm comm, const std::string& path) {
  CheckpointState state;
  all_or_none(comm, [&] { state = read_slice(path, rank_of(comm), size_of(comm)); });
  check_particle_rows(comm, state.rows, path);
  return state;
}

std::string latest_checkpoint(MPI_Comm comm, const std::string& directory) {
  std::int64_t step = -1;
  on_root(comm, [&] {
    const auto files = stepped_files(directory, prefix, suffix);
    if (files.empty()) {
      throw InputError(directory + ": holds no checkpoint to restart from; name one with --restart FILE");
    }
    step = files.back().step;
  });
  MPI_Bcast(&step, 1, MPI_INT64_T, 0, comm);
  return directory + "/" + prefix + step_digits(step) + suffix;
}

CheckpointWriter::CheckpointWriter(MPI_Comm comm, CheckpointOptions options)
    : comm_(comm), options_(std::move(options)) {
  if (!options_.restart_step) return;
  const std::int64_t step = *options_.restart_step;
  on_root(comm_, [&] {
    set_aside_after(options_.directory, prefix, suffix, step);
    if (std::filesystem::exists(path_of(step))) last_step_ = step;
  });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

bool CheckpointWriter::due(const Clock& clock) const {
  return clock.step != last_step_ && (clock.step == 0 || options_.schedule.due(clock));
}

void CheckpointWriter::write(const Frame& frame) {
  write_checkpoint(comm_, path_of(frame.clock.step), options_.info, frame);
  last_step_ = frame.clock.step;
  on_root(comm_, [&] { remove_old(); });
}

void CheckpointWriter::finish(const Frame& frame) {
  if (frame.clock.step != last_step_ && finite_everywhere(comm_, frame.particles)) write(frame);
}

std::string CheckpointWriter::path_of(std::int64_t step) const {
  return options_.directory + "/" + prefix + step_digits(step) + suffix;
}

void CheckpointWriter::remove_old() const {
  const auto files = stepped_files(options_.directory, prefix, suffix);
  const auto keep = static_cast<std::size_t>(std::max(1, options_.keep));
  for (std::size_t k = 0; k + keep < files.size(); ++k) {
    if (std::remove(files[k].path.c_str()) != 0) throw_file_error(files[k].path, "remove", errno);
  }
}

}  // namespace trevi

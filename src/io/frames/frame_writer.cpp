#include "io/frames/frame_writer.hpp"

#include <algorithm>
#include <filesystem>

#include "base/threads.hpp"
#include "parallel/collective.hpp"

namespace trevi {

FrameWriter::FrameWriter(MPI_Comm comm, FrameOptions options, FrameFiles files)
    : comm_(comm),
      options_(std::move(options)),
      files_(std::move(files)),
      event_(files_.event),
      fields_(frame_fields(options_.fields)) {
  on_root(comm_, [&] { open(); });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

void FrameWriter::open() {
  const std::string folder = options_.directory + "/" + files_.folder;
  std::filesystem::create_directories(folder);
  for (const SteppedName& kind : files_.kinds) {
    if (options_.restart_step) set_aside_after(folder, kind, *options_.restart_step);
  }
  list_.emplace(options_.directory + "/" + files_.list, options_.restart_step);
  last_step_ = list_->last_step();
  const bool own_list = files_.list != vtu_list;
  if (options_.obstacles) obstacles_.emplace(options_.obstacles, folder, own_list, options_.restart_step);
}

bool FrameWriter::wants_density() const {
  return std::any_of(fields_.begin(), fields_.end(),
                     [](const OutputField* field) { return field->needs == FieldNeeds::density; });
}

Rows FrameWriter::rows_of(const OutputField& field, const Frame& frame) const {
  return field.rows({frame, options_.colour, rank_of(comm_)});
}

Rows point_rows(const std::vector<Vec3>& points, bool single) {
  if (!single) return {Rows(), points.data()};
  using Floats3 = std::array<float, 3>;
  auto rows = std::make_shared<std::vector<Floats3>>(points.size());
  for_each_index({0, static_cast<LocalId>(points.size())}, [to = rows->data(), from = points.data()](std::size_t i) {
    for (const int a : {0, 1, 2}) to[i][static_cast<std::size_t>(a)] = static_cast<float>(from[i][a]);
  });
  return {rows, rows->data()};
}

void FrameWriter::write_selected(const Frame& frame, const std::string& path) {
  if (!options_.selection) return write(frame, path);
  const SelectedFrame selected = options_.selection->select(comm_, frame);
  write({frame.clock, selected.particles, selected.density, nullptr, frame.fountains}, path);
}

void FrameWriter::observe(const Frame& frame) {
  const ScopedEvent timed(event_);
  const std::string name = files_.folder + name_of_step(files_.kinds.front(), frame.clock.step);
  write_selected(frame, options_.directory + "/" + name);
  on_root(comm_, [&] {
    std::vector<std::string> others;
    if (obstacles_) others = obstacles_->write(frame.clock, frame.bodies);
    for (std::string& other : others) other = files_.folder + other;
    list_->add(frame.clock, name, others);
  });
  last_step_ = frame.clock.step;
}

}  // namespace trevi

#include "io/obstacle_series.hpp"

#include <fmt/format.h>

#include "io/kept_rows.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

std::string header_for(int obstacles) {
  std::string header = "step,time";
  for (int k = 0; k < obstacles; ++k)
    header += fmt::format(",force_x_{0},force_y_{0},force_z_{0},torque_x_{0},torque_y_{0},torque_z_{0}", k);
  return header + ",box_force_x,box_force_y,box_force_z";
}

std::string numbers(const Vec3& v) { return fmt::format(",{},{},{}", v.x(), v.y(), v.z()); }

}  // namespace

ObstacleSeries::ObstacleSeries(MPI_Comm comm, ObstacleSeriesOptions options)
    : comm_(comm), options_(std::move(options)) {
  on_root(comm_, [&] { open(); });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

void ObstacleSeries::open() {
  const std::string path = options_.directory + "/obstacles.csv";
  last_step_ = begin_table(path, header_for(options_.obstacles), options_.restart_step).last_step;
  file_.emplace(path);
}

void ObstacleSeries::observe(const Frame& frame) {
  require(!frame.forces.empty(), "obstacles.csv: no forces in this frame");
  std::string row = fmt::format("{},{}", frame.clock.step, frame.clock.time());
  for (std::size_t k = 0; k + 1 < frame.forces.size(); ++k)
    row += numbers(frame.forces[k].force) + numbers(frame.forces[k].torque);
  row += numbers(frame.forces.back().force) + "\n";
  on_root(comm_, [&] { file_->write(row); });
  last_step_ = frame.clock.step;
}

}  // namespace trevi

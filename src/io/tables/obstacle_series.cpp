#include "io/tables/obstacle_series.hpp"

#include <fmt/format.h>

#include "trevi/error.hpp"

namespace trevi {

namespace {

std::string columns_for(std::size_t obstacles) {
  std::string columns;
  for (std::size_t k = 0; k < obstacles; ++k)
    columns += fmt::format(",force_x_{0},force_y_{0},force_z_{0},torque_x_{0},torque_y_{0},torque_z_{0}", k);
  return columns + ",box_force_x,box_force_y,box_force_z";
}

std::string numbers(const Vec3& v) { return fmt::format(",{},{},{}", v.x(), v.y(), v.z()); }

}  // namespace

ObstacleSeries::ObstacleSeries(MPI_Comm comm, const TableOptions& options, std::size_t obstacles)
    : TableSeries(comm, options, "obstacles.csv", columns_for(obstacles)), obstacles_(obstacles) {}

void ObstacleSeries::observe(const Frame& frame) {
  require(!frame.forces.empty(), "obstacles.csv: no forces in this frame");
  std::string row;
  for (std::size_t k = 0; k < obstacles_; ++k) row += numbers(frame.forces[k].force) + numbers(frame.forces[k].torque);
  write(frame.clock, row + numbers(frame.forces.back().force));
}

}  // namespace trevi

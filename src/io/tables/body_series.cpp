#include "io/tables/body_series.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trevi/error.hpp"

namespace trevi {

namespace {

std::string body_columns(std::size_t bodies) {
  std::string columns;
  for (std::size_t k = 0; k < bodies; ++k)
    columns += fmt::format(
        ",x_{0},y_{0},z_{0},qw_{0},qx_{0},qy_{0},qz_{0},vx_{0},vy_{0},vz_{0},wx_{0},wy_{0},wz_{0},force_x_{0},"
        "force_y_{0},force_z_{0},torque_x_{0},torque_y_{0},torque_z_{0}",
        k);
  return columns;
}

std::string body_numbers(const Vec3& v) { return fmt::format(",{},{},{}", v.x(), v.y(), v.z()); }

}  // namespace

BodySeries::BodySeries(MPI_Comm comm, const TableOptions& options, std::size_t bodies, std::size_t first)
    : TableSeries(comm, options, "bodies.csv", body_columns(bodies)), first_(first) {}

void BodySeries::observe(const Frame& frame) {
  require(frame.forces.size() > first_ + frame.bodies.size(), "bodies.csv: no forces in this frame");
  std::string row;
  for (std::size_t k = 0; k < frame.bodies.size(); ++k) {
    const BodyState& body = frame.bodies[k];
    row += body_numbers(body.position) + fmt::format(",{}", fmt::join(body.orientation, ",")) +
           body_numbers(body.velocity) + body_numbers(body.angular_velocity);
    row += body_numbers(frame.forces[first_ + k].force) + body_numbers(frame.forces[first_ + k].torque);
  }
  write(frame.clock, row);
}

}  // namespace trevi

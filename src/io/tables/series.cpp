#include "io/tables/series.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <utility>

#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr const char* fixed_columns =
    "step,time,dt,substeps,particles,iterations,density_mean,density_max,density_interior,compression_mean,"
    "compression_max,compression_rms,kinetic_energy,potential_energy,momentum_x,momentum_y,momentum_z,com_x,com_y,"
    "com_z,speed_max,top,front,front_q99,drift_max,imbalance,wall_seconds";

std::string number(Real value) {
  // The sign of a nan depends on how it was produced; a column must not.
  return std::isnan(value) ? "nan" : fmt::format("{}", value);
}

std::string row(const Frame& frame, const SeriesOptions& options, Real wall_seconds_before) {
  const Clock& clock = frame.clock;
  const Diagnostics& d = *frame.diagnostics;
  std::string text = fmt::format("{},{},{},{},{},{}", clock.step, number(clock.time()), number(clock.dt),
                                 clock.substeps, d.particles, d.iterations);
  for (const Real value : {d.density_mean,
                           d.density_max,
                           d.density_interior,
                           d.compression_mean,
                           d.compression_max,
                           d.compression_rms,
                           d.kinetic_energy,
                           d.potential_energy,
                           d.momentum.x(),
                           d.momentum.y(),
                           d.momentum.z(),
                           d.com.x(),
                           d.com.y(),
                           d.com.z(),
                           d.speed_max,
                           d.top,
                           d.front,
                           d.front_q99,
                           d.drift_max,
                           d.imbalance,
                           wall_seconds_before + d.wall_seconds}) {
    text += "," + number(value);
  }
  for (const FountainState& fountain : frame.fountains) {
    text += "," + number(fountain.note) + "," + number(fountain.speed);
  }
  if (frame.flow != nullptr)
    text += fmt::format(",{},{},{}", frame.flow->inflow, frame.flow->outflow, frame.flow->waiting);
  if (options.supplied) text += "," + number(frame.supplied_energy);
  return text + "\n";
}

/// One of the fixed columns of a row, by its name.
Real column_of(const std::string& row, std::string_view name) {
  const std::string columns = std::string(",") + fixed_columns + ",";
  const std::size_t index = columns.find(fmt::format(",{},", name));
  std::size_t begin = 0;
  for (const char c : columns.substr(1, index)) {
    if (c == ',') begin = row.find(',', begin) + 1;
  }
  return std::strtod(row.c_str() + begin, nullptr);
}

}  // namespace

std::string series_header(int fountains, bool flow, bool supplied) {
  std::string header = fixed_columns;
  for (int k = 0; k < fountains; ++k) header += fmt::format(",note_{0},speed_{0}", k);
  if (flow) header += ",inflow,outflow,waiting";
  return supplied ? header + ",supplied_energy" : header;
}

SeriesWriter::SeriesWriter(MPI_Comm comm, SeriesOptions options) : comm_(comm), options_(std::move(options)) {
  on_root(comm_, [&] { open(); });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
  if (options_.energy) MPI_Bcast(options_.energy.get(), sizeof(EnergyRise), MPI_BYTE, 0, comm_);
}

void SeriesWriter::open() {
  table_.emplace(options_.directory + "/series.csv",
                 series_header(options_.fountains, options_.flow, options_.supplied), options_.restart_step);
  const KeptRows& kept = table_->kept();
  last_step_ = kept.last_step;
  if (!kept.last_row.empty()) wall_seconds_before_ = column_of(kept.last_row, "wall_seconds");
  if (options_.energy) recall(kept.text);
}

// The start of a continued run is the first row of its file.
void SeriesWriter::recall(const std::string& rows) {
  std::istringstream lines(rows);
  std::string line;
  std::getline(lines, line);  // the header
  while (std::getline(lines, line)) {
    Diagnostics row;
    row.particles = std::llround(column_of(line, "particles"));
    row.compression_max = column_of(line, "compression_max");
    row.kinetic_energy = column_of(line, "kinetic_energy");
    row.potential_energy = column_of(line, "potential_energy");
    options_.energy->add(row, options_.supplied ? std::strtod(line.c_str() + line.rfind(',') + 1, nullptr) : 0);
  }
}

void SeriesWriter::observe(const Frame& frame) {
  require(frame.diagnostics != nullptr, "series.csv: no diagnostics in this frame");
  on_root(comm_, [&] { table_->write(row(frame, options_, wall_seconds_before_)); });
  Real of_bodies = 0;
  for (const BodyState& body : frame.bodies)
    of_bodies += (body.momentum.dot(body.velocity) + body.angular_momentum.dot(body.angular_velocity)) / 2;
  if (options_.energy) options_.energy->add(*frame.diagnostics, frame.supplied_energy, of_bodies);
  last_step_ = frame.clock.step;
}

}  // namespace trevi

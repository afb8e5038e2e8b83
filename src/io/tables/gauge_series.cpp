#include "io/tables/gauge_series.hpp"

#include <fmt/format.h>

namespace trevi {

namespace {

std::string columns_for(const GaugeReadings& readings) {
  std::string columns;
  for (const std::string& column : readings.columns()) columns += "," + column;
  return columns;
}

}  // namespace

GaugeSeries::GaugeSeries(MPI_Comm comm, const TableOptions& options, const Settings& settings)
    : TableSeries(comm, options, "gauges.csv", columns_for({comm, settings})), readings_(comm, settings) {}

void GaugeSeries::observe(const Frame& frame) {
  std::string row;
  for (const Real value : readings_.read(frame)) row += fmt::format(",{}", value);
  write(frame.clock, row);
}

}  // namespace trevi

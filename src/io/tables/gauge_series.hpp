// gauges.csv: the readings of the gauges of a scene, one row for each due step; columns as in postprocess/README.md.
// Collective.
#pragma once

#include "io/tables/gauge_readings.hpp"
#include "io/tables/table_series.hpp"

namespace trevi {

class GaugeSeries : public TableSeries {
 public:
  /// The gauges of these settings.
  GaugeSeries(MPI_Comm comm, const TableOptions& options, const Settings& settings);
  bool wants_pressures() const override { return readings_.wants_pressures(); }
  void observe(const Frame& frame) override;

 private:
  GaugeReadings readings_;
};

}  // namespace trevi

// gauges.csv: what the gauges of a scene show, a row for each due step; columns as in postprocess/README.md.
// Collective.
#pragma once

#include <vector>

#include "base/threads.hpp"
#include "io/tables/table_series.hpp"
#include "trevi/settings.hpp"

namespace trevi {

class GaugeSeries : public TableSeries {
 public:
  /// The gauges of these settings.
  GaugeSeries(MPI_Comm comm, const TableOptions& options, const Settings& settings);
  bool wants_forces() const override { return pressures_; }
  void observe(const Frame& frame) override;

 private:
  std::vector<std::int64_t> sums(const Particles& particles);

  std::vector<GaugeSettings> gauges_;
  std::vector<std::size_t> first_;  // of the sums of each gauge; one more at the end
  Real spacing_;                    // m, the edge of a particle's cube
  bool pressures_;                  // whether there are gauges of pressure
  std::vector<Real> open_;          // of gauges of height: the fraction of the disc that is in the box
  PerThread<std::vector<std::int64_t>> sums_;
};

}  // namespace trevi

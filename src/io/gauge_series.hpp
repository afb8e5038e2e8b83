// gauges.csv: what the gauges of a scene show, a row for each due step; columns as in postprocess/README.md. Rank 0
// writes. Collective.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/threads.hpp"
#include "io/files.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

struct GaugeSeriesOptions {
  std::string directory;
  Schedule schedule;
  std::vector<GaugeSettings> gauges;
  Box box;
  Real spacing = 0;                          ///< m, the edge of a particle's cube
  std::optional<std::int64_t> restart_step;  ///< append, after dropping rows past it
};

class GaugeSeries : public Observer {
 public:
  GaugeSeries(MPI_Comm comm, GaugeSeriesOptions options);
  bool due(const Clock& clock) const override { return clock.step > last_step_ && options_.schedule.due(clock); }
  bool wants_forces() const override { return pressures_; }
  void observe(const Frame& frame) override;

 private:
  void open();
  std::vector<Real> heights(const Particles& particles);

  MPI_Comm comm_;
  GaugeSeriesOptions options_;
  bool pressures_;            // whether there are gauges of pressure
  std::vector<Real> volume_;  // of a particle over the share of the disc that is in the box, m³; by the gauge
  PerThread<std::vector<std::int64_t>> sums_;
  std::optional<AppendFile> file_;  ///< rank 0 only
  std::int64_t last_step_ = -1;     ///< of the last row in the file
};

}  // namespace trevi

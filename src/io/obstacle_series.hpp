// obstacles.csv: what the water did to each obstacle and to the box, a row for each due step; columns as in
// postprocess/README.md. Rank 0 writes. Collective.
#pragma once

#include <optional>
#include <string>

#include "io/files.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct ObstacleSeriesOptions {
  std::string directory;
  Schedule schedule;
  int obstacles = 0;
  std::optional<std::int64_t> restart_step;  ///< append, after dropping rows past it
};

class ObstacleSeries : public Observer {
 public:
  ObstacleSeries(MPI_Comm comm, ObstacleSeriesOptions options);
  bool due(const Clock& clock) const override { return clock.step > last_step_ && options_.schedule.due(clock); }
  bool wants_forces() const override { return true; }
  void observe(const Frame& frame) override;

 private:
  void open();

  MPI_Comm comm_;
  ObstacleSeriesOptions options_;
  std::optional<AppendFile> file_;  ///< rank 0 only
  std::int64_t last_step_ = -1;     ///< of the last row in the file
};

}  // namespace trevi

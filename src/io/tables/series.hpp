// series.csv: one row of diagnostics per due step; columns as in postprocess/README.md. Invariant: rows are complete
// and in the order of their steps; numbers read back to the same bits (nan as `nan`). Rank 0 writes and hands each row
// to the system at once, so a killed run keeps its rows. Collective.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "io/tables/energy_rise.hpp"
#include "io/tables/table.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct SeriesOptions {
  std::string directory;
  Schedule schedule;
  int fountains = 0;                         ///< each adds note_<k>, speed_<k>, k from 0; inlets are counted last
  std::optional<std::int64_t> restart_step;  ///< append, after dropping rows past it
  std::shared_ptr<EnergyRise> energy =
      nullptr;            ///< receives all rows, including those from before a restart; may be null
  bool flow = false;      ///< inlets or drains add inflow, outflow, waiting
  bool supplied = false;  ///< whether there is a column of the energy supplied
};

/// The header line without its newline: the fixed columns, then two for each fountain, those of inlets and drains, and
/// the energy supplied.
std::string series_header(int fountains, bool flow = false, bool supplied = false);

class SeriesWriter : public Observer {
 public:
  /// RunError if the file cannot be written; InputError if it is to be continued but has other columns.
  SeriesWriter(MPI_Comm comm, SeriesOptions options);

  bool due(const Clock& clock) const override { return clock.step > last_step_ && options_.schedule.due(clock); }
  bool wants_diagnostics() const override { return true; }
  void observe(const Frame& frame) override;

 private:
  void open();
  void recall(const std::string& rows);

  MPI_Comm comm_;
  SeriesOptions options_;
  std::optional<Table> table_;    ///< rank 0 only
  std::int64_t last_step_ = -1;   ///< of the last row in the file
  Real wall_seconds_before_ = 0;  ///< of that row: what the run took before a restart
};

}  // namespace trevi

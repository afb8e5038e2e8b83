// A table in the run's folder besides series.csv: one row for each due step. Rank 0 writes. Collective.
#pragma once

#include <optional>
#include <string>

#include "io/tables/table.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct TableOptions {
  std::string directory;
  Schedule schedule;
  std::optional<std::int64_t> restart_step;  ///< append, after dropping rows past it
};

class TableSeries : public Observer {
 public:
  bool due(const Clock& clock) const override { return clock.step > last_step_ && schedule_.due(clock); }

 protected:
  /// `columns` follow step and time, each preceded by a comma. InputError if a file that is to be continued has
  /// different ones.
  TableSeries(MPI_Comm comm, const TableOptions& options, const std::string& name, const std::string& columns);
  void write(const Clock& clock, const std::string& values);
  MPI_Comm comm() const { return comm_; }

 private:
  MPI_Comm comm_;
  Schedule schedule_;
  std::optional<Table> table_;   ///< rank 0 only
  std::int64_t last_step_ = -1;  ///< of the last row in the file
};

}  // namespace trevi

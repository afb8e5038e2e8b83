#include "io/table_series.hpp"

#include <fmt/format.h>

#include "io/kept_rows.hpp"
#include "parallel/collective.hpp"

namespace trevi {

TableSeries::TableSeries(MPI_Comm comm, const TableOptions& options, const std::string& name,
                         const std::string& columns)
    : comm_(comm), schedule_(options.schedule) {
  on_root(comm_, [&] {
    const std::string path = options.directory + "/" + name;
    last_step_ = begin_table(path, "step,time" + columns, options.restart_step).last_step;
    file_.emplace(path);
  });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

void TableSeries::write(const Clock& clock, const std::string& values) {
  on_root(comm_, [&] { file_->write(fmt::format("{},{}{}\n", clock.step, clock.time(), values)); });
  last_step_ = clock.step;
}

}  // namespace trevi

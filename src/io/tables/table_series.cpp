#include "io/tables/table_series.hpp"

#include <fmt/format.h>

#include "parallel/collective.hpp"

namespace trevi {

TableSeries::TableSeries(MPI_Comm comm, const TableOptions& options, const std::string& name,
                         const std::string& columns)
    : comm_(comm), schedule_(options.schedule) {
  on_root(comm_, [&] {
    table_.emplace(options.directory + "/" + name, "step,time" + columns, options.restart_step);
    last_step_ = table_->kept().last_step;
  });
  MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
}

void TableSeries::write(const Clock& clock, const std::string& values) {
  on_root(comm_, [&] { table_->write(fmt::format("{},{}{}\n", clock.step, clock.time(), values)); });
  last_step_ = clock.step;
}

}  // namespace trevi

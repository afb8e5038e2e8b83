// obstacles.csv: what the water did to each obstacle and to the box, one row for each due step; columns as in
// postprocess/README.md. Collective.
#pragma once

#include "io/tables/table_series.hpp"

namespace trevi {

class ObstacleSeries : public TableSeries {
 public:
  ObstacleSeries(MPI_Comm comm, const TableOptions& options, std::size_t obstacles);
  bool wants_forces() const override { return true; }
  void observe(const Frame& frame) override;

 private:
  std::size_t obstacles_;
};

}  // namespace trevi

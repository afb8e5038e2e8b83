// bodies.csv: positions and motion of the freely moving bodies, and what the water did to them, one row for each due
// step; columns as in postprocess/README.md. Collective.
#pragma once

#include "io/tables/table_series.hpp"

namespace trevi {

class BodySeries : public TableSeries {
 public:
  /// `first`: the number of forces before those on bodies.
  BodySeries(MPI_Comm comm, const TableOptions& options, std::size_t bodies, std::size_t first);
  bool wants_forces() const override { return true; }
  void observe(const Frame& frame) override;

 private:
  std::size_t first_;
};

}  // namespace trevi

// The solver as Python holds it, and the rows that it keeps.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "trevi/solver.hpp"

namespace trevi::python {

/// Rows of series.csv, obstacles.csv and gauges.csv in memory, column by column, with the same names.
using Table = std::map<std::string, std::vector<Real>>;
struct Record {
  Table series, obstacles, gauges;
};

/// Keeps a row at each due step. Collective, as every Observer.
std::unique_ptr<Observer> make_recorder(MPI_Comm comm, const Settings& settings, const Schedule& schedule,
                                        std::shared_ptr<Record> record);

/// A callable f(water, step) as a forcing, which pushes up to that speed, m/s.
std::unique_ptr<Forcing> make_forcing(py::function call, Real fastest);

/// An array (n, 3) or (n) over memory of somebody else's.
py::array view_of(const std::vector<Vec3>& rows, const py::object& owner, bool writable);
py::array view_of(const std::vector<GlobalId>& rows, const py::object& owner, bool writable);

/// Before the session ends: a solver that Python still holds is of no use from then on.
void close_all_solvers();

}  // namespace trevi::python

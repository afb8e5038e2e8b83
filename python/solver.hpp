// The solver as Python holds it, and the rows that it keeps.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "trevi/solver.hpp"

namespace trevi::python {

/// Rows of series.csv, obstacles.csv, bodies.csv and gauges.csv in memory, column by column, with the same names.
using Table = std::map<std::string, std::vector<Real>>;
struct Record {
  Table series, obstacles, bodies, gauges;
};

/// Keeps a row at each due step. Collective, as every Observer.
std::unique_ptr<Observer> make_recorder(MPI_Comm comm, const Settings& settings, const Schedule& schedule,
                                        std::shared_ptr<Record> record);

/// A callable f(water, step) as a forcing, which pushes up to that speed, m/s.
std::unique_ptr<Forcing> make_forcing(py::function call, Real fastest);

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids = py::array_t<GlobalId, py::array::c_style | py::array::forcecast>;

/// A copy of an array, which must be (n, 3).
std::vector<Vec3> rows_of(const Rows& array, const char* name);

/// An array (n, 3) or (n) over memory of somebody else's.
py::array view_of(const std::vector<Vec3>& rows, const py::object& owner, bool writable);
py::array view_of(const std::vector<GlobalId>& rows, const py::object& owner, bool writable);

/// Arrays to be changed between two steps; the solver takes them over at the end of a with block.
struct Change {
  py::object positions, velocities, ids;
};

/// A solver, its rows, and the change that Python makes to its particles. Collective, but for what is const.
class PySolver {
 public:
  /// `scene`: of the settings, or null.
  PySolver(MPI_Comm comm, const Settings& settings, const Scene* scene, Particles particles, SolverExtras extras,
           std::optional<Schedule> rows);
  PySolver(const PySolver&) = delete;
  PySolver& operator=(const PySolver&) = delete;
  ~PySolver();

  void step();
  /// Files get their end, but for those of a run that failed.
  void close();
  /// RunError for a solver that is closed.
  Solver& get() const;
  const Settings& settings() const { return settings_; }
  const Record& record() const { return *record_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  MPI_Comm comm() const { return comm_; }

  std::optional<Change> change;  ///< within a with block
  std::optional<Real> end;       ///< of the scene, s

 private:
  Settings settings_;
  std::shared_ptr<Record> record_;
  int rank_, size_;
  MPI_Comm comm_;
  bool has_files_ = false, is_fine_ = true;
  std::unique_ptr<Solver> solver_;
};

/// On rank 0 the rows of all particles in the order of their ids; None on the others. Collective.
py::object gathered(const PySolver& self, const std::vector<Vec3> Particles::*field);

/// What `with solver.change():` does before and after its block. The latter is collective.
void begin_change(PySolver& self);
void end_change(PySolver& self, bool keep);

py::dict as_arrays(const Table& table);
/// A dict for each obstacle, each body: where it is now, and the forces of the last row.
py::list obstacles_of(const PySolver& self);
py::list bodies_of(const PySolver& self);

/// Before the session ends: a solver that Python still holds is of no use from then on.
void close_all_solvers();

}  // namespace trevi::python

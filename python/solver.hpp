// The solver as Python holds it, and the rows that it keeps.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
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

/// Callables f(water, step) as forcings; InputError for what is none.
std::vector<std::unique_ptr<Forcing>> forcings_of(const py::object& calls);

/// A copy of an array, which must be of real numbers and of shape (n, 3); InputError otherwise.
std::vector<Vec3> rows_of(const py::object& array, const char* name);
/// A copy of an array (n) of whole numbers from 0 and below 2^62; InputError otherwise.
std::vector<GlobalId> ids_of(const py::object& array);

/// An array (n, 3) or (n) over memory of somebody else's.
py::array view_of(const std::vector<Vec3>& rows, const py::object& owner, bool writable);
py::array view_of(const std::vector<GlobalId>& rows, const py::object& owner, bool writable);

/// Arrays to be changed between two steps; the solver takes them over at the end of a with block.
struct Change {
  py::object positions, velocities, ids;
  std::array<py::object, 3> lent;  ///< the same, until the script puts its own in their place
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

  /// RunError within a forcing of its own, InputError within a change.
  void step();
  /// Files get their end, but for those of a run that failed. Views of the particles stay valid.
  void close();
  /// RunError within a forcing of this solver, which has lent its particles.
  void refuse_within_forcing(const char* call) const;
  /// The same, and InputError within a change.
  void refuse_within(const char* call) const;
  /// The largest of what the ranks give.
  std::int64_t agree(std::int64_t mine) const;
  /// What a view of the particles must hold: the solver, and their memory once that is closed.
  py::object keeper(const py::object& self) const;
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
  bool has_files_ = false, is_fine_ = true, is_in_step_ = false;
  std::unique_ptr<Solver> solver_;
  std::shared_ptr<Particles> kept_ = std::make_shared<Particles>();  ///< when it is closed, for views
};

/// What make_solver() of Python is called with.
struct SolverArguments {
  py::object settings, positions, velocities, ids, forcings, rows, comm;
};

/// What must be the same on all ranks, by its name, as a number.
using Marks = std::vector<std::pair<std::string, std::int64_t>>;

/// InputError on all ranks alike for what is wrong on any. Collective.
std::unique_ptr<PySolver> make_py_solver(const SolverArguments& given, const Marks& marks);

/// On rank 0 the rows of all particles in the order of their ids; None on the others. Collective.
py::object gathered(const PySolver& self, const std::vector<Vec3> Particles::*field);

/// What `with solver.change():` does before and after its block; keep: unless it failed here. The latter is collective.
void begin_change(PySolver& self);
void end_change(PySolver& self, bool keep);

py::dict as_arrays(const Table& table);
/// A dict for each obstacle, each body: where it is now, and the forces of the last row.
py::list obstacles_of(const PySolver& self);
py::list bodies_of(const PySolver& self);

/// Before the session ends: a solver that Python still holds is of no use from then on.
void close_all_solvers();

}  // namespace trevi::python

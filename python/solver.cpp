#include "solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <numeric>

#include "boundary/geometry/pose.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi::python {

namespace {

py::array over(py::array array, bool writable) {
  if (!writable) array.attr("flags").attr("writeable") = false;
  return array;
}

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Ids = py::array_t<GlobalId, py::array::c_style | py::array::forcecast>;

std::vector<Vec3> rows_of(const Rows& array, const char* name) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw InputError(fmt::format("{}: must be an array of shape (n, 3)", name));
  std::vector<Vec3> rows(static_cast<std::size_t>(array.shape(0)));
  if (!rows.empty()) std::memcpy(rows[0].data(), array.data(), rows.size() * sizeof(Vec3));
  return rows;
}

/// What a callable sees of the particles: valid during the call.
struct Water {
  Particles* particles;
};

class OwnForcing : public Forcing {
 public:
  OwnForcing(py::function call, Real fastest) : call_(std::move(call)), fastest_(fastest) {}
  void apply(Particles& particles, const StepInfo& step) override { call_(Water{&particles}, step); }
  Real fastest(const TimeSpan&) const override { return fastest_; }

 private:
  py::function call_;
  Real fastest_;
};

/// Arrays to be changed between two steps; the solver takes them over at the end of a with block.
struct Change {
  py::object positions, velocities, ids;
};

class PySolver;
std::vector<PySolver*> alive;  // in the order in which they were made

class PySolver {
 public:
  /// `scene`: of the settings, or null.
  PySolver(MPI_Comm comm, const Settings& settings, const Scene* scene, Particles particles, SolverExtras extras,
           std::optional<Schedule> rows)
      : settings_(settings), record_(std::make_shared<Record>()) {
    if (rows) extras.observers.push_back(make_recorder(comm, settings, *rows, record_));
    rank_ = rank_of(comm);
    size_ = size_of(comm);
    comm_ = comm;
    solver_ = scene != nullptr ? make_solver(comm, *scene, std::move(particles), std::move(extras))
                               : make_solver(comm, settings, std::move(particles), std::move(extras));
    has_files_ = !settings.output.directory.empty();
    solver_->start();
    alive.push_back(this);
  }
  PySolver(const PySolver&) = delete;
  PySolver& operator=(const PySolver&) = delete;
  ~PySolver() {
    std::erase(alive, this);
    try {
      close();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "trevi: %s\n", error.what());
    }
  }

  void step() {
    is_fine_ = false;
    get().step();
    is_fine_ = true;
  }
  /// Files get their end, but for those of a run that failed.
  void close() {
    const std::unique_ptr<Solver> solver = std::move(solver_);
    if (solver != nullptr && has_files_ && is_fine_) solver->finish();
  }
  Solver& get() const {
    if (solver_ == nullptr) throw RunError("the solver is closed", Reach::all_ranks);
    return *solver_;
  }
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

// Ids that follow one another over the ranks, where the caller gives none.
std::vector<GlobalId> consecutive_ids(MPI_Comm comm, std::size_t count) {
  auto before = static_cast<GlobalId>(count);
  MPI_Exscan(MPI_IN_PLACE, &before, 1, MPI_INT64_T, MPI_SUM, comm);
  std::vector<GlobalId> ids(count);
  std::iota(ids.begin(), ids.end(), rank_of(comm) == 0 ? 0 : before);
  return ids;
}

Particles particles_of(MPI_Comm comm, const Rows& positions, const py::object& velocities, const py::object& ids) {
  Particles particles;
  particles.position = rows_of(positions, "positions");
  const std::size_t count = particles.position.size();
  particles.velocity =
      velocities.is_none() ? std::vector<Vec3>(count, Vec3::Zero()) : rows_of(velocities.cast<Rows>(), "velocities");
  if (ids.is_none()) {
    particles.id = consecutive_ids(comm, count);
  } else {
    const auto array = ids.cast<Ids>();
    particles.id.assign(array.data(), array.data() + array.size());
  }
  return particles;
}

std::unique_ptr<PySolver> make(const Settings& settings, const Scene* scene, const py::object& positions,
                               const py::object& velocities, const py::object& ids, const py::list& forcings,
                               const py::object& rows, const py::object& comm_object) {
  const MPI_Comm comm = comm_of(comm_object);
  SolverExtras extras;
  Particles particles;
  if (!positions.is_none()) {
    particles = particles_of(comm, positions.cast<Rows>(), velocities, ids);
  } else if (scene != nullptr) {
    particles = initial_particles(comm, *scene);
  }
  for (const auto& one : forcings) {
    const Real fastest = py::hasattr(one, "fastest") ? one.attr("fastest").cast<Real>() : 0;
    extras.forcings.push_back(make_forcing(py::reinterpret_borrow<py::function>(one), fastest));
  }
  std::optional<Schedule> schedule = settings.output.series;
  if (!rows.is_none()) schedule = Schedule{0, rows.cast<std::int64_t>()};
  auto solver = std::make_unique<PySolver>(comm, settings, scene, std::move(particles), std::move(extras), schedule);
  if (scene != nullptr) solver->end = scene->end;
  return solver;
}

py::dict as_arrays(const Table& table) {
  py::dict arrays;
  for (const auto& [name, values] : table)
    arrays[name.c_str()] = py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
  return arrays;
}

// Messages of at most this many numbers, as MPI counts them as an int.
constexpr std::size_t max_message = 1U << 28;

template <class T>
void send_in_parts(const T* data, std::size_t count, int to, MPI_Comm comm, MPI_Datatype type) {
  for (std::size_t done = 0; done < count; done += max_message)
    MPI_Send(data + done, static_cast<int>(std::min(max_message, count - done)), type, to, 0, comm);
}

template <class T>
void receive_in_parts(T* data, std::size_t count, int from, MPI_Comm comm, MPI_Datatype type) {
  for (std::size_t done = 0; done < count; done += max_message)
    MPI_Recv(data + done, static_cast<int>(std::min(max_message, count - done)), type, from, 0, comm,
             MPI_STATUS_IGNORE);
}

// On rank 0 the rows of all particles in the order of their ids; None on the others.
py::object gathered(const PySolver& self, const std::vector<Vec3> Particles::*field) {
  const Particles& particles = self.get().particles();
  const std::vector<Vec3>& own = particles.*field;
  std::int64_t count = std::ssize(own);
  std::vector<std::int64_t> counts(static_cast<std::size_t>(self.size()));
  MPI_Gather(&count, 1, MPI_INT64_T, counts.data(), 1, MPI_INT64_T, 0, self.comm());
  if (self.rank() != 0) {
    send_in_parts(particles.id.data(), own.size(), 0, self.comm(), MPI_INT64_T);
    send_in_parts(own.data()->data(), 3 * own.size(), 0, self.comm(), MPI_DOUBLE);
    return py::none();
  }
  std::vector<GlobalId> ids = particles.id;
  std::vector<Vec3> rows = own;
  for (int rank = 1; rank < self.size(); ++rank) {
    const auto more = static_cast<std::size_t>(counts[static_cast<std::size_t>(rank)]), before = ids.size();
    ids.resize(before + more);
    rows.resize(before + more);
    receive_in_parts(ids.data() + before, more, rank, self.comm(), MPI_INT64_T);
    receive_in_parts(rows[0].data() + 3 * before, 3 * more, rank, self.comm(), MPI_DOUBLE);
  }
  std::vector<std::size_t> order(ids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return ids[a] < ids[b]; });
  py::array_t<double> all({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  for (std::size_t k = 0; k < order.size(); ++k)
    std::memcpy(all.mutable_data(static_cast<py::ssize_t>(k), 0), rows[order[k]].data(), sizeof(Vec3));
  return all;
}

py::list obstacles_of(const PySolver& self) {
  py::list list;
  const Table& rows = self.record().obstacles;
  for (std::size_t k = 0; k < self.settings().obstacles.size(); ++k) {
    const Pose pose = BodyMotion(self.settings().obstacles[k]).at(self.get().clock().time());
    py::dict one;
    one["center"] = pose.center;
    one["rotation"] = pose.turn;
    const auto last = [&](const char* name) -> py::object {
      Vec3 value;
      for (Eigen::Index a = 0; a < 3; ++a) {
        const auto column = rows.find(fmt::format("{}_{}_{}", name, "xyz"[a], k));
        if (column == rows.end() || column->second.empty()) return py::none();
        value[a] = column->second.back();
      }
      return py::cast(value);
    };
    one["force"] = last("force");
    one["torque"] = last("torque");
    list.append(one);
  }
  return list;
}

py::object positions_of(const py::object& self) {
  const auto& solver = self.cast<const PySolver&>();
  return solver.change ? solver.change->positions : view_of(solver.get().particles().position, self, false);
}
py::object velocities_of(const py::object& self) {
  const auto& solver = self.cast<const PySolver&>();
  return solver.change ? solver.change->velocities : view_of(solver.get().particles().velocity, self, false);
}
py::object ids_of(const py::object& self) {
  const auto& solver = self.cast<const PySolver&>();
  return solver.change ? solver.change->ids : view_of(solver.get().particles().id, self, false);
}

void begin_change(PySolver& self) {
  if (self.change) throw RunError("solver.change(): a change has begun already", Reach::all_ranks);
  const Particles& particles = self.get().particles();
  const auto copy = [](const py::array& view) { return view.attr("copy")(); };
  self.change =
      Change{copy(view_of(particles.position, py::none(), true)), copy(view_of(particles.velocity, py::none(), true)),
             copy(view_of(particles.id, py::none(), true))};
}

void end_change(PySolver& self, bool keep) {
  const std::optional<Change> change = std::exchange(self.change, std::nullopt);
  if (!keep || !change) return;
  self.get().change_particles([&](Particles& particles) {
    particles.position = rows_of(change->positions.cast<Rows>(), "positions");
    particles.velocity = rows_of(change->velocities.cast<Rows>(), "velocities");
    const auto ids = change->ids.cast<Ids>();
    particles.id.assign(ids.data(), ids.data() + ids.size());
    if (particles.has_hue) particles.hue.resize(particles.id.size());
  });
}

void set_in_change(PySolver& self, py::object Change::*what, const py::object& value) {
  if (!self.change) throw InputError("particles are changed within \"with solver.change():\" only");
  (*self.change).*what = value;
}

}  // namespace

std::unique_ptr<Forcing> make_forcing(py::function call, Real fastest) {
  return std::make_unique<OwnForcing>(std::move(call), fastest);
}

py::array view_of(const std::vector<Vec3>& rows, const py::object& owner, bool writable) {
  constexpr py::ssize_t edge = sizeof(Real);
  return over(py::array_t<double>({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}}, {3 * edge, edge},
                                  rows.empty() ? nullptr : rows[0].data(), owner),
              writable);
}

py::array view_of(const std::vector<GlobalId>& rows, const py::object& owner, bool writable) {
  return over(py::array_t<GlobalId>(static_cast<py::ssize_t>(rows.size()), rows.data(), owner), writable);
}

void close_all_solvers() {
  for (PySolver* one : alive) one->close();
}

void bind_solver(py::module_& m) {
  py::class_<StepInfo>(m, "StepInfo", "The part of a step that is about to be made.")
      .def_readonly("step", &StepInfo::step, "steps done before")
      .def_readonly("substep", &StepInfo::substep)
      .def_readonly("time", &StepInfo::time, "at its start, s")
      .def_readonly("dt", &StepInfo::dt, "its length, s");

  py::class_<Water>(m, "Water", "This rank's particles as a forcing sees them, valid during the call.")
      .def_property_readonly(
          "positions", [](const Water& w) { return view_of(w.particles->position, py::none(), true); }, "(n, 3), m")
      .def_property(
          "velocities", [](const Water& w) { return view_of(w.particles->velocity, py::none(), true); },
          [](const Water& w, const Rows& rows) {
            std::vector<Vec3> values = rows_of(rows, "velocities");
            if (values.size() != w.particles->velocity.size())
              throw InputError("velocities: must have a row for each particle");
            w.particles->velocity = std::move(values);
          },
          "(n, 3), m/s; to be changed")
      .def_property_readonly("ids", [](const Water& w) { return view_of(w.particles->id, py::none(), false); });

  py::class_<PySolver>(m, "Solver", "A solver on the ranks of its communicator, which all make the same calls.")
      .def("step", &PySolver::step, "One step of length dt. Collective.")
      .def_property_readonly(
          "time", [](const PySolver& self) { return self.get().clock().time(); }, "s")
      .def_property_readonly(
          "dt", [](const PySolver& self) { return self.get().clock().dt; }, "of a step, s")
      .def_property_readonly(
          "steps", [](const PySolver& self) { return self.get().clock().step; }, "done so far")
      .def_property_readonly("rank", &PySolver::rank)
      .def_property_readonly("size", &PySolver::size, "ranks")
      .def_property_readonly("settings", &PySolver::settings, py::return_value_policy::copy)
      .def_property(
          "positions", &positions_of,
          [](PySolver& self, const py::object& value) { set_in_change(self, &Change::positions, value); },
          "(n, 3), m: this rank's particles, without a copy. Valid until the next step.")
      .def_property(
          "velocities", &velocities_of,
          [](PySolver& self, const py::object& value) { set_in_change(self, &Change::velocities, value); },
          "(n, 3), m/s; the same.")
      .def_property(
          "ids", &ids_of, [](PySolver& self, const py::object& value) { set_in_change(self, &Change::ids, value); },
          "(n), unique over all ranks; the same.")
      .def(
          "gather_positions", [](const PySolver& self) { return gathered(self, &Particles::position); },
          "Those of all ranks in the order of their ids, on rank 0; None on the others. Collective.")
      .def(
          "gather_velocities", [](const PySolver& self) { return gathered(self, &Particles::velocity); }, "The same.")
      .def_property_readonly(
          "series", [](const PySolver& self) { return as_arrays(self.record().series); },
          "Rows so far, an array for each column of series.csv; empty without rows.")
      .def_property_readonly(
          "forces", [](const PySolver& self) { return as_arrays(self.record().obstacles); },
          "Rows so far, as in obstacles.csv.")
      .def_property_readonly(
          "gauges", [](const PySolver& self) { return as_arrays(self.record().gauges); },
          "Rows so far, as in gauges.csv.")
      .def_property_readonly("obstacles", &obstacles_of,
                             "Of each obstacle: center and rotation now, force and torque as in the last row.")
      .def_readonly("_end", &PySolver::end)
      .def("_begin_change", &begin_change)
      .def("_end_change", &end_change)
      .def("close", &PySolver::close, "Ends its files, and frees it; all ranks in the same order.");

  m.def(
      "_make_solver",
      [](const py::object& what, const py::object& positions, const py::object& velocities, const py::object& ids,
         const py::list& forcings, const py::object& rows, const py::object& comm) {
        const Scene* scene = py::isinstance<Scene>(what) ? what.cast<const Scene*>() : nullptr;
        return make(what.cast<const Settings&>(), scene, positions, velocities, ids, forcings, rows, comm);
      },
      py::arg("settings"), py::arg("positions"), py::arg("velocities"), py::arg("ids"), py::arg("forcings"),
      py::arg("rows"), py::arg("comm"));
}

}  // namespace trevi::python

#include "solver.hpp"

#include <cstdio>
#include <numeric>

#include "base/simd.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi::python {

namespace {

/// What a callable sees of the particles: valid during the call.
struct Water {
  Particles* particles;
};

class OwnForcing : public Forcing {
 public:
  OwnForcing(py::function call, Real fastest) : call_(std::move(call)), fastest_(fastest) {}
  void apply(Particles& particles, const StepInfo& step) override {
    const Denormals denormals(false);  // numpy counts as it does elsewhere
    call_(Water{&particles}, step);
  }
  Real fastest(const TimeSpan&) const override { return fastest_; }

 private:
  py::function call_;
  Real fastest_;
};

std::vector<PySolver*> alive;  // in the order in which they were made

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

void set_in_change(PySolver& self, py::object Change::*what, const py::object& value) {
  if (!self.change) throw InputError("particles are changed within \"with solver.change():\" only");
  (*self.change).*what = value;
}

}  // namespace

std::unique_ptr<Forcing> make_forcing(py::function call, Real fastest) {
  return std::make_unique<OwnForcing>(std::move(call), fastest);
}

PySolver::PySolver(MPI_Comm comm, const Settings& settings, const Scene* scene, Particles particles,
                   SolverExtras extras, std::optional<Schedule> rows)
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

PySolver::~PySolver() {
  const Denormals denormals;
  std::erase(alive, this);
  try {
    close();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trevi: %s\n", error.what());
  }
}

void PySolver::step() {
  is_fine_ = false;
  get().step();
  is_fine_ = true;
}

void PySolver::close() {
  const std::unique_ptr<Solver> solver = std::move(solver_);
  if (solver != nullptr && has_files_ && is_fine_) solver->finish();
}

Solver& PySolver::get() const {
  if (solver_ == nullptr) throw RunError("the solver is closed", Reach::all_ranks);
  return *solver_;
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
      .def("step", &PySolver::step, py::call_guard<Denormals>(), "One step of length dt. Collective.")
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
      .def_property_readonly("bodies", &bodies_of,
                             "Of each body: position, orientation (a quaternion w, x, y, z), rotation, velocity and "
                             "angular_velocity now, force and torque as in the last row.")
      .def_property_readonly(
          "body_rows", [](const PySolver& self) { return as_arrays(self.record().bodies); },
          "Rows so far, as in bodies.csv.")
      .def_readonly("_end", &PySolver::end)
      .def("_begin_change", &begin_change)
      .def("_end_change", &end_change, py::call_guard<Denormals>())
      .def("close", &PySolver::close, py::call_guard<Denormals>(),
           "Ends its files, and frees it; all ranks in the same order.");

  m.def(
      "_make_solver",
      [](const py::object& what, const py::object& positions, const py::object& velocities, const py::object& ids,
         const py::list& forcings, const py::object& rows, const py::object& comm) {
        const Scene* scene = py::isinstance<Scene>(what) ? what.cast<const Scene*>() : nullptr;
        return make(what.cast<const Settings&>(), scene, positions, velocities, ids, forcings, rows, comm);
      },
      py::call_guard<Denormals>(), py::arg("settings"), py::arg("positions"), py::arg("velocities"), py::arg("ids"),
      py::arg("forcings"), py::arg("rows"), py::arg("comm"));
}

}  // namespace trevi::python

#include "solver.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "base/simd.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi::python {

namespace {

std::vector<PySolver*> alive;  // in the order in which they were made

template <class Row>
py::object view(const py::object& self, py::object Change::*changed, const std::vector<Row> Particles::*field) {
  const auto& solver = self.cast<const PySolver&>();
  solver.refuse_within_forcing("an array of the particles");
  if (solver.change) return (*solver.change).*changed;
  return view_of(solver.get().particles().*field, solver.keeper(self), false);
}
py::object positions_of(const py::object& self) { return view(self, &Change::positions, &Particles::position); }
py::object velocities_of(const py::object& self) { return view(self, &Change::velocities, &Particles::velocity); }
py::object ids_of_particles(const py::object& self) { return view(self, &Change::ids, &Particles::id); }

void set_in_change(PySolver& self, py::object Change::*what, const py::object& value) {
  if (!self.change) throw InputError("particles are changed within \"with solver.change():\" only");
  (*self.change).*what = value;
}

}  // namespace

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

void PySolver::refuse_within_forcing(const char* call) const {
  if (is_in_step_)
    throw RunError(fmt::format("{} is used within a forcing of the same solver; use it after the step", call));
}

void PySolver::refuse_within(const char* call) const {
  refuse_within_forcing(call);
  if (change)
    throw InputError(fmt::format("{} is used within \"with solver.change():\"; use it after the block", call));
}

void PySolver::step() {
  refuse_within("step()");
  Solver& solver = get();
  is_fine_ = false;
  {
    const auto leave = [](bool* is_in_step) { *is_in_step = false; };
    const std::unique_ptr<bool, decltype(leave)> entered(&is_in_step_, leave);
    is_in_step_ = true;
    solver.step();
  }
  is_fine_ = true;
}

void PySolver::close() {
  const std::unique_ptr<Solver> solver = std::move(solver_);
  if (solver == nullptr) return;
  const auto keep = [&](Solver* one) {
    if (kept_.use_count() > 1) *kept_ = one->take_particles();
  };
  const std::unique_ptr<Solver, decltype(keep)> kept(solver.get(), keep);
  if (has_files_ && is_fine_) solver->finish();
}

std::int64_t PySolver::agree(std::int64_t mine) const {
  if (size_ > 1) MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_INT64_T, MPI_MAX, comm_);
  return mine;
}

py::object PySolver::keeper(const py::object& self) const {
  using Keeper = std::pair<py::object, std::shared_ptr<Particles>>;
  return py::capsule(new Keeper(self, kept_), [](void* keeper) { delete static_cast<Keeper*>(keeper); });
}

Solver& PySolver::get() const {
  if (solver_ == nullptr) throw RunError("the solver is closed", Reach::all_ranks);
  return *solver_;
}

void close_all_solvers() {
  for (PySolver* one : alive) one->close();
}

void bind_solver(py::module_& m) {
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
          "ids", &ids_of_particles,
          [](PySolver& self, const py::object& value) { set_in_change(self, &Change::ids, value); },
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
      .def("_agree", &PySolver::agree)
      .def("_refuse_within", &PySolver::refuse_within)
      .def(
          "close",
          [](PySolver& self) {
            self.refuse_within("close()");
            self.close();
          },
          py::call_guard<Denormals>(),
          "Ends its files, and frees it but for arrays that are still held; all ranks in the same order.");

  m.def(
      "_make_solver",
      [](const py::object& settings, const py::object& positions, const py::object& velocities, const py::object& ids,
         const py::object& forcings, const py::object& rows, const py::object& comm, const Marks& marks) {
        return make_py_solver({settings, positions, velocities, ids, forcings, rows, comm}, marks);
      },
      py::call_guard<Denormals>(), py::arg("settings"), py::arg("positions"), py::arg("velocities"), py::arg("ids"),
      py::arg("forcings"), py::arg("rows"), py::arg("comm"), py::arg("marks"));
}

}  // namespace trevi::python

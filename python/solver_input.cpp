// What a script gives to a solver, which may be wrong on one rank alone, and must be the same on all ranks where it is
// not the particles.
#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "parallel/collective.hpp"
#include "parallel/reductions.hpp"
#include "solver.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi::python {

namespace {

/// As one rank has it.
struct Input {
  const Settings* settings = nullptr;
  const Scene* scene = nullptr;  ///< of the settings, or null
  Particles particles;
  bool has_particles = false, has_ids = false;
  std::vector<std::unique_ptr<Forcing>> forcings;
  std::optional<Schedule> rows;
};

Schedule schedule_of(const py::object& rows) {
  std::int64_t every = 0;
  try {
    every = rows.cast<std::int64_t>();
  } catch (const py::cast_error&) {  // told below
  }
  if (every < 1) throw InputError("rows: must be a whole number of steps from 1 on, or None");
  return Schedule{0, every};
}

Input read(const SolverArguments& given) {
  Input input;
  if (!py::isinstance<Settings>(given.settings)) throw InputError("settings: must be Settings or a Scene");
  input.settings = given.settings.cast<const Settings*>();
  if (py::isinstance<Scene>(given.settings)) input.scene = given.settings.cast<const Scene*>();
  input.has_particles = !given.positions.is_none();
  input.has_ids = !given.ids.is_none();
  if (!input.has_particles && (input.has_ids || !given.velocities.is_none()))
    throw InputError("positions: must be given where velocities or ids are");
  if (input.has_particles) {
    Particles& particles = input.particles;
    particles.position = rows_of(given.positions, "positions");
    particles.velocity = given.velocities.is_none() ? std::vector<Vec3>(particles.position.size(), Vec3::Zero())
                                                    : rows_of(given.velocities, "velocities");
    if (input.has_ids) particles.id = ids_of(given.ids);
  }
  input.forcings = forcings_of(given.forcings);
  input.rows = given.rows.is_none() ? input.settings->output.series : schedule_of(given.rows);
  return input;
}

/// Whether it is so on any rank. Collective.
bool on_any(MPI_Comm comm, bool here) { return max_over_ranks(comm, here ? 1 : 0) > 0; }

void check_same(MPI_Comm comm, const Marks& marks) {
  std::vector<std::int64_t> least, most;
  for (const auto& mark : marks) least.push_back(mark.second);
  most = least;
  const int count = static_cast<int>(marks.size());
  MPI_Allreduce(MPI_IN_PLACE, least.data(), count, MPI_INT64_T, MPI_MIN, comm);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), count, MPI_INT64_T, MPI_MAX, comm);
  for (std::size_t k = 0; k < marks.size(); ++k) {
    if (least[k] != most[k])
      throw InputError(fmt::format("{}: differs between ranks; give the same on all of them", marks[k].first));
  }
}

// Ids that follow one another over the ranks, where the caller gives none.
std::vector<GlobalId> consecutive_ids(MPI_Comm comm, std::size_t count) {
  auto before = static_cast<GlobalId>(count);
  MPI_Exscan(MPI_IN_PLACE, &before, 1, MPI_INT64_T, MPI_SUM, comm);
  std::vector<GlobalId> ids(count);
  std::iota(ids.begin(), ids.end(), rank_of(comm) == 0 ? 0 : before);
  return ids;
}

// Of a scene those that it has, where no rank gives any.
void complete_particles(MPI_Comm comm, Input& input) {
  if (input.scene != nullptr) {
    const bool any = on_any(comm, input.has_particles), all = !on_any(comm, !input.has_particles);
    if (any && !all)
      throw InputError("positions: given on some ranks only; a rank without particles gives an array of shape (0, 3)");
    if (!any) {
      input.particles = initial_particles(comm, *input.scene);
      return;
    }
  }
  const bool brings_some = !input.particles.position.empty();
  const bool any = on_any(comm, input.has_ids), none = on_any(comm, brings_some && !input.has_ids);
  if (any && none) throw InputError("ids: given on some ranks only; give them on all ranks, or on none");
  if (!any) input.particles.id = consecutive_ids(comm, input.particles.position.size());
}

}  // namespace

std::unique_ptr<PySolver> make_py_solver(const SolverArguments& given, const Marks& marks) {
  const MPI_Comm comm = comm_of(given.comm);
  Input input;
  all_or_none(comm, [&] { input = read(given); });
  check_same(comm, marks);
  complete_particles(comm, input);
  SolverExtras extras;
  extras.forcings = std::move(input.forcings);
  auto solver = std::make_unique<PySolver>(comm, *input.settings, input.scene, std::move(input.particles),
                                           std::move(extras), input.rows);
  if (input.scene != nullptr) solver->end = input.scene->end;
  return solver;
}

}  // namespace trevi::python

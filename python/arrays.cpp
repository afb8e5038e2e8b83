// Particles as arrays: views, copies, all of them on one rank, and changes.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "parallel/collective.hpp"
#include "solver.hpp"
#include "trevi/error.hpp"

namespace trevi::python {

namespace {

py::array over(py::array array, bool writable) {
  if (!writable) array.attr("flags").attr("writeable") = false;
  return array;
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

// An array of real numbers. Complex ones would lose a part, text and masked rows be taken as some number.
py::array numbers_of(const py::object& given, const char* name) {
  py::array array;
  try {
    array = py::module_::import("numpy").attr("asanyarray")(given);
  } catch (const py::error_already_set& error) {
    throw InputError(
        fmt::format("{}: must be an array of numbers: {}", name, py::str(error.value()).cast<std::string>()));
  }
  if (std::strchr("fiu", array.dtype().kind()) == nullptr)
    throw InputError(fmt::format("{}: must be an array of real numbers, not of {}", name,
                                 py::str(py::object(array.dtype())).cast<std::string>()));
  if (py::module_::import("numpy.ma").attr("is_masked")(array).cast<bool>())
    throw InputError(fmt::format("{}: some entries are masked; leave their rows out, or fill them", name));
  return array;
}

template <class T>
using Dense = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <class T>
std::vector<GlobalId> as_ids(const Dense<T>& numbers) {
  constexpr auto end = static_cast<T>(GlobalId{1} << 62);
  std::vector<GlobalId> ids(static_cast<std::size_t>(numbers.size()));
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const T number = numbers.data()[k];
    const bool fits = number >= 0 && number < end;
    if (fits) ids[k] = static_cast<GlobalId>(number);
    if (!fits || static_cast<T>(ids[k]) != number)
      throw InputError(fmt::format("ids: row {} is {}, but ids are whole numbers from 0 and below 2^62", k, number));
  }
  return ids;
}

}  // namespace

std::vector<Vec3> rows_of(const py::object& given, const char* name) {
  const Dense<double> array = numbers_of(given, name);
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw InputError(fmt::format("{}: must be an array of shape (n, 3)", name));
  std::vector<Vec3> rows(static_cast<std::size_t>(array.shape(0)));
  if (!rows.empty()) std::memcpy(rows[0].data(), array.data(), rows.size() * sizeof(Vec3));
  return rows;
}

std::vector<GlobalId> ids_of(const py::object& given) {
  const py::array array = numbers_of(given, "ids");
  if (array.ndim() != 1) throw InputError("ids: must be an array of shape (n)");
  if (array.dtype().kind() == 'f') return as_ids<double>(array);
  if (array.dtype().kind() == 'u') return as_ids<std::uint64_t>(array);
  return as_ids<std::int64_t>(array);
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

py::object gathered(const PySolver& self, const std::vector<Vec3> Particles::*field) {
  self.refuse_within_forcing("a gather");
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

void begin_change(PySolver& self) {
  if (self.change) throw RunError("solver.change(): a change has begun already", Reach::all_ranks);
  self.refuse_within("change()");
  const Particles& particles = self.get().particles();
  const auto copy = [](const py::array& view) { return view.attr("copy")(); };
  const py::object positions = copy(view_of(particles.position, py::none(), true)),
                   velocities = copy(view_of(particles.velocity, py::none(), true)),
                   ids = copy(view_of(particles.id, py::none(), true));
  self.change = Change{positions, velocities, ids, {positions, velocities, ids}};
}

void end_change(PySolver& self, bool keep) {
  const std::optional<Change> change = std::exchange(self.change, std::nullopt);
  if (!change) return;
  for (const py::object& array : change->lent) array.attr("flags").attr("writeable") = false;
  const bool failed = self.agree(keep ? 0 : 1) != 0;
  if (!keep) return;
  if (failed)
    throw RunError("the block of \"with solver.change():\" failed on another rank; nothing is changed",
                   Reach::all_ranks);
  Particles changed;
  all_or_none(self.comm(), [&] {
    changed.position = rows_of(change->positions, "positions");
    changed.velocity = rows_of(change->velocities, "velocities");
    changed.id = ids_of(change->ids);
    if (changed.velocity.size() != changed.position.size() || changed.id.size() != changed.position.size())
      throw InputError("positions, velocities and ids must have a row for each particle");
  });
  self.get().change_particles([&](Particles& particles) {
    particles.position = std::move(changed.position);
    particles.velocity = std::move(changed.velocity);
    particles.id = std::move(changed.id);
    if (particles.has_hue) particles.hue.resize(particles.id.size());
  });
}

}  // namespace trevi::python

#include "io/hdf5/particle_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/damaged_file.hpp"
#include "io/frames/fields.hpp"
#include "io/hdf5/id_order.hpp"
#include "parallel/collective.hpp"
#include "parallel/core_share.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

void check_finite(const std::vector<Vec3>& field, GlobalId first_row, const std::string& object) {
  const auto bad = std::find_if(field.begin(), field.end(), [](const Vec3& row) { return !row.allFinite(); });
  if (bad == field.end()) return;
  throw DamagedFile(fmt::format("{}: row {} is not finite ({}, {}, {}); remove or repair the particle", object,
                                first_row + (bad - field.begin()), (*bad)[0], (*bad)[1], (*bad)[2]));
}

void check_ids(const std::vector<GlobalId>& ids, GlobalId first_row, const std::string& object) {
  const auto bad = std::find_if(ids.begin(), ids.end(), [](GlobalId id) { return id < 0 || id >= end_of_ids; });
  if (bad == ids.end()) return;
  throw DamagedFile(
      fmt::format("{}: row {} is {}, where ids are from 0 and below 2^62; change it, or leave ids out to "
                  "number the rows",
                  object, first_row + (bad - ids.begin()), *bad));
}

}  // namespace

ParticleRows read_particle_rows(const Hdf5Reader& file, RowSlice slice) {
  if (slice.count > std::numeric_limits<LocalId>::max()) {
    throw InputError(
        fmt::format("/particles/position: {} rows are too many for one rank; use more ranks", slice.count));
  }
  ParticleRows rows;
  rows.total = slice.total;
  rows.first = slice.first;
  const auto count = static_cast<std::size_t>(slice.count);
  for (const OutputField& field : output_fields) {
    if (field.when != nullptr) rows.*field.when = file.has(std::string("/particles/") + field.name);
  }
  for_each_saved_field(rows, [&](const std::string& name, auto& field) {
    using Row = typename std::remove_reference_t<decltype(field)>::value_type;
    if (name == "velocity" && !file.has("/particles/velocity"))
      rows.velocity.assign(count, Vec3::Zero());
    else
      field = file.read<Row>("/particles/" + name, slice);
  });
  if (file.has("/particles/id")) {
    rows.id = file.read<GlobalId>("/particles/id", slice);
  } else {
    rows.id.resize(count);
    std::iota(rows.id.begin(), rows.id.end(), slice.first);
  }
  return rows;
}

void check_particle_rows(MPI_Comm comm, const ParticleRows& rows, const std::string& path) {
  all_or_none(comm, [&] {
    check_finite(rows.position, rows.first, path + ": /particles/position");
    check_finite(rows.velocity, rows.first, path + ": /particles/velocity");
    check_ids(rows.id, rows.first, path + ": /particles/id");
  });
  const IdOrder order(comm, rows.id);
  all_or_none(comm, [&] {
    const auto twice = std::adjacent_find(order.ids().begin(), order.ids().end());
    if (twice == order.ids().end()) return;
    throw DamagedFile(fmt::format(
        "{}: /particles/id: {} occurs more than once; make ids unique, or leave them out to number the rows", path,
        *twice));
  });
}

ParticleRows read_particle_file(MPI_Comm comm, const std::string& path) {
  ParticleRows rows;
  const int readers = ranks_of_machine(comm);
  all_or_none(comm, [&] {
    const Hdf5Reader file(path, readers);
    const GlobalId total = file.rows<Vec3>("/particles/position");
    rows = read_particle_rows(file, equal_slice(total, rank_of(comm), size_of(comm)));
  });
  check_particle_rows(comm, rows, path);
  return rows;
}

}  // namespace trevi

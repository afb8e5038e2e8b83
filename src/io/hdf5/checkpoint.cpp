#include "io/hdf5/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>
#include <utility>

#include "base/damaged_file.hpp"
#include "base/hash.hpp"
#include "base/threads.hpp"
#include "io/frames/fields.hpp"
#include "io/hdf5/body_rows.hpp"
#include "io/hdf5/hdf5_writer.hpp"
#include "io/hdf5/id_order.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "parallel/core_share.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr std::int64_t format_version = 1;

// Rank 0 writes everything that is not a table of particles.
template <class T>
void write_on_root(MPI_Comm comm, Hdf5Writer& file, const std::string& name, const std::vector<T>& rows) {
  const auto count = static_cast<std::int64_t>(rows.size());
  const bool writes = rank_of(comm) == 0;
  file.write(name, writes ? rows : std::vector<T>{}, {writes ? 0 : count, writes ? count : 0, count});
}

void write_flow(MPI_Comm comm, Hdf5Writer& file, const FlowState* flow) {
  if (flow == nullptr) return;
  write_on_root(comm, file, "/flow",
                std::vector<std::int64_t>{flow->next_id, flow->inflow, flow->outflow, flow->waiting});
  std::vector<Real> streams;
  std::vector<Real> counts;
  for (const FlowState::Stream& stream : flow->streams) {
    streams.insert(streams.end(), {stream.travelled, stream.speed});
    counts.insert(counts.end(), {stream.made, stream.covered, stream.blocked, stream.dry});
  }
  write_on_root(comm, file, "/streams", streams);
  write_on_root(comm, file, "/stream_counts", counts);
  if (flow->openings.empty()) return;
  std::vector<Real> openings, due;
  for (const FlowState::Opening& one : flow->openings) {
    openings.insert(openings.end(), {one.speed, one.level, one.owed, one.known ? 1.0 : 0.0});
    due.push_back(one.due);
  }
  write_on_root(comm, file, "/openings", openings);
  write_on_root(comm, file, "/openings_due", due);
  write_on_root(comm, file, "/opening_rows", flow->rows);
}

// For scenes with openings in walls.
void read_openings(const std::string& path, const Hdf5Reader& file, FlowState& flow) {
  if (!file.has("/openings") || !file.has("/opening_rows")) return;
  constexpr std::size_t values = 4;
  const auto all = [&](const char* name) {
    const std::int64_t rows = file.rows<Real>(name);
    const auto found = file.read<Real>(name, {0, rows, rows});
    if (!std::all_of(found.begin(), found.end(), [](Real x) { return std::isfinite(x); }))
      throw DamagedFile(path + ": " + name + ": cannot be what openings have done; use another checkpoint");
    return found;
  };
  const std::vector<Real> openings = all("/openings");
  for (std::size_t k = 0; k + values <= openings.size(); k += values)
    flow.openings.push_back({openings[k], openings[k + 1], openings[k + 2], openings[k + 3] != 0});
  if (file.has("/openings_due")) {
    const std::vector<Real> due = all("/openings_due");
    for (std::size_t k = 0; k < std::min(due.size(), flow.openings.size()); ++k) flow.openings[k].due = due[k];
  }
  flow.rows = all("/opening_rows");
}

std::optional<FlowState> read_flow(const std::string& path, const Hdf5Reader& file) {
  if (!file.has("/flow")) return std::nullopt;
  const auto counts = file.read<std::int64_t>("/flow", {0, 4, 4});
  const std::int64_t rows = file.rows<Real>("/streams");
  const auto streams = file.read<Real>("/streams", {0, rows, rows});
  FlowState flow{counts[0], counts[1], counts[2], counts[3], {}, {}, {}};
  const std::int64_t count_rows = file.has("/stream_counts") ? file.rows<Real>("/stream_counts") : 0;  // since 1.1.0
  const auto made = file.has("/stream_counts") ? file.read<Real>("/stream_counts", {0, count_rows, count_rows})
                                               : std::vector<Real>(2 * streams.size());
  const auto fine = [](Real x) { return x >= 0 && std::isfinite(x); };
  if (*std::min_element(counts.begin(), counts.end()) < 0 || !std::all_of(streams.begin(), streams.end(), fine) ||
      !std::all_of(made.begin(), made.end(), fine) || rows % 2 != 0 || made.size() != 2 * streams.size())
    throw DamagedFile(path + ": /flow, /streams: cannot be what inlets and drains have done; use another checkpoint");
  for (std::size_t k = 0; k < streams.size(); k += 2) {
    const std::size_t n = 2 * k;
    flow.streams.push_back({streams[k], streams[k + 1], made[n], made[n + 1], made[n + 2], made[n + 3]});
  }
  read_openings(path, file, flow);
  return flow;
}

std::vector<std::int64_t> read_checksums(const Hdf5Reader& file, const std::string& name) {
  if (!file.has(name)) return {};
  const std::int64_t count = file.rows<std::int64_t>(name);
  return file.read<std::int64_t>(name, {0, count, count});
}

std::array<LocalId, 3> read_first_cell(const std::string& path, const Hdf5Reader& file) {
  std::array<LocalId, 3> cell{};
  if (!file.has("/first_cell")) return cell;
  const auto written = file.read<std::int64_t>("/first_cell", {0, 3, 3});
  for (std::size_t a = 0; a < 3; ++a) {
    if (written[a] < 0 || written[a] > std::numeric_limits<LocalId>::max())
      throw DamagedFile(fmt::format("{}: /first_cell: cannot be {}; use another checkpoint", path, written[a]));
    cell[a] = static_cast<LocalId>(written[a]);
  }
  return cell;
}

// Steps, numbers of bodies and gauges, and the steps of gauges if those are different; then forces and torques, then
// pressures.
void write_force_sums(MPI_Comm comm, Hdf5Writer& file, const ForceSums* sums) {
  if (sums == nullptr || (sums->steps == 0 && sums->pressure_steps == 0)) return;
  std::vector<Real> rows;
  for (const BodyForce& one : sums->forces) {
    rows.insert(rows.end(), one.force.begin(), one.force.end());
    rows.insert(rows.end(), one.torque.begin(), one.torque.end());
  }
  rows.insert(rows.end(), sums->pressures.begin(), sums->pressures.end());
  std::vector<std::int64_t> counts{sums->steps, std::ssize(sums->forces), std::ssize(sums->pressures)};
  if (sums->pressure_steps != sums->steps) counts.push_back(sums->pressure_steps);
  write_on_root(comm, file, "/force_steps", counts);
  write_on_root(comm, file, "/force_sums", rows);
}

ForceSums read_force_sums(const std::string& path, const Hdf5Reader& file) {
  if (!file.has("/force_steps")) return {};
  const std::int64_t length = file.rows<std::int64_t>("/force_steps") == 4 ? 4 : 3;
  auto counts = file.read<std::int64_t>("/force_steps", {0, length, length});
  if (length == 3) counts.push_back(counts[0]);
  const std::int64_t total = file.rows<Real>("/force_sums"), bodies = counts[1], gauges = counts[2];
  const auto rows = file.read<Real>("/force_sums", {0, total, total});
  const bool finite = std::all_of(rows.begin(), rows.end(), [](Real x) { return std::isfinite(x); });
  if (std::min(counts[0], counts[3]) < 0 || std::max(counts[0], counts[3]) < 1 || bodies < 0 || bodies > total ||
      gauges < 0 || gauges > total || 6 * bodies + gauges != total || !finite)
    throw DamagedFile(path + ": /force_steps, /force_sums: cannot be forces since a row; use another checkpoint");
  ForceSums sums{counts[0], std::vector<BodyForce>(static_cast<std::size_t>(bodies)),
                 std::vector<Real>(rows.end() - gauges, rows.end()), counts[3]};
  for (std::size_t k = 0; k < sums.forces.size(); ++k) {
    const Real* const row = &rows[6 * k];
    sums.forces[k] = {Vec3(row[0], row[1], row[2]), Vec3(row[3], row[4], row[5])};
  }
  return sums;
}

void write_header(MPI_Comm comm, Hdf5Writer& file, const CheckpointInfo& info, const Frame& frame) {
  file.attribute("format", format_version);
  file.attribute("step", frame.clock.step);
  file.attribute("time", frame.clock.time());
  file.attribute("dt", frame.clock.dt);
  file.attribute("substeps", static_cast<std::int64_t>(frame.clock.substeps));
  file.attribute("seed", info.seed);
  file.attribute("program_version", info.program_version);
  if (!frame.fountains.empty()) {
    std::vector<Real> notes, speeds;
    for (const FountainState& fountain : frame.fountains) {
      notes.push_back(fountain.note);
      speeds.push_back(fountain.speed);
    }
    file.attribute("fountain_note", std::span<const Real>(notes));
    file.attribute("fountain_speed", std::span<const Real>(speeds));
  }
  file.text("/scene", info.scene_text);
  file.attribute("scene_overrides", info.scene_overrides);
  file.attribute("scene_checksum", checksum(info.scene_text));
  if (!info.music.empty()) write_on_root(comm, file, "/music", info.music);
  if (!info.obstacle_files.empty()) write_on_root(comm, file, "/obstacle_files", info.obstacle_files);
  write_flow(comm, file, frame.flow);
  write_force_sums(comm, file, frame.force_sums);
  if (!frame.bodies.empty()) write_on_root(comm, file, "/bodies", numbers_of(frame.bodies));
  if (frame.supplied_energy != 0)
    write_on_root(comm, file, "/supplied_energy", std::vector<Real>{frame.supplied_energy});
  if (!frame.paddle_offsets.empty())
    write_on_root(comm, file, "/paddle_offsets",
                  std::vector<Real>(frame.paddle_offsets.begin(), frame.paddle_offsets.end()));
  if (frame.first_cell != std::array<LocalId, 3>{}) {
    write_on_root(comm, file, "/first_cell",
                  std::vector<std::int64_t>(frame.first_cell.begin(), frame.first_cell.end()));
  }
}

// Each block of rows has its own checksum, so that an error can name the rows. HDF5's Fletcher-32 is not used, because
// it requires chunks and that HDF5 itself handles the rows (hdf5_writer.hpp says why it does not).
constexpr std::int64_t rows_per_block = 1024;

/// The last block may be shorter.
template <class T>
std::vector<std::int64_t> block_checksums(std::span<const T> rows) {
  std::vector<std::int64_t> sums((rows.size() + rows_per_block - 1) / rows_per_block);
  for_each_part(static_cast<LocalId>(sums.size()), [&](LocalId k) {
    const std::size_t first = static_cast<std::size_t>(k) * rows_per_block;
    const auto block = rows.subspan(first, std::min<std::size_t>(rows_per_block, rows.size() - first));
    sums[static_cast<std::size_t>(k)] = checksum({reinterpret_cast<const char*>(block.data()), block.size_bytes()});
  });
  return sums;
}

/// The block that begins at row `row`, or the number of blocks up to the end of the table.
std::int64_t block_at(std::int64_t row) { return (row + rows_per_block - 1) / rows_per_block; }

RowSlice blocks_of(RowSlice rows) {
  const std::int64_t first = block_at(rows.first);
  return {first, block_at(rows.first + rows.count) - first, block_at(rows.total)};
}

template <class T>
void write_column(Hdf5Writer& file, const std::string& name, const std::vector<T>& rows, RowSlice slice) {
  file.write("/particles/" + name, rows, slice);
  file.write("/checksums/" + name, block_checksums(std::span<const T>(rows)), blocks_of(slice));
}

void write_particles(MPI_Comm comm, Hdf5Writer& file, const Particles& particles) {
  const IdOrder order(comm, particles.id, rows_per_block);
  const RowSlice slice{order.first_row(), static_cast<std::int64_t>(order.ids().size()), order.total()};
  write_column(file, "id", order.ids(), slice);
  for_each_saved_field(
      particles, [&](const char* name, const auto& field) { write_column(file, name, order.apply(field), slice); });
}

[[noreturn]] void fail_damaged(const std::string& path, const std::string& what) {
  throw DamagedFile(
      fmt::format("{}: {}: not what its checksum says; the file is damaged, use another copy or an older "
                  "checkpoint",
                  path, what));
}

/// What a restart reads from, on one rank: the file and the rows that this rank is responsible for.
struct Source {
  std::string path;
  Hdf5Reader file;
  RowSlice slice;
};

template <class T>
void check_column(const Source& source, const std::string& name, const std::vector<T>& rows) {
  const auto written = source.file.read<std::int64_t>("/checksums/" + name, blocks_of(source.slice));
  const auto found = block_checksums(std::span<const T>(rows));
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k] == written[k]) continue;
    const std::int64_t first = source.slice.first + static_cast<std::int64_t>(k) * rows_per_block;
    const std::int64_t last = std::min(first + rows_per_block, source.slice.total) - 1;
    fail_damaged(source.path, fmt::format("/particles/{}: rows {} to {}", name, first, last));
  }
}

ParticleRows read_checked_rows(const Source& source) {
  for (const char* name : {"/particles/id", "/particles/velocity"}) {  // which a particle file may lack
    if (source.file.has(name)) continue;
    throw DamagedFile(
        fmt::format("{}: {}: missing; a restart needs a whole checkpoint, use another file", source.path, name));
  }
  ParticleRows rows = read_particle_rows(source.file, source.slice);
  check_column(source, "id", rows.id);
  for_each_saved_field(rows, [&](const char* name, const auto& field) { check_column(source, name, field); });
  return rows;
}

void check_header(const std::string& path, const CheckpointState& state) {
  const auto refuse = [&](const char* name, const auto& value) {
    throw DamagedFile(fmt::format("{}: attribute {}: cannot be {}; use another checkpoint", path, name, value));
  };
  if (state.step < 0) refuse("step", state.step);
  if (!(state.dt > 0) || !std::isfinite(state.dt)) refuse("dt", state.dt);
  if (state.substeps < 1) refuse("substeps", state.substeps);
  for (const Real offset : state.paddle_offsets)
    if (!std::isfinite(offset)) refuse("paddle_offsets", offset);
  if (!std::isfinite(state.supplied_energy)) refuse("supplied_energy", state.supplied_energy);
  const auto& text = state.info.scene_text;
  const auto lines = std::count(text.begin(), text.end(), '\n');
  if (state.info.scene_overrides < 0 || state.info.scene_overrides > lines)
    refuse("scene_overrides", state.info.scene_overrides);
}

CheckpointState read_slice(const std::string& path, int rank, int size, int readers) {
  Source source{path, Hdf5Reader(path, readers), {}};
  const Hdf5Reader& file = source.file;
  source.slice = equal_slice(file.rows<Vec3>("/particles/position"), rank, size, rows_per_block);
  CheckpointState state;
  const std::int64_t format = file.integer_attribute("format");
  state.info.program_version = file.text_attribute("program_version");
  if (format != format_version)
    throw InputError(
        fmt::format("{}: attribute format: {}, but only {} is known here; restart with trevi {}, which wrote it", path,
                    format, format_version, state.info.program_version));
  state.step = file.integer_attribute("step");
  state.dt = file.real_attribute("dt");
  state.time = file.real_attribute("time");
  state.substeps = static_cast<int>(file.integer_attribute("substeps"));
  state.info.seed = file.integer_attribute("seed");
  state.info.scene_text = file.text("/scene");
  state.info.scene_overrides = file.integer_attribute("scene_overrides");
  state.info.music = read_checksums(file, "/music");
  state.info.obstacle_files = read_checksums(file, "/obstacle_files");
  state.flow = read_flow(path, file);
  state.first_cell = read_first_cell(path, file);
  state.force_sums = read_force_sums(path, file);
  if (file.has("/bodies")) state.bodies = bodies_of(path, file);
  if (file.has("/supplied_energy")) state.supplied_energy = file.read<Real>("/supplied_energy", {0, 1, 1})[0];
  for (const char* name : {"/paddle_offsets", "/paddle_ways"}) {  // the second by version 2.0.0
    if (!file.has(name)) continue;
    const std::int64_t paddles = file.rows<Real>(name);
    state.paddle_offsets = file.read<Real>(name, {0, paddles, paddles});
  }
  if (checksum(state.info.scene_text) != file.integer_attribute("scene_checksum")) fail_damaged(path, "/scene");
  check_header(path, state);
  state.rows = read_checked_rows(source);
  return state;
}

}  // namespace

void write_checkpoint(MPI_Comm comm, const std::string& path, const CheckpointInfo& info, const Frame& frame) {
  const std::string temporary = path + ".tmp";
  try {
    Hdf5Writer file(comm, temporary);
    write_header(comm, file, info, frame);
    write_particles(comm, file, frame.particles);
    file.close();
  } catch (const Error&) {  // thrown by all ranks alike
    if (rank_of(comm) == 0) std::remove(temporary.c_str());
    throw;
  }
  on_root(comm, [&] { publish_file(temporary, path); });
}

CheckpointState read_checkpoint(MPI_Comm comm, const std::string& path) {
  CheckpointState state;
  const int readers = ranks_of_machine(comm);
  all_or_none(comm, [&] { state = read_slice(path, rank_of(comm), size_of(comm), readers); });
  check_particle_rows(comm, state.rows, path);
  return state;
}

}  // namespace trevi

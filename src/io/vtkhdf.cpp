#include "io/vtkhdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "io/files.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr const char* prefix = "particles_";
constexpr const char* suffix = ".hdf";

/// This rank's share of rows that ranks give in rank order.
RowSlice in_rank_order(MPI_Comm comm, std::int64_t count) {
  RowSlice slice{0, count, 0};
  MPI_Exscan(&count, &slice.first, 1, MPI_INT64_T, MPI_SUM, comm);
  if (rank_of(comm) == 0) slice.first = 0;  // MPI_Exscan leaves it undefined there
  MPI_Allreduce(&count, &slice.total, 1, MPI_INT64_T, MPI_SUM, comm);
  return slice;
}

std::vector<std::array<float, 3>> single_precision(const std::vector<Vec3>& rows) {
  std::vector<std::array<float, 3>> converted(rows.size());
  std::transform(rows.begin(), rows.end(), converted.begin(), [](const Vec3& row) -> std::array<float, 3> {
    return {static_cast<float>(row[0]), static_cast<float>(row[1]), static_cast<float>(row[2])};
  });
  return converted;
}

/// particles.hdf.series, on rank 0: the frames on disk with their times, replaced in one stroke.
class FrameSeries {
 public:
  FrameSeries(const std::string& path, std::optional<std::int64_t> restart_step) : path_(path) {
    if (!restart_step || !std::filesystem::exists(path)) return;
    const Json old = Json::parse(read_text(path), nullptr, false);
    if (old.is_discarded() || !old.is_object() || !old["files"].is_array()) return;
    for (const Json& file : old["files"]) {
      const auto step = step_in_name(file.value("name", ""), prefix, suffix);
      if (!step || *step > *restart_step) continue;
      files_.push_back(file);
      last_step_ = *step;
    }
    write();
  }

  void add(const Clock& clock, const std::string& name) {
    files_.push_back(Json{{"name", name}, {"time", clock.time()}});
    last_step_ = clock.step;
    write();
  }

  std::int64_t last_step() const { return last_step_; }

 private:
  using Json = nlohmann::ordered_json;

  void write() const {
    // One frame a line, for people and diff.
    std::string text = "{\n  \"file-series-version\": \"1.0\",\n  \"files\": [";
    for (std::size_t k = 0; k < files_.size(); ++k)
      text += fmt::format("{}\n    {}", k == 0 ? "" : ",", files_[k].dump());
    replace_file(path_, text + "\n  ]\n}\n");
  }

  std::string path_;
  std::vector<Json> files_;
  std::int64_t last_step_ = -1;
};

class VtkHdfWriter : public Observer {
 public:
  VtkHdfWriter(MPI_Comm comm, FrameOptions options) : comm_(comm), options_(std::move(options)) {
    on_root(comm_, [&] {
      if (options_.restart_step) set_aside_after(options_.directory, prefix, suffix, *options_.restart_step);
      list_.emplace(options_.directory + "/particles.hdf.series", options_.restart_step);
      last_step_ = list_->last_step();
    });
    MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
  }

  bool due(const Clock& clock) const override { return clock.step > last_step_ && options_.schedule.due(clock); }
  bool wants_density() const override { return wanted("density"); }

  void observe(const Frame& frame) override {
    const std::string name = prefix + step_digits(frame.clock.step) + suffix;
    const std::string path = options_.directory + "/" + name, temporary = path + ".tmp";
    try {
      VtkHdfFile file(comm_, temporary, frame.particles.position);
      write_fields(file, frame);
      file.close();
    } catch (const Error&) {  // thrown by all ranks alike
      if (rank_of(comm_) == 0) std::remove(temporary.c_str());
      throw;
    }
    on_root(comm_, [&] {
      publish_file(temporary, path);
      list_->add(frame.clock, name);
    });
    last_step_ = frame.clock.step;
  }

 private:
  bool wanted(const std::string& field) const {
    return std::find(options_.fields.begin(), options_.fields.end(), field) != options_.fields.end();
  }

  void write_fields(VtkHdfFile& file, const Frame& frame) const {
    const Particles& particles = frame.particles;
    const std::size_t count = particles.id.size();
    if (wanted("velocity")) file.field("velocity", single_precision(particles.velocity));
    if (wanted("density")) file.field("density", std::vector<float>(frame.density.begin(), frame.density.end()));
    if (wanted("id")) file.field("id", particles.id);
    if (wanted("rank")) file.field("rank", std::vector<std::int32_t>(count, rank_of(comm_)));
    if (wanted("rgb")) file.field("rgb", colours_of(options_.colour, particles));
  }

  MPI_Comm comm_;
  FrameOptions options_;
  std::optional<FrameSeries> list_;  ///< rank 0 only
  std::int64_t last_step_ = -1;      ///< of the last frame listed
};

}  // namespace

VtkHdfFile::VtkHdfFile(MPI_Comm comm, const std::string& path, const std::vector<Vec3>& points)
    : file_(comm, path), points_(in_rank_order(comm, static_cast<std::int64_t>(points.size()))) {
  const std::int64_t version[] = {1, 0};
  file_.attribute("/VTKHDF/Version", std::span<const std::int64_t>(version));
  file_.attribute("/VTKHDF/Type", std::string("UnstructuredGrid"));
  // Ranks without particles have no partition; VTK wants one at least.
  const bool partition = points_.count > 0 || (points_.total == 0 && rank_of(comm) == 0);
  write_cells(in_rank_order(comm, partition ? 1 : 0));
  file_.write("/VTKHDF/Points", points, points_);
}

void VtkHdfFile::write_cells(RowSlice partitions) {
  const auto count = static_cast<std::size_t>(points_.count);
  const std::vector<std::int64_t> sizes(static_cast<std::size_t>(partitions.count), points_.count);
  for (const char* name : {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"}) {
    file_.write(std::string("/VTKHDF/") + name, sizes, partitions);
  }
  std::vector<std::int64_t> numbers(count + static_cast<std::size_t>(partitions.count));
  std::iota(numbers.begin(), numbers.end(), 0);
  // Cell k of a partition begins at place k of the connectivity, and is point k; one more place marks the end.
  file_.write("/VTKHDF/Offsets", numbers,
              {points_.first + partitions.first, points_.count + partitions.count, points_.total + partitions.total});
  numbers.resize(count);
  file_.write("/VTKHDF/Connectivity", numbers, points_);
  constexpr std::uint8_t vertex = 1;
  file_.write("/VTKHDF/Types", std::vector<std::uint8_t>(count, vertex), points_);
}

std::unique_ptr<Observer> make_vtkhdf_writer(MPI_Comm comm, FrameOptions options) {
  return std::make_unique<VtkHdfWriter>(comm, std::move(options));
}

}  // namespace trevi

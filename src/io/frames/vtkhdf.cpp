#include "io/frames/vtkhdf.hpp"

#include <numeric>

#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// This rank's slice of rows that ranks provide in rank order.
RowSlice in_rank_order(MPI_Comm comm, std::int64_t count) {
  return {sum_over_lower_ranks(comm, count), count, sum_over_ranks(comm, count)};
}

class VtkHdfWriter : public FrameWriter {
 public:
  VtkHdfWriter(MPI_Comm comm, FrameOptions options)
      : FrameWriter(comm, std::move(options), {"VtkHdfFrames", vtkhdf_list, "", {vtkhdf_frames}}) {}

 private:
  void write(const Frame& frame, const std::string& path) override {
    const std::string temporary = path + ".tmp";
    try {
      VtkHdfFile file(comm(), temporary, frame.particles.position, {options().single_points, options().short_cells});
      for (const OutputField* field : fields()) file.field(field->name, field->format, rows_of(*field, frame).get());
      file.close();
    } catch (const Error&) {  // thrown by all ranks alike
      if (rank_of(comm()) == 0) std::remove(temporary.c_str());
      throw;
    }
    on_root(comm(), [&] { publish_file(temporary, path); });
  }
};

}  // namespace

VtkHdfFile::VtkHdfFile(MPI_Comm comm, const std::string& path, const std::vector<Vec3>& points, Layout layout)
    : file_(comm, path), points_(in_rank_order(comm, static_cast<std::int64_t>(points.size()))) {
  const std::int64_t version[] = {1, 0};
  file_.attribute("/VTKHDF/Version", std::span<const std::int64_t>(version));
  file_.attribute("/VTKHDF/Type", std::string("UnstructuredGrid"));
  // Ranks without particles have no partition; VTK requires at least one.
  const bool partition = points_.count > 0 || (points_.total == 0 && rank_of(comm) == 0);
  write_cells(in_rank_order(comm, partition ? 1 : 0), layout.short_cells);
  file_.write("/VTKHDF/Points", point_format(layout.single_points), points_,
              point_rows(points, layout.single_points).get());
}

void VtkHdfFile::write_cells(RowSlice partitions, bool is_short) {
  const std::vector<std::int64_t> sizes(static_cast<std::size_t>(partitions.count), points_.count);
  for (const char* name : {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"}) {
    file_.write(std::string("/VTKHDF/") + name, sizes, partitions);
  }
  constexpr std::uint8_t vertex = 1;
  if (is_short) {
    write_numbers<std::int32_t>(partitions);
    file_.write_constant("/VTKHDF/Types", vertex, points_.total);
  } else {
    write_numbers<std::int64_t>(partitions);
    file_.write("/VTKHDF/Types", std::vector<std::uint8_t>(static_cast<std::size_t>(points_.count), vertex), points_);
  }
}

template <class Integer>
void VtkHdfFile::write_numbers(RowSlice partitions) {
  const auto count = static_cast<std::size_t>(points_.count);
  std::vector<Integer> numbers(count + static_cast<std::size_t>(partitions.count));
  std::iota(numbers.begin(), numbers.end(), Integer{0});
  // Cell k of a partition begins at entry k of the connectivity, and is point k; one more entry marks the end.
  file_.write("/VTKHDF/Offsets", numbers,
              {points_.first + partitions.first, points_.count + partitions.count, points_.total + partitions.total});
  numbers.resize(count);
  file_.write("/VTKHDF/Connectivity", numbers, points_);
}

std::unique_ptr<Observer> make_vtkhdf_writer(MPI_Comm comm, FrameOptions options) {
  return std::make_unique<VtkHdfWriter>(comm, std::move(options));
}

}  // namespace trevi

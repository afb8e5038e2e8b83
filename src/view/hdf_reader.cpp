// VTKHDF frames. A partition corresponds to a rank that had particles.
#include "io/hdf5/hdf5_reader.hpp"
#include "trevi/error.hpp"
#include "view/frame_reader.hpp"

namespace trevi {

namespace {

template <class T>
std::vector<T> field(const Hdf5Reader& file, const std::string& name, RowSlice all) {
  const std::string path = "/VTKHDF/PointData/" + name;
  return file.has(path) ? file.read<T>(path, all) : std::vector<T>();
}

}  // namespace

RawFrame read_hdf_frame(const std::string& path) {
  const Hdf5Reader file(path);
  RawFrame raw;
  const std::int64_t count = file.rows<Vec3>("/VTKHDF/Points");
  const std::int64_t partitions = file.rows<std::int64_t>("/VTKHDF/NumberOfPoints");
  const RowSlice all{0, count, count};
  raw.rank_counts = file.read<std::int64_t>("/VTKHDF/NumberOfPoints", {0, partitions, partitions});
  std::int64_t counted = 0;
  for (const std::int64_t points : raw.rank_counts) {
    const bool sound = points >= 0 && points <= count - counted;
    if (!sound) throw InputError(path + ": its partitions do not fit its points; use another copy");
    counted += points;
  }
  if (counted != count) throw InputError(path + ": its partitions do not add up to its points; use another copy");
  raw.position = file.read<Vec3>("/VTKHDF/Points", all);
  for (const auto& v : field<std::array<float, 3>>(file, "velocity", all))
    raw.speed.push_back(std::hypot(v[0], v[1], v[2]));
  raw.density = field<float>(file, "density", all);
  raw.id = field<std::int64_t>(file, "id", all);
  raw.rgb = field<std::array<std::uint8_t, 3>>(file, "rgb", all);
  return raw;
}

}  // namespace trevi

#include "io/frames/obstacle_frames.hpp"

#include <fmt/format.h>

#include <cstring>

#include "io/run_directory/files.hpp"

namespace trevi {

namespace {

/// Consecutive arrays, each preceded by its size in bytes, as VTK has them in a file of appended raw data.
class AppendedArrays {
 public:
  /// Returns the offset at which it begins.
  template <class T>
  std::size_t add(const std::vector<T>& rows) {
    const std::size_t begin = bytes_.size();
    const std::uint64_t size = rows.size() * sizeof(T);
    append(&size, sizeof(size));
    append(rows.data(), size);
    return begin;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void append(const void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }
  std::string bytes_;
};

}  // namespace

std::string vtp_text(const ObstacleSurface& surface) {
  std::vector<std::array<float, 3>> points;
  for (const Vec3& p : surface.mesh.points)
    points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  std::vector<std::int32_t> ends;
  for (std::size_t k = 0; k < surface.mesh.triangles.size(); ++k) ends.push_back(static_cast<std::int32_t>(3 * k + 3));
  AppendedArrays arrays;
  const std::size_t numbers = arrays.add(surface.obstacle), places = arrays.add(points),
                    corners = arrays.add(surface.mesh.triangles), offsets = arrays.add(ends);
  constexpr const char* format = R"(<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
  <PolyData>
    <Piece NumberOfPoints="{}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{}">
      <CellData Scalars="obstacle">
        <DataArray type="Int32" Name="obstacle" format="appended" offset="{}"/>
      </CellData>
      <Points>
        <DataArray type="Float32" Name="Points" NumberOfComponents="3" format="appended" offset="{}"/>
      </Points>
      <Polys>
        <DataArray type="Int32" Name="connectivity" format="appended" offset="{}"/>
        <DataArray type="Int32" Name="offsets" format="appended" offset="{}"/>
      </Polys>
    </Piece>
  </PolyData>
  <AppendedData encoding="raw">
   _{}
  </AppendedData>
</VTKFile>
)";
  return fmt::format(format, points.size(), ends.size(), numbers, places, corners, offsets, arrays.bytes());
}

ObstacleFrames::ObstacleFrames(std::shared_ptr<const ObstacleSurfaces> surfaces, std::string folder, bool own_list,
                               std::optional<std::int64_t> restart_step)
    : surfaces_(std::move(surfaces)), folder_(std::move(folder)) {
  if (restart_step) set_aside_after(folder_, obstacle_frames, *restart_step);
  if (surfaces_->any_stays()) replace_file(folder_ + still_obstacles, vtp_text(surfaces_->standing()));
  if (own_list && surfaces_->any_moves()) list_.emplace(folder_ + obstacle_list, restart_step);
}

std::vector<std::string> ObstacleFrames::write(const Clock& clock, std::span<const BodyState> bodies) {
  std::vector<std::string> names;
  if (surfaces_->any_stays()) names.emplace_back(still_obstacles);
  if (!surfaces_->any_moves()) return names;
  names.push_back(name_of_step(obstacle_frames, clock.step));
  replace_file(folder_ + names.back(), vtp_text(surfaces_->moving(clock.time(), bodies)));
  if (list_) list_->add(clock, names.back());
  return names;
}

}  // namespace trevi

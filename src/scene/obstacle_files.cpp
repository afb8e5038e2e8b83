#include "scene/obstacle_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "base/hash.hpp"
#include "boundary/geometry/closed_mesh.hpp"
#include "boundary/geometry/shape.hpp"
#include "boundary/volume_map/volume_map.hpp"
#include "io/frames/mesh_file.hpp"
#include "parallel/collective.hpp"
#include "scene/scene_obstacle.hpp"
#include "scene/scene_place.hpp"
#include "solver/check_input.hpp"

namespace trevi {
namespace {

template <class T>
void broadcast(MPI_Comm comm, std::vector<T>& rows) {
  auto count = static_cast<std::int64_t>(rows.size());
  MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm);
  rows.resize(static_cast<std::size_t>(count));
  MPI_Bcast(rows.data(), static_cast<int>(rows.size() * sizeof(T)), MPI_BYTE, 0, comm);
}

[[noreturn]] void refuse(const std::string& path, int line, const std::string& what) {
  throw InputError(fmt::format("{}:{}: {}; write time,x,y,z in s and m, times increasing", path, line, what));
}

// Whether a line begins with a word that is not a number, as the names of columns do.
bool begins_with_word(const std::string& line) {
  if (std::isalpha(static_cast<unsigned char>(line[0])) == 0) return false;
  char* end = nullptr;
  std::strtod(line.c_str(), &end);  // "nan", "inf"
  return end == line.c_str() || std::isalpha(static_cast<unsigned char>(*end)) != 0;
}

// Lines "time,x,y,z"; empty lines, and those that begin with # or a word, are skipped.
std::vector<ObstacleKnot> read_knots(MPI_Comm comm, const std::string& path) {
  std::istringstream lines(read_file_everywhere(comm, path));
  std::vector<ObstacleKnot> knots;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // the byte order mark of some editors
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#' || begins_with_word(line)) continue;
    ObstacleKnot knot;
    int end = 0;
    if (std::sscanf(line.c_str(), " %lf , %lf , %lf , %lf %n", &knot.time, &knot.center[0], &knot.center[1],
                    &knot.center[2], &end) != 4 ||
        static_cast<std::size_t>(end) != line.size() || !knot.center.allFinite() || !std::isfinite(knot.time))
      refuse(path, number, "not four numbers");
    if (!knots.empty() && knot.time <= knots.back().time) refuse(path, number, "not later than the line before");
    if (!knots.empty() &&
        (knot.center - knots.back().center).cwiseAbs().maxCoeff() > fastest_obstacle * (knot.time - knots.back().time))
      refuse(path, number, "further from the line before than 10000 m/s would take it");
    if (!is_place(knot.center)) refuse(path, number, "further than a million km from the origin");
    knots.push_back(knot);
  }
  if (knots.size() < 2) refuse(path, 1, "fewer than two times and places");
  return knots;
}

template <class T>
std::int64_t checksum_of(const std::vector<T>& rows) {
  return checksum({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(T)});
}

void check_size(const Scene& scene, const ObstacleSettings& obstacle) {
  constexpr Real max_bytes = 1e9;
  constexpr Real least = 1e-3;  // spacings, of the longest edge
  const Box bounds = bounds_of(obstacle);
  const Real length = (bounds.max - bounds.min).maxCoeff();
  if (length < least * scene.fluid.spacing) {
    throw InputError(
        fmt::format("it is {:.3g} m long, less than a thousandth of the spacing, and no water would feel it; "
                    "make it larger, a mesh by its scale",
                    length));
  }
  if (VolumeMap::min_bytes(bounds, scene.fluid.kernel_radius) <= max_bytes) return;
  throw InputError(
      fmt::format("it is {:.3g} m long, and its map would not fit in memory; it need not go on far beyond the box, so "
                  "make it smaller",
                  (bounds.max - bounds.min).maxCoeff()));
}

void check_twins(const Scene& scene) {
  const auto begin = scene.obstacles.begin();
  for (auto one = begin; one != scene.obstacles.end(); ++one) {
    const auto twin = std::find_if(begin, one, [&](const auto& other) { return is_same_solid(*one, other); });
    if (twin == one) continue;
    const SceneTable table("obstacle", static_cast<std::size_t>(one - begin));
    const SceneTable other("obstacle", static_cast<std::size_t>(twin - begin));
    told_at(scene, table, "", [&] {
      throw InputError(fmt::format("is the same as that of line {}, and would count twice; remove one of them",
                                   other.line_in(scene)));
    });
  }
}

}  // namespace

std::shared_ptr<TriangleMesh> read_mesh(MPI_Comm comm, const std::string& path, Real scale) {
  auto mesh = std::make_shared<TriangleMesh>();
  on_root(comm, [&] { *mesh = read_mesh_file(path); });
  broadcast(comm, mesh->points);
  broadcast(comm, mesh->triangles);
  if (const std::string wrong = why_not_closed(*mesh); !wrong.empty())
    throw InputError(path + ": the mesh is not closed: " + wrong +
                     "; mend it, or give the sheet a thickness, as only a closed surface has an inside");
  if (is_flat(*mesh)) throw InputError(path + ": the mesh encloses no volume; give the sheet a thickness");
  for (Vec3& p : mesh->points) p *= scale;
  face_outwards(*mesh);
  if (const std::string where = where_shells_overlap(*mesh); !where.empty())
    throw InputError(path + ": one of its shells reaches into another at " + where +
                     " m; join them to one surface, or make two obstacles of them");
  return mesh;
}

void read_obstacle_files(MPI_Comm comm, Scene& scene) {
  for (std::size_t k = 0; k < scene.obstacles.size(); ++k) {
    ObstacleSettings& obstacle = scene.obstacles[k];
    const SceneTable table("obstacle", k);
    if (obstacle.shape == ShapeKind::mesh)
      obstacle.mesh = told_at(scene, table, "path", [&] { return read_mesh(comm, obstacle.path, obstacle.scale); });
    if (!obstacle.motion.empty())
      obstacle.knots = told_at(scene, table, "motion", [&] { return read_knots(comm, obstacle.motion); });
    told_at(scene, table, "", [&] { check_size(scene, obstacle); });
  }
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    BodySettings& body = scene.bodies[k];
    const SceneTable table("body", k);
    if (body.shape == ShapeKind::mesh)
      body.mesh = told_at(scene, table, "path", [&] { return read_mesh(comm, body.path, body.scale); });
    told_at(scene, table, "", [&] { check_size(scene, body); });
  }
  check_twins(scene);
}

std::vector<std::int64_t> obstacle_checksums(const Scene& scene) {
  std::vector<std::int64_t> sums;
  for (const ObstacleSettings& obstacle : solids_of(scene)) {
    std::uint64_t mesh = 0;
    if (obstacle.mesh)
      mesh = mix(static_cast<std::uint64_t>(checksum_of(obstacle.mesh->points))) ^
             static_cast<std::uint64_t>(checksum_of(obstacle.mesh->triangles));
    sums.push_back(static_cast<std::int64_t>(mesh));
    sums.push_back(obstacle.motion.empty() ? 0 : checksum_of(obstacle.knots));
  }
  return sums;
}

}  // namespace trevi

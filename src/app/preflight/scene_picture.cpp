#include "app/preflight/scene_picture.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/preflight/canvas.hpp"
#include "boundary/geometry/tessellation.hpp"
#include "io/frames/obstacle_surfaces.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr int width = 1280, height = 960;
constexpr Colour3 stone{0.62F, 0.58F, 0.54F}, water{0.25F, 0.55F, 0.95F}, pump{0.95F, 0.5F, 0.1F},
    sink{0.8F, 0.15F, 0.3F}, gauge{0.1F, 0.65F, 0.25F}, edges{0.55F, 0.55F, 0.55F};
constexpr std::array<Colour3, 3> axes{Colour3{0.85F, 0.1F, 0.1F}, {0.1F, 0.6F, 0.1F}, {0.1F, 0.2F, 0.85F}};
constexpr std::string_view signature = "\x89PNG";

// Cells of the initial lattice, or larger ones if there would be too many: which of them contain water.
class WetCells {
 public:
  WetCells(MPI_Comm comm, const Scene& scene) : box_(scene.domain) {
    constexpr Real max_cells = 4e6, rounding = 1e-9;
    const Vec3 extent = box_.max - box_.min;
    cell_ = std::max(scene.fluid.spacing, std::cbrt(extent.prod() / max_cells));
    for (Eigen::Index a = 0; a < 3; ++a) count_[a] = std::max(1L, std::lround(std::ceil(extent[a] / cell_ - rounding)));
    wet_.assign(static_cast<std::size_t>(count_.prod()), 0);
    const Particles particles = initial_particles(comm, scene);
    for (const Vec3& p : particles.position) {
      const Cell cell = ((p - box_.min) / cell_).array().floor().cast<long>().cwiseMin(count_ - 1).cwiseMax(0);
      wet_[index(cell)] = 1;
    }
    MPI_Allreduce(MPI_IN_PLACE, wet_.data(), static_cast<int>(wet_.size()), MPI_BYTE, MPI_BOR, comm);
  }

  /// The faces between wet and dry cells.
  TriangleMesh surface() const {
    TriangleMesh mesh;
    for (long n = 0; n < count_.prod(); ++n) {
      const Cell cell(n / (count_.y() * count_.z()), n / count_.z() % count_.y(), n % count_.z());
      if (!is_wet(cell)) continue;
      for (Eigen::Index a = 0; a < 3; ++a) {
        for (const long side : {-1L, 1L}) {
          Cell beside = cell;
          beside[a] += side;
          if (!is_wet(beside)) add_face(cell, a, side, mesh);
        }
      }
    }
    return mesh;
  }

 private:
  using Cell = Eigen::Array<long, 3, 1>;

  std::size_t index(const Cell& c) const {
    return static_cast<std::size_t>((c.x() * count_.y() + c.y()) * count_.z() + c.z());
  }
  bool is_wet(const Cell& c) const { return (c >= 0).all() && (c < count_).all() && wet_[index(c)] != 0; }

  void add_face(const Cell& cell, Eigen::Index axis, long side, TriangleMesh& mesh) const {
    const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto first = static_cast<std::int32_t>(mesh.points.size());
    for (const auto& [du, dv] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      Vec3 corner = cell.cast<Real>().matrix();
      corner[axis] += side > 0 ? 1 : 0;
      corner[u] += du;
      corner[v] += dv;
      mesh.points.push_back((box_.min + cell_ * corner).cwiseMin(box_.max));
    }
    if (side > 0) {
      mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
    } else {
      mesh.triangles.insert(mesh.triangles.end(), {{first, first + 2, first + 1}, {first, first + 3, first + 2}});
    }
  }

  Box box_;
  Real cell_ = 0;
  Cell count_ = Cell::Zero();
  std::vector<char> wet_;
};

TriangleMesh placed(TriangleMesh mesh, const Vec3& center, const Vec3& direction = Vec3::UnitZ()) {
  const auto rotation = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), direction);
  for (Vec3& p : mesh.points) p = center + rotation * p;
  return mesh;
}

TriangleMesh cylinder(Real radius, Real tall) {
  return turned({{0, 0}, {radius, 0}, {radius, tall}, {0, tall}}, radius / 50);
}

TriangleMesh cuboid(const Vec3& low, const Vec3& high) {
  return placed(cuboid_surface((high - low) / 2), (low + high) / 2);
}

// A disc as wide as the opening, and an arrow along the jet.
TriangleMesh arrow(Real radius, Real length) {
  const Real shaft = std::min(radius, length) / 5, disc = length / 20;
  return turned(
      {{0, 0}, {radius, 0}, {radius, disc}, {shaft, disc}, {shaft, length / 2}, {3 * shaft, length / 2}, {0, length}},
      radius / 50);
}

void draw_openings(const Scene& scene, Canvas& canvas) {
  const Real s = scene.fluid.spacing;
  for (const FountainSettings& one : scene.fountains)
    canvas.draw(placed(arrow(one.diameter / 2, std::max(one.height, 4 * s)),
                       {one.center[0], one.center[1], scene.domain.min.z()}, one.direction),
                pump);
  for (const InletSettings& one : scene.inlets) {
    const Real radius = one.shape == InletShape::disc ? one.radius : std::min(one.size[0], one.size[1]) / 2;
    canvas.draw(placed(arrow(radius, 4 * s), one.center, one.direction), pump);
  }
  for (const GaugeSettings& one : scene.gauges)
    canvas.draw(placed(turned(arc(s, 0, s, s / 50), s / 50), one.center), gauge);
}

void draw_drains(const Scene& scene, Canvas& canvas) {
  constexpr float opacity = 0.35F;
  for (const DrainSettings& one : scene.drains) {
    if (one.shape == DrainShape::box) canvas.draw_glass(cuboid(one.min, one.max), sink, opacity);
    if (one.shape == DrainShape::cylinder)
      canvas.draw_glass(placed(cylinder(one.radius, one.height), one.center, one.axis), sink, opacity);
    if (one.shape == DrainShape::plane)  // a plate, whose other half, which is not drained, hides nothing
      canvas.draw_glass(placed(cylinder(4 * scene.fluid.spacing, scene.fluid.spacing / 4), one.center, one.axis), sink,
                        opacity);
  }
}

void draw_box(const Box& box, Canvas& canvas) {
  for (Eigen::Index a = 0; a < 3; ++a) {
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 from = box.min;
      if ((corner & 1) != 0) from[(a + 1) % 3] = box.max[(a + 1) % 3];
      if ((corner & 2) != 0) from[(a + 2) % 3] = box.max[(a + 2) % 3];
      Vec3 to = from;
      to[a] = box.max[a];
      canvas.draw_line(from, to, corner == 0 ? axes[static_cast<std::size_t>(a)] : edges);
    }
  }
}

void check_size(const Scene& scene) {
  constexpr Real most = 2e7;
  Real particles = 0;
  for (const ParticleSource& source : scene.particles)
    particles += (source.max - source.min).prod() / std::pow(scene.fluid.spacing, 3);
  if (particles > most)
    throw InputError(
        fmt::format("{}: some {:.0e} particles are too many for a picture; draw it with a larger spacing, for "
                    "example --set fluid.spacing={:.2g}",
                    scene.path, particles, scene.fluid.spacing * std::cbrt(particles / 1e6)));
}

// The sentence with which a name is refused; empty for a valid one.
std::string why_no_picture(const std::string& file) {
  namespace fs = std::filesystem;
  if (fs::path(file).extension() != ".png") return file + ": pictures are PNG files; give a name that ends in .png";
  const fs::path folder = fs::path(file).parent_path();
  if (!folder.empty() && !fs::is_directory(folder))
    return file + ": there is no folder " + folder.string() + "; make it";
  if (!fs::exists(file)) return {};
  std::string begin(signature.size(), ' ');
  std::ifstream(file, std::ios::binary).read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return fs::is_regular_file(file) && begin == signature
             ? ""
             : file + ": is there already and is no picture; choose another name";
}

}  // namespace

void write_scene_picture(const Session& session, const Scene& scene, const std::string& file) {
  on_root(session.comm(), [&] {
    const std::string problem = why_no_picture(file);
    if (!problem.empty()) throw InputError("--picture " + problem);
  });
  check_size(scene);
  const WetCells cells(session.comm(), scene);
  on_root(session.comm(), [&] {
    Canvas canvas(scene.domain, width, height);
    if (has_solids(scene)) {
      const ObstacleSurfaces surfaces(solids_of(scene), scene.fluid.spacing / 50, scene.bodies.size());
      canvas.draw(surfaces.standing().mesh, stone);
      canvas.draw(surfaces.moving(0).mesh, stone);
    }
    draw_openings(scene, canvas);
    draw_box(scene.domain, canvas);
    canvas.draw_glass(cells.surface(), water, 0.55F);
    draw_drains(scene, canvas);
    replace_file(file, canvas.png());
  });
}

}  // namespace trevi

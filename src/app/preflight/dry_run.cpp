#include "app/preflight/dry_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <numeric>

#include "app/build.hpp"
#include "app/preflight/advice.hpp"
#include "app/preflight/envelope.hpp"
#include "app/preflight/run_cost.hpp"
#include "app/preflight/wave_text.hpp"
#include "boundary/geometry/mass_properties.hpp"
#include "fluid/filters/xsph_viscosity.hpp"
#include "fluid/forcings/inlet.hpp"
#include "io/frames/frame_sets.hpp"
#include "io/writers.hpp"
#include "parallel/reductions.hpp"
#include "scene/initial_particles.hpp"
#include "scene/lattice.hpp"
#include "scene/scene_flow.hpp"
#include "solver/density_solver.hpp"
#include "solver/first_slabs.hpp"
#include "solver/halo_traffic.hpp"

namespace trevi {

namespace {

// Bytes that the solver keeps for a particle with a full neighbourhood; the part of these that the stages of its step
// borrow (base/scratch.hpp), and the part of the search alone; and bytes for a ghost, and for a cell of the box.
struct BytesEach {
  double owned, borrowed, search, ghost, cell;
};

BytesEach bytes_each(const Scene& scene) {
  const bool single = scene.density.precision == Precision::single;
  const double quad = single ? 16 : 32;
  // Neighbours per particle: those in a ball of radius h without itself, minus a twentieth for walls and surfaces.
  const double pairs = 0.95 * (4.19 * std::pow(scene.fluid.kernel_radius / scene.fluid.spacing, 3) - 1);
  const bool filters = scene.vorticity || scene.viscosity || scene.kinematic_viscosity;
  double owned = 3 * 24 + 8 + quad;  // positions, velocity, id; record
  double ghost = quad;
  double cell = 2 * 4;       // counts and starts
  double sweeps = 8 + quad;  // rho, delta
  if (scene.density.method == Method::chebyshev) sweeps += quad / 4;
  if (scene.density.coarse_grid)
    sweeps += 2 * quad / 4 + (scene.density.tolerance ? 8 : 0);  // what they are told, and densities that they saw
  // Velocities, curls, and velocities before them; or velocities, those between the Laplacians, and gradients.
  const double gradients = scene.kinematic_viscosity ? 4 * quad : 0;
  const double filtering = filters ? quad + std::max(quad + 24, gradients) : 0;
  if (filters) ghost += quad + gradients;
  if (scene.colour == Colour::rainbow_x) owned += 2 * 4;
  if (scene.output.series) owned += 24;                                  // positions at the search, for the drift
  const double borrowed = 13 + 2 * pairs + std::max(sweeps, filtering);  // with the list
  return {owned + borrowed, borrowed, 3 * quad / 4, ghost, cell};
}

// Memory for the cells of the coarse grid in a plane: its columns extend two cells above the highest water that the
// scene specifies. The levels of its multigrid have a third of the cells of the finest one.
double coarse_bytes(const Scene& scene, const CellGrid& grid) {
  const Vec3 gravity = scene.gravity.value_or(Vec3::Zero());
  if (!scene.density.coarse_grid || !(gravity.isZero() || is_downward(gravity))) return 0;
  // Moments, fits, noise and its fits; their columns are allocated in units of four.
  constexpr double sums = (26 + 13 + 12 + 13) * 8, fields = 4 * 8 + 1 + 3 * 8, pressure = 8 * 8 * 4 / 3.0;
  Real top = scene.domain.min.z();
  for (const ParticleSource& source : scene.particles)
    top = std::max(top, source.type == ParticleSource::Type::block ? source.max.z() : scene.domain.max.z());
  const Real cell = (scene.domain.max.z() - scene.domain.min.z()) / grid.columns();
  const Real columns = std::min<Real>(std::ceil((top - scene.domain.min.z()) / cell) + 2, grid.columns());
  return (grid.rows() + 2.0) * (4 * std::ceil(columns / 4) * sums + (columns + 2.0) * (fields + pressure));
}

// The most that the inlets add by the end of the run: particles of inlets that recycle are already there.
std::string inlet_text(const Scene& scene) {
  if (scene.inlets.empty()) return "";
  const Real spacing = scene.fluid.spacing;
  Real more = 0;
  for (const InletSettings& inlet : scene.inlets) {
    const Real seconds = std::max(0.0, std::min(inlet.stop, scene.end) - inlet.start);
    const auto places = static_cast<Real>(InletLattice(inlet, spacing).open_places());
    if (!inlet.recycle) more += std::floor(inlet.top_speed() * seconds / spacing) * places;
  }
  return fmt::format("inlets      at most {:.0f} particles more by the end, {:.1f} MB\n", more,
                     more * bytes_each(scene).owned / 1e6);
}

std::string schedule_text(const Schedule& schedule) {
  if (schedule.every_steps > 0) return fmt::format("every {} steps", schedule.every_steps);
  if (schedule.every > 0) return fmt::format("every {} s", schedule.every);
  return "at the start and the end";
}

std::string slab_table(const Scene& scene, const CellGrid& grid, const std::vector<Real>& weights, const Slabs& slabs) {
  const int ranks = slabs.ranks();
  const BytesEach bytes = bytes_each(scene);
  std::string text;
  for (int r = 0; r < ranks; ++r) {
    const CellWindow own = slabs.window(r, grid.rows());
    const auto first = weights.begin() + own.planes.begin, last = weights.begin() + own.planes.end;
    // If a slab is divided: as if its water were equally high in all rows.
    const Real share = static_cast<Real>(own.rows.size()) / grid.rows(), planes = own.planes.size();
    const Real owned = std::accumulate(first, last, 0.0) * share;
    const Real beside = (first > weights.begin() ? *(first - 1) : 0) + (last < weights.end() ? *last : 0);
    const LocalId rows_beside = (own.rows.begin > 0 ? 1 : 0) + (own.rows.end < grid.rows() ? 1 : 0);
    const Real ghosts = beside * share + (owned + beside * share) * rows_beside / own.rows.size();
    // The coarse grid has a ring of empty cells around each plane.
    const double cells = (own.rows.size() + 2.0) * (grid.columns() + 2.0) * (planes + 2);
    const double coarse = coarse_bytes(scene, grid) * (planes + 2) * (own.rows.size() + 2.0) / (grid.rows() + 2.0);
    const double more = std::max(coarse - owned * bytes.borrowed, 0.0);  // the projection has no list yet
    // With ghosts of the projection's cells, the memory that is given back has no room for the search's coordinates.
    const double search = ranks > 1 ? owned * bytes.search : 0;
    const double memory = owned * bytes.owned + ghosts * bytes.ghost + cells * bytes.cell + more + search;
    const std::string rows = slabs.parts() == 1 ? "" : fmt::format(", rows {} to {}", own.rows.begin, own.rows.end - 1);
    text += fmt::format("  rank {:<4} planes {} to {}{}: {:.0f} particles, {:.0f} ghosts ({:.1f} %), {:.1f} MB\n", r,
                        own.planes.begin, own.planes.end - 1, rows, owned, ghosts, owned > 0 ? 100 * ghosts / owned : 0,
                        memory / 1e6);
  }
  return text;
}

std::string time_text(const Scene& scene) {
  const Real h = scene.fluid.kernel_radius, cfl = scene.cfl > 0 ? scene.cfl.value() : 0.4;
  const Real viscous = longest_viscous_step(scene.kinematic_viscosity.value_or(0), lattice_of(scene.fluid), h);
  return fmt::format("time        {} steps of {:.6g} s; dt by CFL {}: {:.3g} s at {:.3g} m/s{}{}\n", scene.steps(),
                     scene.dt, cfl, longest_step(scene, cfl), expected_speed(scene),
                     std::isfinite(viscous) ? fmt::format(", by viscosity {:.3g} s", viscous) : "",
                     scene.cfl > 0 ? "; longer steps are split" : "");
}

std::string duration_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.2g} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 3e5) return fmt::format("{:.1f} h", seconds / 3600);
  return fmt::format("{:.1f} days", seconds / 86400);
}

// From the speed of a pool at rest; a splash has a similar number of pairs, but its steps may be split. `most` is the
// number of particles of the fullest rank.
std::string run_time_text(const Scene& scene, double most, const MeasuredSpeed& speed) {
  const double substep = speed.substep * most, steps = static_cast<double>(scene.steps());
  const double least = steps * substep * static_cast<double>(speed.substeps);
  const double split = scene.cfl > 0 ? std::ceil(scene.dt / longest_step(scene, scene.cfl.value())) : 1;
  const double longest = std::max(least, steps * substep * split);
  return fmt::format(
      "run time    {}{}, files left out, by {:.3g} ms for a step of {} particles at rest, measured now\n",
      duration_text(least), longest > least ? " to " + duration_text(longest) : "",
      1e3 * speed.substep * static_cast<double>(speed.substeps) * speed.particles, with_commas(speed.particles));
}

// Places of blocks without water, and where obstacles are. `particles` exist at the start.
std::string obstacle_text(const Scene& scene, double particles) {
  std::string text;
  GlobalId places = 0;
  bool blocks = true;
  for (const ParticleSource& source : scene.particles) {
    blocks = blocks && source.type == ParticleSource::Type::block;
    if (blocks) places += Lattice(source, scene.fluid.spacing).size();
  }
  const double left_out = static_cast<double>(places) - particles;
  if (blocks && left_out > 0)
    text += fmt::format("left out    {:.0f} of {} places of the blocks: in obstacles, or above a surface\n", left_out,
                        places);
  for (std::size_t k = 0; k < scene.obstacles.size(); ++k) {
    const ObstacleSettings& obstacle = scene.obstacles[k];
    const auto& [min, max] = place_of(obstacle);
    const std::string lid = fmt::format(", a vessel: solid all around it, also above z = {:.4g}", max.z());
    text += fmt::format("obstacle {:<2} from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m{}{}{}\n", k,
                        min.x(), min.y(), min.z(), max.x(), max.y(), max.z(), obstacle.moves() ? " at the start" : "",
                        obstacle.inside                      ? lid
                        : obstacle.shape == ShapeKind::basin ? ", open at the top"
                                                             : "",
                        scene.domain.contains(min) && scene.domain.contains(max) ? "" : ", reaches out of the box");
  }
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    const BodySettings& body = scene.bodies[k];
    const auto& [min, max] = place_of(body);
    const Real volume = mass_properties(body).volume, mass = body.mass ? *body.mass : *body.density * volume;
    text += fmt::format(
        "body {:<6} from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m, {:.4g} kg, {:.3g} of its volume of "
        "water\n",
        k, min.x(), min.y(), min.z(), max.x(), max.y(), max.z(), mass, mass / (volume * scene.fluid.rest_density));
  }
  return text;
}

// How often each axis is cut, and what the halos then send; for water at rest, with aligned cuts of adjacent slabs.
std::string shape_text(const Scene& scene, const CellGrid& grid, double particles, const Slabs& slabs) {
  const RestingWater water = resting_water(scene, grid, particles);
  const Traffic all = halo_traffic(water, all_ranks(water, slabs.slabs(), slabs.parts()));
  std::string text = fmt::format("slabs       {} planes along {}, {} ranks", grid.planes(),
                                 scene.slab_axis == 0 ? "x" : "y", slabs.ranks());
  if (slabs.parts() > 1)
    text += fmt::format(", {} for each of {} slabs of {} rows", slabs.parts(), slabs.slabs(), grid.rows());
  if (scene.ranks_by_model) text += fmt::format("; ranks = [{}, {}] by the model", slabs.slabs(), slabs.parts());
  return text + fmt::format("\nhalos       {} and {:.0f} messages a substep of all ranks, water at rest\n",
                            size_text(all.bytes), all.messages);
}

double fullest(const std::vector<Real>& weights, const Slabs& slabs) {
  double most = 0;
  for (int r = 0; r < slabs.ranks(); ++r)
    most = std::max(most,
                    std::accumulate(weights.begin() + slabs.first_plane(r), weights.begin() + slabs.end_plane(r), 0.0) /
                        slabs.parts());
  return most;
}

std::string frame_set_text(const Scene& scene, std::size_t k, double particles) {
  const FrameSetSettings& set = scene.output.frames[k];
  const FrameSetCost cost = cost_of(scene, set, particles);
  const char* what = set.what == FrameContent::cells ? "cells" : set.format == FrameFormat::vtu ? "VTU" : "VTKHDF";
  return fmt::format("  {:<11} {}, {}, up to {} each, {:.0f} of them, {}\n", folder_of(set, k),
                     schedule_text(set.schedule), what, size_text(cost.bytes), cost.frames,
                     size_text(cost.frames * cost.bytes));
}

std::string output_text(const Scene& scene, const std::string& directory, double particles) {
  std::string text = fmt::format("output      {}\n", directory);
  const OutputSettings& output = scene.output;
  if (output.series) text += fmt::format("  series.csv  {}\n", schedule_text(*output.series));
  if (const std::optional<Schedule> rows = schedule_of_gauges(scene))
    text += fmt::format("  gauges.csv  {}, {} gauges\n", schedule_text(*rows), scene.gauges.size());
  if (output.vtu) text += fmt::format("  VTU         {}\n", schedule_text(output.vtu->schedule));
  if (output.vtkhdf) text += fmt::format("  VTKHDF      {}\n", schedule_text(output.vtkhdf->schedule));
  for (std::size_t k = 0; k < output.frames.size(); ++k) text += frame_set_text(scene, k, particles);
  if (output.checkpoint) {
    text +=
        fmt::format("  checkpoint  {}, keep {}\n", schedule_text(output.checkpoint->schedule), output.checkpoint->keep);
  }
  return text;
}

}  // namespace

void print_dry_run(const Session& session, const Scene& scene, const Launch& launch, const std::string& directory) {
  make_scene_flow(session.comm(), scene);  // reads the music, so that an invalid note is found here
  const CellGrid grid = cell_grid(scene, scene.domain);
  std::vector<Real> weights;
  const Slabs slabs = initial_slabs(session.comm(), scene, grid, weights);
  MeasuredSpeed speed = measured_speed(scene);
  speed.substep = max_over_ranks(session.comm(), speed.substep);
  if (session.rank() != 0) return;
  const double particles = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::string text = fmt::format("scene       {}\n", scene.path);
  text += fmt::format("launch      {}\n", launch_text(launch, scene));
  text += fmt::format("particles   {:.0f}, {:.6g} kg each\n", particles, water_mass(scene.fluid));
  text += fmt::format("space       {:.4g} m³ of water, {:.4g} m³ open\n",
                      particles * water_mass(scene.fluid) / scene.fluid.rest_density, open_volume(scene));
  text += fmt::format("{}{}{}", obstacle_text(scene, particles), wave_text(scene), inlet_text(scene));
  text += fmt::format("{}{}", shape_text(scene, grid, particles, slabs), slab_table(scene, grid, weights, slabs));
  if (!scene.gravity) text += "gravity     none, nothing falls; a table [gravity] adds it\n";
  text += fmt::format("{}{}", time_text(scene), run_time_text(scene, fullest(weights, slabs), speed));
  const double bytes = output_bytes(scene, particles);
  text += fmt::format("{}  in all      up to {}\n", output_text(scene, directory, particles), size_text(bytes));
  std::vector<std::string> warnings = start_warnings(scene);
  for (std::string& warning : volume_warnings(scene, particles)) warnings.push_back(std::move(warning));
  for (std::string& warning : scene_advice(scene)) warnings.push_back(std::move(warning));
  for (std::string& warning : disk_warnings(bytes, directory)) warnings.push_back(std::move(warning));
  for (const std::string& warning : warnings) text += fmt::format("warning     {}\n", warning);
  std::fputs(text.c_str(), stdout);  // reports no error on a full disk: the final flush does
}

}  // namespace trevi

#include "scene/scene_physics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fluid/filters/xsph_viscosity.hpp"
#include "kernels/kernels.hpp"
#include "scene/scene_body.hpp"
#include "scene/scene_fountain.hpp"
#include "scene/scene_gauge.hpp"
#include "scene/scene_inlet.hpp"
#include "scene/scene_method.hpp"
#include "scene/scene_obstacle.hpp"
#include "scene/scene_particles.hpp"
#include "scene/scene_periodic.hpp"
#include "scene/scene_plane.hpp"
#include "scene/scene_ranks.hpp"
#include "scene/scene_waves.hpp"

namespace trevi {
namespace {

/// With three digits, for messages that name an upper limit.
std::string rounded_down(Real positive) {
  const Real unit = std::pow(10, std::floor(std::log10(positive)) - 2);
  return fmt::format("{:.3g}", std::floor(positive / unit) * unit);
}

class PhysicsReader {
 public:
  PhysicsReader(Section& root, Scene& scene)
      : root_(root), scene_(scene), domain_(root.child("domain")), fluid_(root.child("fluid")) {}

  void read() {
    Section density = root_.child("density"), viscosity = root_.child("viscosity");
    read_preset(density);  // first: it changes what absent keys of the other tables mean
    read_domain();
    read_fluid();
    read_particles();
    read_time();
    read_method(root_, density, scene_);
    read_viscosity(viscosity);
    resolve(viscosity);
    for (Section& obstacle : root_.children("obstacle")) read_obstacle(obstacle, scene_);
    for (Section& maker : root_.children("wavemaker"))
      read_wavemaker(maker, scene_, {box_known(), fluid_.fine("spacing")});
    for (Section& zone : root_.children("damping")) read_damping(zone, scene_, box_known());
    for (Section& body : root_.children("body")) read_body(body, scene_);
    check_bodies(root_, scene_);
    for (Section& fountain : root_.children("fountain")) read_fountain(fountain, scene_, box_known());
    for (Section& inlet : root_.children("inlet")) read_inlet(inlet, scene_, {box_known(), fluid_.fine("spacing")});
    for (Section& drain : root_.children("drain")) read_drain(drain, scene_, {box_known(), fluid_.fine("spacing")});
    check_flow(root_, scene_);
    density.check("method", scene_.density.method != Method::anderson || !has_solids(scene_),
                  "anderson mixes positions with no regard to obstacles; take \"chebyshev\" or \"jacobi\"");
    for (Section& gauge : root_.children("gauge")) read_gauge(gauge, scene_, box_known());
    domain_.reject_unknown();
    fluid_.reject_unknown();
    density.reject_unknown();
    viscosity.reject_unknown();
  }

 private:
  void read_preset(Section& density);
  void read_domain();
  void read_fluid();
  void read_particles();
  void read_time();
  void read_viscosity(Section& viscosity);
  void resolve(Section& viscosity);
  void check_viscosity(Section& viscosity);

  bool box_known() const { return domain_.fine("min") && domain_.fine("max"); }
  bool check_kernel_radius();
  void check_cells();
  void check_coordinates();

  Section& root_;
  Scene& scene_;
  Section domain_, fluid_;
  bool dt_known_ = false;
};

void PhysicsReader::read_preset(Section& density) {
  bool report = false;
  density.choice<bool>({"preset", "the values of absent keys"}, report, {{"default", false}, {"report", true}});
  static_cast<Settings&>(scene_) = report ? report_settings() : Settings{};
}

void PhysicsReader::read_domain() {
  read_dimensions(domain_, scene_);
  domain_.numbers({"min", "the lower corner of the box [x, y, z] in metres", true}, scene_.domain.min);
  domain_.numbers({"max", "the upper corner of the box [x, y, z] in metres", true}, scene_.domain.max);
  int axis = 0;
  if (domain_.choice<int>({"slab_axis", "the axis along which ranks share the box; default the longest horizontal one"},
                          axis, {{"x", 0}, {"y", 1}}))
    scene_.slab_axis = axis;
  read_periodic(domain_, scene_);
  domain_.choice<SlabCuts>(
      {"slabs", "each rank's share: the same work, followed as the water moves, or the same planes"}, scene_.slabs,
      {{"balanced", SlabCuts::balanced}, {"equal", SlabCuts::equal}});
  read_ranks(domain_, scene_);
}

void PhysicsReader::read_fluid() {
  FluidSettings& fluid = scene_.fluid;
  fluid_.number({"spacing", "the lattice spacing in metres", true}, fluid.spacing, above(0));
  fluid_.number({"rest_density", "the density at rest in kg/m³"}, fluid.rest_density, above(0));
  read_derived(fluid_, {"kernel_radius", "the kernel radius h in metres; default twice the spacing"},
               fluid.kernel_radius, above(0));
  fluid_.choice<Mass>({"mass", "how the mass of a particle is chosen"}, fluid.mass,
                      {{"calibrated", Mass::calibrated}, {"volume", Mass::volume}});
  fluid_.choice({"density_kernel", "the kernel of the density; default spiky"}, fluid.density_kernel, kernel_names());
  std::string gradient_kernel;
  if (fluid_.choice({"gradient_kernel",
                     "the kernel along whose gradient particles are shifted; default the one that goes with "
                     "density_kernel"},
                    gradient_kernel, kernel_names()))
    fluid.gradient_kernel = gradient_kernel;
  check_plane(domain_, scene_);
  const Vec3 extent = scene_.domain.max - scene_.domain.min;
  if (box_known())
    domain_.check("max", extent.minCoeff() > 0, "must be greater than min on every axis; enlarge the box");
}

// Far from the origin the gaps between numbers grow, until a shift of a particle is lost in them.
void PhysicsReader::check_coordinates() {
  constexpr Real finest = 1e-6;  // of the spacing
  const Real farthest = std::max(scene_.domain.min.cwiseAbs().maxCoeff(), scene_.domain.max.cwiseAbs().maxCoeff());
  if (!box_known() || !fluid_.fine("spacing")) return;
  const char* corner = farthest > scene_.domain.max.cwiseAbs().maxCoeff() ? "min" : "max";
  domain_.check(
      corner, farthest * std::numeric_limits<Real>::epsilon() <= finest * scene_.fluid.spacing,
      fmt::format("{} m from the origin, places are too coarse for a spacing of {} m; move the scene to the origin",
                  farthest, scene_.fluid.spacing));
}

// Checked before anything is derived from it: with an absurd radius the sums over the lattice would hardly end.
bool PhysicsReader::check_kernel_radius() {
  constexpr Real rounding = 1e-9;  // 0.06 / 0.05 need not be 1.2 or more
  if (!fluid_.fine("spacing") || !fluid_.fine("kernel_radius")) return false;
  if (!scene_.fluid.kernel_radius.given()) return true;
  const Real h = scene_.fluid.kernel_radius, ratio = h / scene_.fluid.spacing;
  return fluid_.check("kernel_radius", ratio >= min_kernel_ratio - rounding && ratio <= largest_kernel_ratio + rounding,
                      fmt::format("must be {} to {} times the spacing {} m, got {} m; give about twice the spacing",
                                  min_kernel_ratio, largest_kernel_ratio, scene_.fluid.spacing, h));
}

void PhysicsReader::check_cells() {
  constexpr Real max_cells = 1e6, max_cells_in_plane = 2e9;
  if (!box_known()) return;
  const Real h = scene_.fluid.kernel_radius;
  const Vec3 extent = scene_.domain.max - scene_.domain.min;
  const char* origin = fluid_.given("kernel_radius") ? "" : " (the default)";
  const Real least = scene_.fluid.dimensions == 2 ? std::min(extent.x(), extent.z()) : extent.minCoeff();
  if (!fluid_.check("kernel_radius", h <= least,
                    fmt::format("must not exceed the smallest extent of the box, {} m, got {} m{}; enlarge the box or "
                                "refine",
                                least, h, origin)))
    return;
  domain_.check("max", extent.maxCoeff() <= max_cells * h,
                fmt::format("the box is {} m long, more than a million kernel radii of {} m; check the units",
                            extent.maxCoeff(), h));
  const Real cells = extent[1 - scene_.slab_axis] * extent.z() / (h * h);
  domain_.check("max", cells < max_cells_in_plane,
                fmt::format("a plane across the slab axis has {:.3g} cells of the kernel radius {} m, where 2e9 can be "
                            "counted; make the box smaller, or take another slab_axis",
                            cells, h));
}

// The meaning of absent keys, and the rules that depend on it.
void PhysicsReader::resolve(Section& viscosity) {
  if (!check_kernel_radius()) return;
  static_cast<Settings&>(scene_) = resolved(scene_);
  check_cells();
  check_coordinates();
  if (box_known()) check_periodic(domain_, scene_);
  check_viscosity(viscosity);
}

void PhysicsReader::read_particles() {
  std::vector<Section> sections = root_.children("particles");
  root_.check("particles", !sections.empty() || root_.given("inlet"),
              "missing; add at least one [[particles]] table, a block or a file");
  for (Section& section : sections) read_particle_source(section, scene_, {box_known(), fluid_.fine("spacing")});
}

void PhysicsReader::read_time() {
  Section time = root_.child("time");
  time.number({"dt", "the time step in seconds", true}, scene_.dt, above(0));
  time.number({"end", "the simulated time in seconds", true}, scene_.end, at_least(0));
  read_derived(time,
               {"cfl",
                "the CFL number that splits a step; 0 never splits; default 2, 0.2 without gravity, and 0 with another "
                "method than the default one"},
               scene_.cfl, at_least(0));
  time.integer({"max_substeps", "the largest number of substeps of a step, above which the run ends; default 500"},
               scene_.max_substeps, 1);
  dt_known_ = time.fine("dt");
  if (dt_known_) {
    const Real steps = scene_.end / scene_.dt;
    time.check("end", steps <= max_counted, fmt::format("{:.1e} steps are too many; check end and dt", steps));
    time.check("end", scene_.end == 0 || steps >= 0.5,
               fmt::format("{} s is shorter than half a step of {} s, so nothing would move; give a later end or a "
                           "smaller dt, or end = 0 for the start alone",
                           scene_.end, scene_.dt));
  }
  time.reject_unknown();
}

void PhysicsReader::read_viscosity(Section& section) {
  Real c = scene_.viscosity.value_or(0.001), nu = 0;
  section.number({"c", "the XSPH viscosity in m³/kg, a fraction per step; default 0.001 where nu is absent"}, c,
                 at_least(0));
  section.number({"nu", "the kinematic viscosity in m²/s, the same for any dt and spacing, in place of c"}, nu,
                 at_least(0));
  section.check(
      "nu", !section.given("c") || !section.given("nu"),
      "c is given, too; keep nu (m²/s, the same for any dt and spacing) or c (a fraction per step), not both");
  section.flag({"no_slip", "whether walls and obstacles hold the water that touches them; with nu"}, scene_.no_slip);
  section.check("no_slip", !scene_.no_slip || section.given("nu"), "is for a viscosity in m²/s; give nu, too");
  if (section.given("nu")) {
    scene_.viscosity.reset();  // that of the preset
    scene_.kinematic_viscosity = nu;
  } else if (section.present()) {
    scene_.viscosity = c;
  }
}

// XSPH must not move a velocity beyond the mean of its neighbours.
void PhysicsReader::check_viscosity(Section& section) {
  const FluidSettings& fluid = scene_.fluid;
  if (scene_.viscosity && section.fine("c") && fluid_.fine("rest_density")) {
    const Real c = *scene_.viscosity;
    const bool own = section.given("c");
    (own ? section : fluid_)
        .check(own ? "c" : "rest_density", c * fluid.rest_density <= 1 + 1e-12,
               fmt::format("XSPH would overshoot: c * rest_density must not exceed 1, got {} * {}; lower [viscosity] c",
                           c, fluid.rest_density));
  }
  if (!scene_.kinematic_viscosity || !dt_known_ || !section.fine("nu")) return;
  const int parts = scene_.cfl > 0 ? scene_.max_substeps : 1;
  const Real nu = *scene_.kinematic_viscosity;
  const Real largest = parts * longest_viscous_step(1, lattice_of(fluid), fluid.kernel_radius);  // nu dt, m²
  if (nu * scene_.dt <= largest * (1 + 1e-9)) return;
  const std::string remedy =
      fmt::format("lower nu to {} or dt to {}", rounded_down(largest / scene_.dt), rounded_down(largest / nu));
  section.check("nu", false,
                scene_.cfl > 0 ? fmt::format("would split steps into more than {} parts; {}", parts, remedy)
                               : fmt::format("XSPH would overshoot in a step of {} s; {}, or let time.cfl split steps",
                                             scene_.dt, remedy));
}

}  // namespace

void read_physics(Section& root, Scene& scene) { PhysicsReader(root, scene).read(); }

}  // namespace trevi

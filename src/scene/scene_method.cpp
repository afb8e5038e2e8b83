#include "scene/scene_method.hpp"

#include <fmt/format.h>

#include "scene/scene_plane.hpp"

namespace trevi {

void read_derived(Section& section, const Key& key, Derived<Real>& target, const Interval& range) {
  Real value = 0;
  if (section.number(key, value, range)) target = value;
}

namespace {

/// A request to stop is noticed between two steps, so a step must not take hours.
constexpr int max_iterations = 10000;

void read_density(Section& section, DensitySettings& density) {
  section.choice<Method>(
      {"method", "how the density iteration is accelerated"}, density.method,
      {{"jacobi", Method::jacobi}, {"chebyshev", Method::chebyshev}, {"anderson", Method::anderson}});
  int iterations = 1;
  if (section.integer({"iterations", "the number of density iterations, at most when tolerance is given"}, iterations,
                      1))
    density.iterations = iterations;
  section.check("iterations", iterations <= max_iterations,
                fmt::format("must be at most {}; a step of more would hardly end", max_iterations));
  Real tolerance = 0;
  if (section.number({"tolerance", "the mean compression to stop at; default: never stop early"}, tolerance, above(0)))
    density.tolerance = tolerance;
  section.number({"spectral_radius", "chebyshev: the spectral radius assumed of the relaxed iteration"},
                 density.spectral_radius, {.low = 0, .high = 1, .with_high = false});
  bool coarse_grid = false;
  if (section.flag({"coarse_grid", "whether the first iteration is the coarse-grid correction"}, coarse_grid))
    density.coarse_grid = coarse_grid;
  read_derived(
      section,
      {"max_shift", "what a pair is pushed apart at most in one iteration in units of kernel_radius; 0: no cap"},
      density.max_shift, at_least(0));
  section.number({"epsilon", "the regularisation in 1/m² at spacing 0.1 m"}, density.epsilon, at_least(0));
  read_derived(section, {"relaxation", "the factor on each position correction; default: as the kernel allows"},
               density.relaxation, {.low = 0, .high = 2, .with_low = false});
  section.choice<Constraint>({"constraint", "whether stretched fluid is pulled together, too"}, density.constraint,
                             {{"equality", Constraint::equality}, {"inequality", Constraint::inequality}});
  section.check(
      "constraint", density.constraint == Constraint::inequality || density.method != Method::chebyshev,
      "with density.method = \"chebyshev\" an equality pulls particles into clumps that explode: a cube's energy "
      "grows by 13,000 in a second; leave it out, or take density.preset = \"report\"");
  section.number(
      {"crush_limit", "the mean compression from which on the run warns that its water is crushed; default 0.05, 5 %"},
      density.crush_limit, above(0));
  section.choice<Precision>({"precision", "the arithmetic of the pair loops"}, density.precision,
                            {{"double", Precision::double_}, {"single", Precision::single}});
}

void read_walls(Section& root, Scene& scene) {
  Section section = root.child("walls");
  WallSettings& walls = scene.walls;
  section.number({"restitution", "the fraction of speed kept in a bounce"}, walls.restitution, {.low = 0, .high = 1});
  section.choice<WallDensity>({"density", "what the fluid feels of a wall"}, walls.density,
                              {{"none", WallDensity::none}, {"analytic", WallDensity::analytic}});
  section.choice<Reflection>({"reflection", "what restitution scales: the normal part, or all as in the report"},
                             walls.reflection, {{"normal", Reflection::normal}, {"report", Reflection::report}});
  section.number({"floor_friction", "the skin friction coefficient of the floor"}, walls.floor_friction, at_least(0));
  section.reject_unknown();
}

void read_tensile(Section& root, Scene& scene) {
  Section section = root.child("tensile");
  TensileSettings tensile = scene.tensile.value_or(TensileSettings{});
  section.number({"k", "the strength of the artificial pressure in m² at spacing 0.1 m"}, tensile.k, at_least(0));
  section.integer({"n", "the exponent of the artificial pressure"}, tensile.n, 1);
  section.number({"dq", "the reference distance in units of kernel_radius"}, tensile.dq,
                 {.low = 0, .high = 1, .with_low = false, .with_high = false});
  if (section.present()) scene.tensile = tensile;
  section.reject_unknown();
}

void read_forces(Section& root, Scene& scene) {
  Section section = root.child("gravity");
  if (section.present()) {
    Vec3 acceleration(0, 0, -9.8);
    section.numbers({"acceleration", "the acceleration [x, y, z] in m/s²"}, acceleration);
    check_along_plane(section, scene, "acceleration", acceleration);
    scene.gravity = acceleration;
  }
  section.reject_unknown();
}

void read_vorticity(Section& root, Scene& scene) {
  Section vorticity = root.child("vorticity");
  Real epsilon = scene.vorticity.value_or(0.002);  // a table without its key means the value of the report
  vorticity.number({"epsilon", "the strength of the vorticity confinement"}, epsilon, at_least(0));
  vorticity.choice<VorticityForm>({"form", "the report's, or projected to what keeps linear momentum"},
                                  scene.vorticity_form,
                                  {{"report", VorticityForm::report}, {"projected", VorticityForm::projected}});
  if (vorticity.present()) scene.vorticity = epsilon;
  vorticity.reject_unknown();
}

}  // namespace

void read_method(Section& root, Section& density, Scene& scene) {
  read_forces(root, scene);
  read_density(density, scene.density);
  read_walls(root, scene);
  read_tensile(root, scene);
  read_vorticity(root, scene);
}

}  // namespace trevi

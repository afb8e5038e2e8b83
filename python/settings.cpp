// Settings and scenes. Names, units and defaults are those of the scene file (inputs/README.md).
#include "base/simd.hpp"
#include "binding_helpers.hpp"

namespace trevi::python {

namespace {

void bind_enums(py::module_& m) {
  py::enum_<Mass>(m, "Mass").value("calibrated", Mass::calibrated).value("volume", Mass::volume);
  py::enum_<Method>(m, "Method")
      .value("jacobi", Method::jacobi)
      .value("chebyshev", Method::chebyshev)
      .value("anderson", Method::anderson);
  py::enum_<Constraint>(m, "Constraint")
      .value("equality", Constraint::equality)
      .value("inequality", Constraint::inequality);
  py::enum_<Precision>(m, "Precision").value("single", Precision::single).value("double", Precision::double_);
  py::enum_<VorticityForm>(m, "VorticityForm")
      .value("report", VorticityForm::report)
      .value("projected", VorticityForm::projected);
  py::enum_<Reflection>(m, "Reflection").value("normal", Reflection::normal).value("report", Reflection::report);
  py::enum_<SlabCuts>(m, "SlabCuts").value("balanced", SlabCuts::balanced).value("equal", SlabCuts::equal);
  py::enum_<WallDensity>(m, "WallDensity").value("none", WallDensity::none).value("analytic", WallDensity::analytic);
  py::enum_<GaugeKind>(m, "GaugeKind")
      .value("height", GaugeKind::height)
      .value("pressure", GaugeKind::pressure)
      .value("velocity", GaugeKind::velocity)
      .value("pressure_in_water", GaugeKind::pressure_in_water)
      .value("flow", GaugeKind::flow)
      .value("run_up", GaugeKind::run_up);
}

void bind_water(py::module_& m) {
  py::class_<Box> box(m, "Box", "A box with its faces along the axes, m.");
  box.def(py::init<>())
      .def_property("min", in_place(&Box::min), assigned(&Box::min), "lower corner, m")
      .def_property("max", in_place(&Box::max), assigned(&Box::max), "upper corner, m");
  closed(box);

  py::class_<FluidSettings> fluid(m, "FluidSettings", "[fluid]");
  fluid.def_readwrite("spacing", &FluidSettings::spacing, "of the start lattice, m")
      .def_readwrite("rest_density", &FluidSettings::rest_density, "kg/m³")
      .def_readwrite("mass", &FluidSettings::mass, "of a particle in the density")
      .def_readwrite("density_kernel", &FluidSettings::density_kernel, "kernel of the density, by its name")
      .def_readwrite("dimensions", &FluidSettings::dimensions, "3, or 2 for a layer in the plane y = 0");
  derived(fluid, "kernel_radius", &FluidSettings::kernel_radius, "h, m; None: 2 spacings");
  derived(fluid, "gradient_kernel", &FluidSettings::gradient_kernel,
          "kernel along whose gradient particles are shifted; None: the density kernel, or Spiky for Poly6");
  closed(fluid);

  py::class_<DensitySettings> density(m, "DensitySettings", "[density]");
  density.def_readwrite("method", &DensitySettings::method)
      .def_readwrite("tolerance", &DensitySettings::tolerance, "of the compression; None: all iterations are made")
      .def_readwrite("spectral_radius", &DensitySettings::spectral_radius, "chebyshev: of the Jacobi iteration")
      .def_readwrite("epsilon", &DensitySettings::epsilon, "relaxation of the constraint, 1/m² at spacing 0.1")
      .def_readwrite("constraint", &DensitySettings::constraint)
      .def_readwrite("precision", &DensitySettings::precision, "of the pair loops")
      .def_readwrite("crush_limit", &DensitySettings::crush_limit, "mean compression from which on water is crushed");
  derived(density, "iterations", &DensitySettings::iterations,
          "of the density solve; None: 3 with the coarse grid, else 4");
  derived(density, "relaxation", &DensitySettings::relaxation, "under-relaxation; None: by the kernel");
  derived(density, "coarse_grid", &DensitySettings::coarse_grid, "the projection on the cell grid; None: chebyshev");
  derived(density, "max_shift", &DensitySettings::max_shift, "of a pair in an iteration, in units of h; 0: no cap");
  closed(density);

  py::class_<WallSettings> walls(m, "WallSettings", "[walls]");
  walls.def_readwrite("restitution", &WallSettings::restitution, "fraction of speed kept in a bounce")
      .def_readwrite("density", &WallSettings::density)
      .def_readwrite("reflection", &WallSettings::reflection)
      .def_readwrite("floor_friction", &WallSettings::floor_friction, "skin friction coefficient of the floor");
  closed(walls);

  py::class_<TensileSettings> tensile(m, "TensileSettings", "[tensile], the artificial pressure");
  tensile.def(py::init<>())
      .def_readwrite("k", &TensileSettings::k, "m² at spacing 0.1")
      .def_readwrite("n", &TensileSettings::n)
      .def_readwrite("dq", &TensileSettings::dq, "in units of h");
  closed(tensile);
}

void bind_places(py::module_& m) {
  py::class_<GaugeSettings> gauge(m, "GaugeSettings", "[[gauge]]: a place where the water is measured");
  gauge.def(py::init<>())
      .def_readwrite("kind", &GaugeSettings::kind)
      .def_property("center", in_place(&GaugeSettings::center), assigned(&GaugeSettings::center), "m")
      .def_property("normal", in_place(&GaugeSettings::normal), assigned(&GaugeSettings::normal),
                    "pressure: out of the solid; flow: the way that counts as positive; run-up: level, up the beach")
      .def_property(
          "size", [](const GaugeSettings& one) { return py::make_tuple(one.size[0], one.size[1]); },
          [](GaugeSettings& one, const std::array<Real, 2>& size) { one.size[0] = size[0], one.size[1] = size[1]; },
          "flow: the edges of the rectangle, m; set as a whole")
      .def_readwrite("radius", &GaugeSettings::radius, "m");
  closed(gauge);
  py::bind_vector<std::vector<GaugeSettings>>(m, "Gauges");

  py::class_<DampingSettings> damping(m, "DampingSettings", "[[damping]]: a box in which waves end");
  damping.def(py::init<>())
      .def_property("min", in_place(&DampingSettings::min), assigned(&DampingSettings::min), "m")
      .def_property("max", in_place(&DampingSettings::max), assigned(&DampingSettings::max), "m")
      .def_readwrite("rate", &DampingSettings::rate, "1/s, at its end");
  derived(damping, "direction", &DampingSettings::direction,
          "along x or y, of length 1, to its end; None: to the nearest wall across the box");
  closed(damping);
  py::bind_vector<std::vector<DampingSettings>>(m, "Dampings");
}

}  // namespace

void bind_settings(py::module_& m) {
  bind_enums(m);
  bind_water(m);
  bind_solids(m);
  bind_places(m);
  bind_flow(m);
  bind_output(m);

  py::class_<Settings> settings(m, "Settings",
                                "What a solver is to do: SI units, names and defaults of the scene file. None stands "
                                "for a part that is absent, or for a default that follows from the other settings.");
  settings.def(py::init<>())
      .def_readwrite("domain", &Settings::domain, "the box, m")
      .def_property(
          "periodic",
          [](const Settings& one) { return py::make_tuple(one.periodic[0], one.periodic[1], one.periodic[2]); },
          [](Settings& one, const std::array<bool, 3>& periodic) { one.periodic = periodic; },
          "whether the box repeats along x, y, z; set as a whole")
      .def_readwrite("slabs", &Settings::slabs, "how planes are shared among ranks")
      .def_readwrite("ranks", &Settings::ranks, "slabs, and ranks that share each of them; None: a slab for each rank")
      .def_readwrite("ranks_by_model", &Settings::ranks_by_model, "in place of ranks what a model of the run says")
      .def_readwrite("fluid", &Settings::fluid)
      .def_readwrite("dt", &Settings::dt, "s")
      .def_readwrite("max_substeps", &Settings::max_substeps, "of a step; one that would need more ends the run")
      .def_readwrite("gravity", &Settings::gravity, "m/s², or None; set as a whole")
      .def_readwrite("density", &Settings::density)
      .def_readwrite("walls", &Settings::walls)
      .def_readwrite("obstacles", &Settings::obstacles, "paddle_of(wavemaker, domain) among them")
      .def_readwrite("bodies", &Settings::bodies, "that move freely")
      .def_readwrite("fountains", &Settings::fountains)
      .def_readwrite("inlets", &Settings::inlets)
      .def_readwrite("drains", &Settings::drains)
      .def_readwrite("dampings", &Settings::dampings)
      .def_readwrite("gauges", &Settings::gauges)
      .def_readwrite("tensile", &Settings::tensile, "artificial pressure, or None; set as a whole")
      .def_readwrite("vorticity", &Settings::vorticity, "epsilon of vorticity confinement, or None")
      .def_readwrite("vorticity_form", &Settings::vorticity_form)
      .def_readwrite("viscosity", &Settings::viscosity, "c of XSPH, m³/kg, or None")
      .def_readwrite("kinematic_viscosity", &Settings::kinematic_viscosity, "nu, m²/s, or None")
      .def_readwrite("no_slip", &Settings::no_slip, "walls and obstacles hold the water that touches them")
      .def_readwrite("output", &Settings::output, "files; none are written where its directory is empty")
      .def_readwrite("colour", &Settings::colour, "what \"rgb\" of the frames shows, or None")
      .def_readwrite("seed", &Settings::seed, "of the jitter of fountains and inlets");
  derived(settings, "slab_axis", &Settings::slab_axis, "0 x, 1 y; None: the longer one");
  derived(settings, "cfl", &Settings::cfl, "splits steps; 0: never; None: by method and gravity");
  closed(settings);

  py::class_<Scene, Settings>(m, "Scene", "A scene file that was read and checked: Settings and what a run needs.")
      .def_readonly("path", &Scene::path)
      .def_readonly("name", &Scene::name)
      .def_readonly("text", &Scene::text, "the file, with a line for each override")
      .def_readonly("end", &Scene::end, "s")
      .def_property_readonly("steps", &Scene::steps, "from the start to the end");

  m.def(
      "_read_scene",
      [](const std::string& path, const std::vector<std::string>& overrides, const py::object& comm) {
        return read_scene(comm_of(comm), path, overrides);
      },
      py::call_guard<Denormals>(), py::arg("path"), py::arg("overrides"), py::arg("comm"));
  m.def("report_settings", &report_settings, "The settings of density.preset = \"report\".");
}

}  // namespace trevi::python

// Obstacles, bodies that float, and paddles of the settings. Names, units and defaults are those of the scene file
// (inputs/README.md).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "binding_helpers.hpp"
#include "scene/obstacle_files.hpp"

namespace trevi::python {

namespace {

std::vector<std::string> names_of(const std::array<bool, 6>& free) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < free.size(); ++k) {
    if (free[k]) names.emplace_back(freedoms[k]);
  }
  return names;
}

std::array<bool, 6> freedoms_of(const std::vector<std::string>& names) {
  std::array<bool, 6> free{};
  for (const std::string& name : names) {
    const auto found = std::find(freedoms.begin(), freedoms.end(), name);
    if (found == freedoms.end())
      throw InputError(fmt::format("free: \"{}\" is none of {}", name, fmt::join(freedoms, ", ")));
    free[static_cast<std::size_t>(found - freedoms.begin())] = true;
  }
  return free;
}

template <class T, class Row>
py::array_t<T> rows_of_three(const std::vector<Row>& rows) {
  static_assert(sizeof(Row) == 3 * sizeof(T));
  return py::array_t<T>({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}},
                        reinterpret_cast<const T*>(rows.data()));
}

void bind_shapes(py::module_& m) {
  py::enum_<ShapeKind>(m, "Shape")
      .value("sphere", ShapeKind::sphere)
      .value("box", ShapeKind::box)
      .value("cylinder", ShapeKind::cylinder)
      .value("capsule", ShapeKind::capsule)
      .value("torus", ShapeKind::torus)
      .value("mesh", ShapeKind::mesh)
      .value("basin", ShapeKind::basin);

  py::class_<TriangleMesh, std::shared_ptr<TriangleMesh>>(m, "TriangleMesh", "A closed surface; triangles outwards.")
      .def(py::init([](std::vector<Vec3> points, std::vector<std::array<std::int32_t, 3>> triangles) {
             return std::make_shared<TriangleMesh>(TriangleMesh{std::move(points), std::move(triangles)});
           }),
           py::arg("points"), py::arg("triangles"))
      .def_property_readonly(
          "points", [](const TriangleMesh& mesh) { return rows_of_three<Real>(mesh.points); }, "(n, 3), m: a copy")
      .def_property_readonly(
          "triangles", [](const TriangleMesh& mesh) { return rows_of_three<std::int32_t>(mesh.triangles); },
          "(n, 3), numbers of points: a copy");
  m.def(
      "read_mesh",
      [](const std::string& path, Real scale, const py::object& comm) { return read_mesh(comm_of(comm), path, scale); },
      py::arg("path"), py::arg("scale") = 1.0, py::arg("comm") = py::none(),
      "The closed surface of an STL, OBJ or PLY file, with so many metres for a unit. Collective.");
}

void bind_motions(py::module_& m) {
  py::class_<Oscillation> oscillation(m, "Oscillation", "motion of an obstacle as a sine about its place");
  oscillation.def(py::init<>())
      .def_property("amplitude", in_place(&Oscillation::amplitude), assigned(&Oscillation::amplitude), "m")
      .def_property("rotation", in_place(&Oscillation::rotation), assigned(&Oscillation::rotation),
                    "degrees, about the axis that it is along")
      .def_readwrite("period", &Oscillation::period, "s")
      .def_readwrite("ramp", &Oscillation::ramp, "s, until it is full");
  closed(oscillation);

  py::enum_<PaddleKind>(m, "PaddleKind").value("piston", PaddleKind::piston).value("flap", PaddleKind::flap);
  py::enum_<WaveKind>(m, "WaveKind")
      .value("regular", WaveKind::regular)
      .value("irregular", WaveKind::irregular)
      .value("solitary", WaveKind::solitary);
  py::enum_<WaveSpectrum>(m, "WaveSpectrum")
      .value("jonswap", WaveSpectrum::jonswap)
      .value("pierson_moskowitz", WaveSpectrum::pierson_moskowitz);
  py::class_<WavemakerSettings> maker(m, "WavemakerSettings", "[[wavemaker]]: a paddle across one end of a tank");
  maker.def(py::init<>())
      .def_readwrite("kind", &WavemakerSettings::kind)
      .def_readwrite("wave", &WavemakerSettings::wave)
      .def_readwrite("height", &WavemakerSettings::height, "H, or H_m0 of irregular waves, m")
      .def_readwrite("period", &WavemakerSettings::period, "T, or T_p of irregular waves, s")
      .def_readwrite("depth", &WavemakerSettings::depth, "of the still water before it, m")
      .def_readwrite("gravity", &WavemakerSettings::gravity, "downwards, m/s²: that of the settings")
      .def_property("direction", in_place(&WavemakerSettings::direction), assigned(&WavemakerSettings::direction),
                    "of the waves: along x or y, of length 1")
      .def_readwrite("position", &WavemakerSettings::position, "of its face at rest along that axis, m")
      .def_readwrite("floor", &WavemakerSettings::floor, "flap: of its hinge, m")
      .def_readwrite("ramp", &WavemakerSettings::ramp, "s, until the motion is full")
      .def_readwrite("second_order", &WavemakerSettings::second_order, "piston, regular: Madsen's correction")
      .def_readwrite("spectrum", &WavemakerSettings::spectrum)
      .def_readwrite("peak_enhancement", &WavemakerSettings::peak_enhancement, "gamma of JONSWAP")
      .def_readwrite("components", &WavemakerSettings::components, "of irregular waves")
      .def_readwrite("seed", &WavemakerSettings::seed, "of their phases")
      .def_readwrite("absorb", &WavemakerSettings::absorb, "takes in waves that come back");
  closed(maker);
}

void bind_obstacles(py::module_& m) {
  py::class_<ObstacleSettings> obstacle(m, "ObstacleSettings", "[[obstacle]]: a solid in the water, or a vessel");
  obstacle.def(py::init<>())
      .def_readwrite("shape", &ObstacleSettings::shape)
      .def_property("center", in_place(&ObstacleSettings::center), assigned(&ObstacleSettings::center), "m")
      .def_property("size", in_place(&ObstacleSettings::size), assigned(&ObstacleSettings::size),
                    "box: its edges; basin: those of the space in it; m")
      .def_readwrite("radius", &ObstacleSettings::radius, "m")
      .def_readwrite("tube", &ObstacleSettings::tube, "torus: radius of the tube, m")
      .def_readwrite("height", &ObstacleSettings::height, "cylinder, capsule, round basin; m")
      .def_readwrite("wall", &ObstacleSettings::wall, "basin: thickness, m")
      .def_property("axis", in_place(&ObstacleSettings::axis), assigned(&ObstacleSettings::axis),
                    "cylinder, capsule, torus")
      .def_property("rotate", in_place(&ObstacleSettings::rotate), assigned(&ObstacleSettings::rotate),
                    "degrees about x, then y, then z")
      .def_readwrite("inside", &ObstacleSettings::inside, "a vessel: solid is what is outside")
      .def_property(
          "mesh", [](const ObstacleSettings& one) { return std::const_pointer_cast<TriangleMesh>(one.mesh); },
          [](ObstacleSettings& one, std::shared_ptr<TriangleMesh> mesh) { one.mesh = std::move(mesh); },
          "TriangleMesh, by read_mesh() or of one's own, or None")
      .def_property("velocity", in_place(&ObstacleSettings::velocity), assigned(&ObstacleSettings::velocity), "m/s")
      .def_property("angular_velocity", in_place(&ObstacleSettings::angular_velocity),
                    assigned(&ObstacleSettings::angular_velocity), "rad/s, about the centre")
      .def_property(
          "motion",
          [](const ObstacleSettings& one) {
            std::vector<std::pair<Real, Vec3>> knots;
            for (const ObstacleKnot& knot : one.knots) knots.emplace_back(knot.time, knot.center);
            return knots;
          },
          [](ObstacleSettings& one, const std::vector<std::pair<Real, Vec3>>& knots) {
            one.knots.clear();
            for (const auto& [time, center] : knots) one.knots.push_back({time, center});
          },
          "times and places of the centre, [(s, [x, y, z] in m), ...]; set as a whole")
      .def_readwrite("oscillation", &ObstacleSettings::oscillation, "Oscillation, or None; set as a whole")
      .def_readwrite("wavemaker", &ObstacleSettings::wavemaker, "of a paddle: as paddle_of() says, or None")
      .def_readwrite("restitution", &ObstacleSettings::restitution, "None: that of the walls")
      .def_readwrite("friction", &ObstacleSettings::friction, "Coulomb's coefficient in a bounce");
  closed(obstacle);
  py::bind_vector<std::vector<ObstacleSettings>>(m, "Obstacles");
  m.def("paddle_of", &paddle_of, py::arg("wavemaker"), py::arg("domain"), "A wavemaker's obstacle.");
}

void bind_bodies(py::module_& m) {
  py::class_<Mooring> mooring(m, "Mooring", "mooring of a body: a spring with a damper, or a line, to a fixed point");
  mooring.def(py::init<>())
      .def_property("anchor", in_place(&Mooring::anchor), assigned(&Mooring::anchor), "m")
      .def_readwrite("point", &Mooring::point, "on the body at the start, m; None: its centre of mass; set as a whole")
      .def_readwrite("stiffness", &Mooring::stiffness, "N/m")
      .def_readwrite("damping", &Mooring::damping, "N s/m, along it")
      .def_readwrite("length", &Mooring::length, "without a force, m; None: that of the start")
      .def_readwrite("slack", &Mooring::slack, "a line, which never pushes");
  closed(mooring);

  py::class_<BodySettings, ObstacleSettings> body(m, "BodySettings", "[[body]]: a rigid body that moves freely");
  body.def(py::init<>())
      .def_readwrite("density", &BodySettings::density, "kg/m³; this or the mass")
      .def_readwrite("mass", &BodySettings::mass, "kg")
      .def_property(
          "free", [](const BodySettings& one) { return names_of(one.free); },
          [](BodySettings& one, const std::vector<std::string>& names) { one.free = freedoms_of(names); },
          "what it may do: of \"x\", \"y\", \"z\", \"roll\", \"pitch\", \"yaw\"; set as a whole")
      .def_readwrite("mooring", &BodySettings::mooring, "Mooring, or None; set as a whole");
  closed(body);
  py::bind_vector<std::vector<BodySettings>>(m, "Bodies");
}

}  // namespace

void bind_solids(py::module_& m) {
  bind_shapes(m);
  bind_motions(m);
  bind_obstacles(m);
  bind_bodies(m);
}

}  // namespace trevi::python

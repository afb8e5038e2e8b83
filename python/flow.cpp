// Fountains, inlets and drains of the settings. Names, units and defaults are those of the scene file
// (inputs/README.md).
#include "binding_helpers.hpp"

namespace trevi::python {

namespace {

// Two numbers, set as a whole.
template <class Owner>
void pair_of(py::class_<Owner, PumpSettings>& made, const char* name, Real (Owner::*member)[2], const char* doc) {
  made.def_property(
      name, [member](const Owner& one) { return py::make_tuple((one.*member)[0], (one.*member)[1]); },
      [member](Owner& one, const std::array<Real, 2>& values) {
        (one.*member)[0] = values[0];
        (one.*member)[1] = values[1];
      },
      doc);
}

void bind_music(py::module_& m) {
  py::enum_<MusicKind>(m, "MusicKind")
      .value("score", MusicKind::score)
      .value("midi", MusicKind::midi)
      .value("sound", MusicKind::sound)
      .value("live", MusicKind::live);
  py::enum_<Follow>(m, "Follow").value("pitch", Follow::pitch).value("loudness", Follow::loudness);
  py::enum_<SpeedMapping>(m, "SpeedMapping")
      .value("linear", SpeedMapping::linear)
      .value("energy", SpeedMapping::energy);

  py::class_<MusicSettings> music(m, "MusicSettings", "music of a fountain or an inlet");
  music
      .def(py::init([](const std::string& source) {
             MusicSettings made;
             made.source = source;
             return made;
           }),
           py::arg("source") = "")
      .def_readwrite("source", &MusicSettings::source, "a file, or \"-\" for raw PCM on standard input")
      .def_readwrite("track", &MusicSettings::track, "of a MIDI file, from 1; 0: all")
      .def_readwrite("channel", &MusicSettings::channel, "of a MIDI file, from 1; 0: all but the drums")
      .def_readwrite("rate", &MusicSettings::rate, "of raw PCM, Hz")
      .def_readwrite("speed_range", &MusicSettings::speed_range, "of the lowest and the highest note, m/s")
      .def_readwrite("mapping", &MusicSettings::mapping, "what grows evenly with the note");
  derived(music, "kind", &MusicSettings::kind, "None: by the ending of the source");
  derived(music, "follow", &MusicSettings::follow, "None: loudness of a sound, pitch of a score");
  closed(music);
}

void bind_pumps(py::module_& m) {
  py::class_<PumpSettings> pump(m, "PumpSettings", "what drives a fountain or an inlet");
  pump.def_property("direction", in_place(&PumpSettings::direction), assigned(&PumpSettings::direction),
                    "of the jet, of any length")
      .def_readwrite("speed", &PumpSettings::speed, "m/s; where there is no music")
      .def_readwrite("jitter", &PumpSettings::jitter, "largest random addition, m/s")
      .def_readwrite("start", &PumpSettings::start, "s")
      .def_readwrite("stop", &PumpSettings::stop, "s")
      .def_readwrite("music", &PumpSettings::music, "MusicSettings, or None; set as a whole");

  py::class_<FountainSettings, PumpSettings> fountain(m, "FountainSettings", "[[fountain]]: a pump on the floor");
  fountain.def(py::init<>())
      .def_readwrite("diameter", &FountainSettings::diameter, "of the upright cylinder, m")
      .def_readwrite("height", &FountainSettings::height, "of the cylinder above the floor, m");
  pair_of(fountain, "center", &FountainSettings::center, "(x, y) on the floor, m; set as a whole");
  closed(fountain);
  py::bind_vector<std::vector<FountainSettings>>(m, "Fountains");

  py::enum_<InletShape>(m, "InletShape").value("disc", InletShape::disc).value("rectangle", InletShape::rectangle);
  py::class_<InletSettings, PumpSettings> inlet(m, "InletSettings", "[[inlet]]: an opening that water enters by");
  inlet.def(py::init<>())
      .def_readwrite("shape", &InletSettings::shape)
      .def_property("center", in_place(&InletSettings::center), assigned(&InletSettings::center), "m")
      .def_readwrite("radius", &InletSettings::radius, "disc, m")
      .def_readwrite("flow", &InletSettings::flow, "m³/s, in place of the speed, or None")
      .def_readwrite("recycle", &InletSettings::recycle, "gives back what drains take, and nothing else");
  inlet.def_readwrite("level", &InletSettings::level, "m, held before an opening in a wall, or None")
      .def_property(
          "profile",
          [](const InletSettings& one) { return one.profile ? std::optional(one.profile->text) : std::nullopt; },
          [](InletSettings& one, const std::optional<std::string>& text) {
            one.profile = text ? std::optional(speed_profile(*text)) : std::nullopt;
          },
          "speed along an opening in a wall, an expression of z and t, in place of the speed, or None");
  pair_of(inlet, "size", &InletSettings::size, "rectangle: level, and across that, m; set as a whole");
  closed(inlet);
  py::bind_vector<std::vector<InletSettings>>(m, "Inlets");
}

}  // namespace

void bind_flow(py::module_& m) {
  bind_music(m);
  bind_pumps(m);
  py::enum_<DrainShape>(m, "DrainShape")
      .value("box", DrainShape::box)
      .value("cylinder", DrainShape::cylinder)
      .value("plane", DrainShape::plane);
  py::class_<DrainSettings> drain(m, "DrainSettings", "[[drain]]: a region that water leaves by");
  drain.def(py::init<>())
      .def_readwrite("shape", &DrainSettings::shape)
      .def_property("min", in_place(&DrainSettings::min), assigned(&DrainSettings::min), "box, m")
      .def_property("max", in_place(&DrainSettings::max), assigned(&DrainSettings::max), "box, m")
      .def_property("center", in_place(&DrainSettings::center), assigned(&DrainSettings::center),
                    "cylinder: of its base; plane: a point of it; m")
      .def_property("axis", in_place(&DrainSettings::axis), assigned(&DrainSettings::axis),
                    "plane: its normal, to the side that is drained; of any length")
      .def_readwrite("radius", &DrainSettings::radius, "cylinder, m")
      .def_readwrite("height", &DrainSettings::height, "cylinder, m")
      .def_readwrite("level", &DrainSettings::level, "m, held before the wall behind a box, or None")
      .def_readwrite("flow", &DrainSettings::flow, "m³/s, that leaves by the wall behind a box, or None");
  closed(drain);
  py::bind_vector<std::vector<DrainSettings>>(m, "Drains");
}

}  // namespace trevi::python

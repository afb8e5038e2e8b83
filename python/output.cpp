// The output of the settings: which files a solver writes, and when (postprocess/README.md).
#include <pybind11/stl/filesystem.h>

#include "binding_helpers.hpp"

namespace trevi::python {

void bind_output(py::module_& m) {
  py::enum_<Colour> colour(m, "Colour");
  for (const ColourEntry& entry : colour_list) {
    if (entry.in_scenes) colour.value(entry.name, entry.colour);
  }

  py::class_<Schedule> schedule(m, "Schedule", "Every so many seconds, or every so many steps, which count first.");
  schedule
      .def(py::init([](Real every, std::int64_t every_steps) {
             return Schedule{every, every_steps};
           }),
           py::kw_only(), py::arg("every") = 0.0, py::arg("every_steps") = 0)
      .def_readwrite("every", &Schedule::every, "s")
      .def_readwrite("every_steps", &Schedule::every_steps);
  closed(schedule);

  py::class_<FrameSettings> frames(m, "FrameSettings", "[output.vtu] or [output.vtkhdf]: frames for ParaView");
  frames
      .def(py::init([](const Schedule& when, const std::vector<std::string>& fields) {
             return FrameSettings{when, fields};
           }),
           py::arg("schedule") = Schedule{}, py::arg("fields") = FrameSettings{}.fields)
      .def_readwrite("schedule", &FrameSettings::schedule)
      .def_readwrite("fields", &FrameSettings::fields, "their names; set as a whole");
  closed(frames);

  py::enum_<FrameContent>(m, "FrameContent")
      .value("particles", FrameContent::particles)
      .value("cells", FrameContent::cells);
  py::enum_<FrameFormat>(m, "FrameFormat").value("vtkhdf", FrameFormat::vtkhdf).value("vtu", FrameFormat::vtu);
  py::class_<FrameSetSettings> set(m, "FrameSetSettings", "one of [[output.frames]]: a selection, or means over cells");
  set.def(py::init([](const Schedule& when, FrameContent what) {
            FrameSetSettings one;
            one.schedule = when;
            one.what = what;
            return one;
          }),
          py::arg("schedule") = Schedule{}, py::arg("what") = FrameContent::particles)
      .def_readwrite("name", &FrameSetSettings::name, "its folder is frames_NAME; empty: its number")
      .def_readwrite("what", &FrameSetSettings::what)
      .def_readwrite("format", &FrameSetSettings::format)
      .def_readwrite("schedule", &FrameSetSettings::schedule)
      .def_readwrite("fields", &FrameSetSettings::fields, "their names, or None for the default; set as a whole")
      .def_readwrite("precision", &FrameSetSettings::precision, "of the points")
      .def_readwrite("one_in", &FrameSetSettings::one_in, "a power of two: so many times fewer, by a hash of the id")
      .def_readwrite("surface", &FrameSetSettings::surface, "only what lies near the surface")
      .def_readwrite("box", &FrameSetSettings::box, "of what is written, or None; set as a whole");
  closed(set);

  py::class_<CheckpointSettings> checkpoint(m, "CheckpointSettings", "[output.checkpoint]");
  checkpoint
      .def(py::init([](const Schedule& when, int keep) {
             return CheckpointSettings{when, keep};
           }),
           py::arg("schedule") = Schedule{}, py::arg("keep") = CheckpointSettings{}.keep)
      .def_readwrite("schedule", &CheckpointSettings::schedule, "besides the start and the end")
      .def_readwrite("keep", &CheckpointSettings::keep, "newest that stay");
  closed(checkpoint);

  py::class_<OutputSettings> output(m, "OutputSettings", "[output]; a part that is None is not written");
  output.def(py::init<>())
      .def_property(
          "directory", [](const OutputSettings& one) { return one.directory; },
          [](OutputSettings& one, const std::filesystem::path& path) { one.directory = path.string(); },
          "of the files, a string or a path; empty: none are written")
      .def_readwrite("vtu", &OutputSettings::vtu, "FrameSettings, or None; set as a whole")
      .def_readwrite("vtkhdf", &OutputSettings::vtkhdf, "FrameSettings, or None; set as a whole")
      .def_readwrite("frames", &OutputSettings::frames, "list of FrameSetSettings; set as a whole")
      .def_readwrite("checkpoint", &OutputSettings::checkpoint, "CheckpointSettings, or None; set as a whole")
      .def_readwrite("series", &OutputSettings::series, "Schedule of the rows, or None; set as a whole")
      .def_readwrite("gauges", &OutputSettings::gauges, "Schedule of gauges.csv, or None: as the series");
  closed(output);
}

}  // namespace trevi::python

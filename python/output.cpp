// The output of the settings: which files a solver writes, and when (postprocess/README.md).
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
      .def_readwrite("directory", &OutputSettings::directory, "of the files; empty: none are written")
      .def_readwrite("vtu", &OutputSettings::vtu, "FrameSettings, or None; set as a whole")
      .def_readwrite("vtkhdf", &OutputSettings::vtkhdf, "FrameSettings, or None; set as a whole")
      .def_readwrite("checkpoint", &OutputSettings::checkpoint, "CheckpointSettings, or None; set as a whole")
      .def_readwrite("series", &OutputSettings::series, "Schedule of the rows, or None; set as a whole");
  closed(output);
}

}  // namespace trevi::python

#include "scene/scene_frames.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "fluid/in_two_dimensions.hpp"
#include "io/frames/fields.hpp"
#include "io/frames/frame_sets.hpp"

namespace trevi {

namespace {

bool needs_colour(const std::string& name) {
  const auto fields = frame_fields();
  return std::any_of(fields.begin(), fields.end(), [&](const OutputField* field) {
    return name == field->name && field->needs == FieldNeeds::colour;
  });
}

void check_fields(Section& frames, const std::vector<std::string>& fields, FrameContent what, bool has_colour) {
  const std::vector<std::string> allowed = possible_fields(what);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string& field = fields[i];
    const std::string shown = printable(field), meant = nearest_word(field, allowed);
    frames.check("fields", std::find(allowed.begin(), allowed.end(), field) != allowed.end(),
                 fmt::format("unknown field \"{}\"; {}", shown,
                             meant.empty() ? fmt::format("choose from {}", fmt::join(allowed, ", "))
                                           : fmt::format("did you mean \"{}\"?", meant)));
    frames.check("fields", std::count(fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(i), field) == 0,
                 fmt::format("\"{}\" is named twice; name it once", shown));
    frames.check("fields", has_colour || !needs_colour(field),
                 fmt::format("\"{}\" needs a table [colour]; add one, for example with by = \"speed\"", shown));
  }
}

Schedule read_required_schedule(Section& frames) {
  const Schedule schedule = read_schedule(frames);
  if (frames.present()) {
    frames.check("every", frames.given("every") || frames.given("every_steps"),
                 "missing; give every (seconds) or every_steps");
  }
  return schedule;
}

// Cells have neither points nor ids.
void check_cells(Section& frames, const FrameSetSettings& set) {
  if (set.what != FrameContent::cells) return;
  for (const char* key : {"precision", "one_in", "surface"})
    frames.check(key, !frames.given(key), "is for what = \"particles\"; leave it out");
  frames.check("format", set.format == FrameFormat::vtkhdf, "must be \"vtkhdf\" for cells; leave it out");
}

void read_name(Section& frames, const Scene& scene, FrameSetSettings& set) {
  if (frames.text({"name", "the end of the folder's name, frames_NAME; default its number in the scene"}, set.name)) {
    frames.check("name", is_folder_name(set.name),
                 "must be letters, digits, - and _ only, at most 200, as it names a folder");
  }
  if (!frames.given("name")) set.name = std::to_string(scene.output.frames.size());
  const std::string folder = folder_of(set, scene.output.frames.size());
  for (std::size_t k = 0; k < scene.output.frames.size(); ++k) {
    frames.check(
        "name", folder != folder_of(scene.output.frames[k], k),
        fmt::format("the folder {} is that of another [[output.frames]]; give each a name of its own", folder));
  }
}

void read_box(Section& frames, const Scene& scene, FrameSetSettings& set) {
  Box box;
  const bool low = frames.numbers({"min", "the lower corner of a box [x, y, z] in metres; default all"}, box.min),
             high = frames.numbers({"max", "the upper corner of a box [x, y, z] in metres; default all"}, box.max);
  for (const char* key : {"min", "max"})
    frames.check(key, frames.given("min") == frames.given("max") || frames.given(key),
                 "missing; give both corners of the box, or none");
  if (!low || !high) return;
  set.box = box;
  lay_in_plane(set, scene.fluid);
  const auto grows = [](const Box& one) { return (one.min.array() < one.max.array()).all(); };
  frames.check("max", grows(*set.box), "must be greater than min on every axis");
  const Box common{set.box->min.cwiseMax(scene.domain.min), set.box->max.cwiseMin(scene.domain.max)};
  frames.check("max", grows(common), "the box from min to max has nothing of the domain in it; move it");
}

void read_selection(Section& frames, const Scene& scene, FrameSetSettings& set) {
  frames.choice<Precision>({"precision", "of the points; default double"}, set.precision,
                           {{"double", Precision::double_}, {"single", Precision::single}});
  if (frames.integer(
          {"one_in", "of how many particles one is written, by a hash of the ids: 1, 2, 4, 8, ...; default 1"},
          set.one_in, 1)) {
    frames.check("one_in", thinning_of(set.one_in) >= 0,
                 fmt::format("must be a power of two up to {}: 1, 2, 4, 8, ...", largest_one_in));
  }
  frames.flag({"surface", "whether only the particles near the surface are written; default false"}, set.surface);
  read_box(frames, scene, set);
}

void read_frame_set(Section& frames, Scene& scene, bool has_colour) {
  FrameSetSettings set;
  frames.choice<FrameContent>({"what", "what is written; default particles"}, set.what,
                              {{"particles", FrameContent::particles}, {"cells", FrameContent::cells}});
  read_name(frames, scene, set);
  frames.choice<FrameFormat>({"format", "of the files; default vtkhdf"}, set.format,
                             {{"vtkhdf", FrameFormat::vtkhdf}, {"vtu", FrameFormat::vtu}});
  set.schedule = read_required_schedule(frames);
  const std::string meaning =
      fmt::format("the fields to write: {}; of cells {}", fmt::join(possible_fields(FrameContent::particles), ", "),
                  fmt::join(possible_fields(FrameContent::cells), ", "));
  std::vector<std::string> fields;
  if (frames.texts({"fields", meaning.c_str()}, fields)) {
    if (frames.fine("what")) check_fields(frames, fields, set.what, has_colour);
    set.fields = std::move(fields);
  }
  set.fields = fields_of(set);
  read_selection(frames, scene, set);
  check_cells(frames, set);
  frames.reject_unknown();
  scene.output.frames.push_back(std::move(set));
}

}  // namespace

Schedule read_schedule(Section& section) {
  Schedule schedule;
  section.number({"every", "the time between outputs in seconds"}, schedule.every, above(0));
  section.integer({"every_steps", "the number of steps between outputs; it beats every"}, schedule.every_steps, 1);
  return schedule;
}

std::optional<FrameSettings> read_frames(Section frames, bool has_colour) {
  FrameSettings settings;
  settings.schedule = read_schedule(frames);
  const std::string meaning =
      fmt::format("the fields to write: {}", fmt::join(possible_fields(FrameContent::particles), ", "));
  if (frames.texts({"fields", meaning.c_str()}, settings.fields)) {
    check_fields(frames, settings.fields, FrameContent::particles, has_colour);
  }
  if (frames.present()) {
    frames.check("every", frames.given("every") || frames.given("every_steps"),
                 "missing; give every (seconds) or every_steps");
  }
  frames.reject_unknown();
  return frames.present() ? std::optional(settings) : std::nullopt;
}

void read_frame_sets(Section& output, Scene& scene, bool has_colour) {
  for (Section& frames : output.children("frames")) read_frame_set(frames, scene, has_colour);
}

}  // namespace trevi

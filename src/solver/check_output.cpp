// Checks of the settings of the output (check_flow.hpp).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "io/frames/frame_sets.hpp"
#include "solver/check_flow.hpp"
#include "solver/demand.hpp"

namespace trevi {

namespace {

void check_schedule(const Schedule& schedule, const std::string& name) {
  demand(is_amount(schedule.every) && schedule.every_steps >= 0,
         fmt::format("output.{}: every and every_steps must not be negative", name));
}

void check_fields(const Settings& all, const std::vector<std::string>& fields, const std::vector<std::string>& allowed,
                  const std::string& name) {
  for (auto field = fields.begin(); field != fields.end(); ++field) {
    demand(std::find(allowed.begin(), allowed.end(), *field) != allowed.end(),
           fmt::format("output.{}.fields: \"{}\" is none of {}", name, *field, fmt::join(allowed, ", ")));
    demand(std::find(fields.begin(), field, *field) == field,
           fmt::format("output.{}.fields: \"{}\" is named twice", name, *field));
    demand(*field != "rgb" || all.colour, fmt::format("output.{}.fields: \"rgb\" needs a colour", name));
  }
}

void check_frames(const Settings& all, const FrameSettings& frames, const std::string& name) {
  check_schedule(frames.schedule, name);
  check_fields(all, frames.fields, possible_fields(FrameContent::particles), name);
}

void check_box(const Settings& all, const Box& box, const std::string& name) {
  const Box common{box.min.cwiseMax(all.domain.min), box.max.cwiseMin(all.domain.max)};
  demand((box.min.array() < box.max.array()).all() && (common.min.array() < common.max.array()).all(),
         fmt::format("output.{}.box must have an extent, and something of the domain in it", name));
}

void check_frame_set(const Settings& all, std::size_t k) {
  const std::vector<FrameSetSettings>& sets = all.output.frames;
  const FrameSetSettings& set = sets[k];
  const std::string name = fmt::format("frames[{}]", k);
  check_schedule(set.schedule, name);
  check_fields(all, fields_of(set), possible_fields(set.what), name);
  demand(set.name.empty() || is_folder_name(set.name),
         fmt::format("output.{}.name must be letters, digits, - and _ only, at most 200", name));
  for (std::size_t other = 0; other < k; ++other)
    demand(folder_of(set, k) != folder_of(sets[other], other),
           fmt::format("output.{}.name is that of another one", name));
  demand(thinning_of(set.one_in) >= 0, fmt::format("output.{}.one_in must be a power of two", name));
  const bool plain = set.format == FrameFormat::vtkhdf && set.one_in == 1 && !set.surface;
  demand(set.what == FrameContent::particles || plain,
         fmt::format("output.{}: cells have the format vtkhdf, neither one_in nor surface", name));
  if (set.box) check_box(all, *set.box, name);
}

}  // namespace

void check_output(const Settings& all) {
  const OutputSettings& output = all.output;
  if (output.vtu) check_frames(all, *output.vtu, "vtu");
  if (output.vtkhdf) check_frames(all, *output.vtkhdf, "vtkhdf");
  for (std::size_t k = 0; k < output.frames.size(); ++k) check_frame_set(all, k);
  if (output.series) check_schedule(*output.series, "series");
  if (!output.checkpoint) return;
  check_schedule(output.checkpoint->schedule, "checkpoint");
  demand(output.checkpoint->keep >= 1, "output.checkpoint.keep must be at least 1");
}

}  // namespace trevi

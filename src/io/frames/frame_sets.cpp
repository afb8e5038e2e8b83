#include "io/frames/frame_sets.hpp"

#include <algorithm>
#include <bit>

#include "io/frames/cell_frames.hpp"
#include "io/frames/fields.hpp"
#include "io/run_directory/files.hpp"

namespace trevi {

std::string folder_of(const FrameSetSettings& set, std::size_t k) {
  return frame_set_prefix + (set.name.empty() ? std::to_string(k) : set.name);
}

std::vector<std::string> possible_fields(FrameContent what) {
  if (what == FrameContent::cells) return {cell_field_names.begin(), cell_field_names.end()};
  std::vector<std::string> names;
  for (const OutputField* field : frame_fields()) names.emplace_back(field->name);
  return names;
}

std::vector<std::string> fields_of(const FrameSetSettings& set) {
  if (set.fields) return *set.fields;
  if (set.what == FrameContent::cells) return {"fraction", "velocity"};
  return FrameSettings{}.fields;
}

CoarseCells coarse_cells(const Settings& settings, const FrameSetSettings& set) {
  const CellGrid grid(settings.domain.min, settings.domain.max, settings.fluid.kernel_radius, 0, settings.periodic);
  return {settings.domain, grid, set.box};
}

bool is_folder_name(const std::string& name) {
  constexpr std::size_t longest = 200;  // of the 255 that file systems allow, with prefix and suffix
  return !name.empty() && name.size() <= longest && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

int thinning_of(std::int64_t one_in) {
  const bool good = one_in >= 1 && one_in <= largest_one_in && std::has_single_bit(static_cast<std::uint64_t>(one_in));
  return good ? std::countr_zero(static_cast<std::uint64_t>(one_in)) : -1;
}

}  // namespace trevi

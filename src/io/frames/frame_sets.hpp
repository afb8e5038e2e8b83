// What the settings of [[output.frames]] leave to their reader: names of folders, and fields. Not collective.
#pragma once

#include <string>
#include <vector>

#include "io/frames/cell_means.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// The name of the folder of entry k within that of the run.
std::string folder_of(const FrameSetSettings& set, std::size_t k);

/// The fields that its frames can have.
std::vector<std::string> possible_fields(FrameContent what);

/// The fields that they have.
std::vector<std::string> fields_of(const FrameSetSettings& set);

/// The cells whose means are in its frames.
CoarseCells coarse_cells(const Settings& settings, const FrameSetSettings& set);

/// Whether a name can be that of a folder: letters, digits, "-" and "_".
bool is_folder_name(const std::string& name);

inline constexpr std::int64_t largest_one_in = std::int64_t{1} << 30;

/// k for 2^k, or -1 for anything that is not a power of two up to largest_one_in.
int thinning_of(std::int64_t one_in);

}  // namespace trevi

// A scene's TOML document with the overrides of the command line applied, later ones over earlier ones. Each value
// remembers where it came from: the file, or "--set table.key=value" (toml::source_region::path).
#pragma once

#include <toml++/toml.h>

#include <string>
#include <vector>

#include "scene/scene_reader.hpp"

namespace trevi {

/// Throws InputError if the file is not TOML. Invalid overrides go to `findings`, and the others are still applied.
toml::table read_document(const std::string& path, const std::string& text, const std::vector<std::string>& overrides,
                          Findings& findings);

}  // namespace trevi

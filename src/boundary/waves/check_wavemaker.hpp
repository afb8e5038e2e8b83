// What a wavemaker cannot do, told alike to programs and scenes. Not collective.
#pragma once

#include <optional>
#include <string>

#include "trevi/box.hpp"
#include "trevi/wavemaker.hpp"

namespace trevi {

/// A member that is wrong, by its name in scenes, and why, with the remedy.
struct WrongMember {
  const char* key;
  std::string why;
};

/// The first that is wrong, if any. `domain`: the box of the water.
std::optional<WrongMember> what_is_wrong(const WavemakerSettings& wavemaker, const Box& domain);

}  // namespace trevi

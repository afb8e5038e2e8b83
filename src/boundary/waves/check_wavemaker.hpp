// What a wavemaker cannot do, reported alike to programs and scenes. Not collective.
#pragma once

#include <optional>
#include <string>

#include "trevi/box.hpp"
#include "trevi/wavemaker.hpp"

namespace trevi {

/// An invalid member, by its name in scenes, and the reason, with the remedy.
struct WrongMember {
  const char* key;
  std::string why;
};

/// The first invalid member, if any. `domain`: the box of the water.
std::optional<WrongMember> what_is_wrong(const WavemakerSettings& wavemaker, const Box& domain);

}  // namespace trevi

// What kind of music a source is, by its ending. Not collective.
#pragma once

#include <optional>
#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// Nothing when the ending is unknown; "-" is live sound.
std::optional<MusicKind> kind_of_music(std::string source);

/// ".txt .mid ...", for messages.
std::string endings_of_music();

/// Sets the defaults that follow from the source; a kind that is unknown stays without a value.
void resolve(MusicSettings& music);

}  // namespace trevi

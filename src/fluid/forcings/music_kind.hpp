// The kind of music of a source, by its file name extension. Not collective.
#pragma once

#include <optional>
#include <string>

#include "trevi/settings.hpp"

namespace trevi {

/// Nothing if the extension is unknown; "-" is live sound.
std::optional<MusicKind> kind_of_music(std::string source);

/// ".txt .mid ...", for messages.
std::string endings_of_music();

/// Sets the defaults that follow from the source; an unknown kind is left without a value.
void resolve(MusicSettings& music);

}  // namespace trevi

// Stands in for music_midi.cpp in a build without libsmf.
#include "music/music.hpp"
#include "trevi/error.hpp"

namespace trevi {

Melody read_midi(const std::string& name, const std::string&, const MusicSettings&) {
  throw InputError("[[fountain]] music: " + name +
                   ": this build reads no MIDI files; configure with -DTREVI_WITH_MIDI=ON (it needs libsmf), or give a "
                   "text score (.txt)");
}

}  // namespace trevi

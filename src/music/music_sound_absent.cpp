// Replaces music_sound.cpp in a build without libsndfile.
#include "music/sound.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

[[noreturn]] void refuse(const std::string& name) {
  throw InputError(name +
                   ": this build reads no sound files; configure with -DTREVI_WITH_SOUND=ON (it needs libsndfile), or "
                   "give a text score (.txt)");
}

}  // namespace

Melody read_sound(const std::string& name, const std::string&, Follow) { refuse(name); }
Recording read_recording(const std::string& name, const std::string&) { refuse(name); }

}  // namespace trevi

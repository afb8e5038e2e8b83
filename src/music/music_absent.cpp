// Replaces the music module in a build without it.
#include "music/music.hpp"
#include "music/sound.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

[[noreturn]] void refuse(const std::string& name) {
  throw InputError(name + ": this build plays no music; configure with -DTREVI_WITH_MUSIC=ON, or leave music out");
}

}  // namespace

Melody read_melody(const std::string&, const MusicSettings& settings) { refuse(settings.source); }
Recording read_recording(const std::string& name, const std::string&) { refuse(name); }

std::unique_ptr<Pump> make_music_pump(MPI_Comm, const MusicSettings& settings, std::shared_ptr<LiveSound>&) {
  refuse(settings.source);
}

}  // namespace trevi

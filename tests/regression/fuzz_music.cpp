// libFuzzer target: music files. The first byte says which kind the rest is: a score, MIDI, or a sound file. Whatever
// it is, the answer is a melody or an InputError; a melody plays one tone at a time, forward in time. Built with
// TREVI_FUZZ.
#include <array>
#include <cstdlib>
#include <string>

#include "music/music.hpp"
#include "trevi/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr std::array kinds = {trevi::MusicKind::score, trevi::MusicKind::midi, trevi::MusicKind::sound};
  trevi::MusicSettings settings;
  settings.source = "fuzz";
  settings.kind = kinds[data[0] % kinds.size()];
  settings.follow = data[0] & 0x80 ? trevi::Follow::pitch : trevi::Follow::loudness;
  const std::string bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    const trevi::Melody melody = trevi::read_melody(bytes, settings);
    trevi::Real time = 0;
    for (const trevi::Tone& tone : melody.tones) {
      if (!(tone.start >= time && tone.stop > tone.start)) std::abort();
      time = tone.stop;
    }
  } catch (const trevi::InputError&) {
  }
  return 0;
}

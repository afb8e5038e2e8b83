#include "music/music.hpp"

#include <unistd.h>

#include <algorithm>
#include <set>

#include "music/sound.hpp"
#include "trevi/error.hpp"

namespace trevi {

const Tone* Melody::at(Real time) const {
  const auto after =
      std::upper_bound(tones.begin(), tones.end(), time, [](Real t, const Tone& tone) { return t < tone.start; });
  if (after == tones.begin() || time >= std::prev(after)->stop) return nullptr;
  return &*std::prev(after);
}

// A sweep over all starts and ends; between two of them the tone is the highest of the notes that sound.
Melody melody_of_notes(std::vector<Tone> notes) {
  Melody melody;
  std::erase_if(notes, [](const Tone& note) { return note.stop <= note.start; });
  if (notes.empty()) return melody;
  struct Change {
    Real time, height;
    bool begins;
  };
  std::vector<Change> changes;
  melody.lowest = melody.highest = notes.front().height;
  for (const Tone& note : notes) {
    changes.push_back({note.start, note.height, true});
    changes.push_back({note.stop, note.height, false});
    melody.lowest = std::min(melody.lowest, note.height);
    melody.highest = std::max(melody.highest, note.height);
  }
  std::stable_sort(changes.begin(), changes.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  std::multiset<Real> sounding;
  Real since = 0;
  for (const Change& change : changes) {
    if (!sounding.empty() && change.time > since) melody.tones.push_back({since, change.time, *sounding.rbegin()});
    since = change.time;
    if (change.begins) sounding.insert(change.height);
    // The start of a note precedes its end in the list, whatever else happens at these times.
    if (!change.begins) sounding.erase(sounding.find(change.height));
  }
  return melody;
}

Melody read_melody(const std::string& bytes, const MusicSettings& settings) {
  switch (settings.kind) {
    case MusicKind::score:
      return read_score(settings.source, bytes);
    case MusicKind::midi:
      return read_midi(settings.source, bytes, settings);
    case MusicKind::sound:
      return read_sound(settings.source, bytes, settings.follow);
    case MusicKind::live:
      break;
  }
  throw InputError(settings.source + ": live sound has no melody to be read beforehand");
}

Real SpeedScale::speed(Real x) const {
  const auto [low, high] = range_;
  const Real fraction = std::clamp(x, 0.0, 1.0);
  if (mapping_ == SpeedMapping::linear) return low + (high - low) * fraction;
  return std::sqrt(low * low + (high * high - low * low) * fraction);
}

std::optional<FountainState> MelodyPump::at(Real time) const {
  const Tone* tone = melody_.at(time);
  if (tone == nullptr) return std::nullopt;
  return FountainState{melody_.follow == Follow::pitch ? tone->height : NAN, speed_of(*tone)};
}

Real MelodyPump::speed_of(const Tone& tone) const {
  const Real range = melody_.highest - melody_.lowest;
  return scale_.speed(range > 0 ? (tone.height - melody_.lowest) / range : 1);
}

std::optional<Real> MelodyPump::fastest(const TimeSpan& times) const {
  std::optional<Real> speed;
  auto tone = std::lower_bound(melody_.tones.begin(), melody_.tones.end(), times.begin,
                               [](const Tone& past, Real t) { return past.stop <= t; });
  for (; tone != melody_.tones.end() && tone->start < times.end; ++tone)
    speed = std::max(speed.value_or(0), speed_of(*tone));
  return speed;
}

std::unique_ptr<Pump> make_music_pump(MPI_Comm comm, const MusicSettings& settings, std::shared_ptr<LiveSound>& live) {
  const Event event("Music");
  const ScopedEvent timed(event);
  const SpeedScale scale(settings);
  if (settings.kind != MusicKind::live)
    return std::make_unique<MelodyPump>(read_melody(read_file_everywhere(comm, settings.source), settings), scale);
  if (!live) live = std::make_shared<LiveSound>(comm, STDIN_FILENO, settings.rate);
  return std::make_unique<LivePump>(live, settings.follow, scale);
}

}  // namespace trevi

// The melody of a MIDI file: the notes of the track and channel that were chosen.
#include <map>
#include <set>

#include "music/midi_file.hpp"
#include "music/music.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr int drum_channel = 10;

/// Tracks and channels that have notes, for a user who chose one that has none.
using Voices = std::set<std::pair<int, int>>;  ///< track, channel

std::string list_of(const Voices& voices) {
  if (voices.empty()) return "the file has no notes at all";
  std::string text = "notes are in";
  for (const auto& [track, channel] : voices) {
    text +=
        (text.back() == 'n' ? " track " : ", track ") + std::to_string(track) + " channel " + std::to_string(channel);
  }
  return text;
}

/// Pairs note-ons with note-offs. If a note is struck again before its end, the one that began first ends first.
class NoteCollector {
 public:
  explicit NoteCollector(const MusicSettings& settings) : settings_(settings) {}

  void take(const MidiEvent& event) {
    if (event.begins) voices_.insert({event.track, event.channel});
    if (!wanted(event)) return;
    std::vector<Real>& starts = sounding_[{event.track, event.channel, event.note}];
    if (event.begins) {
      starts.push_back(event.time);
    } else if (!starts.empty()) {
      notes_.push_back({starts.front(), event.time, static_cast<Real>(event.note)});
      starts.erase(starts.begin());
    }
  }

  /// Notes without an end last to the end of the piece.
  std::vector<Tone> notes(Real end) && {
    for (const auto& [key, starts] : sounding_) {
      for (const Real start : starts) notes_.push_back({start, end, static_cast<Real>(std::get<2>(key))});
    }
    return std::move(notes_);
  }
  const Voices& voices() const { return voices_; }
  /// Whether all notes that were chosen begin where the piece ends, so that there is nothing to hear.
  bool only_unended() const { return notes_.empty() && !sounding_.empty(); }

 private:
  bool wanted(const MidiEvent& event) const {
    if (settings_.track != 0 && event.track != settings_.track) return false;
    return settings_.channel != 0 ? event.channel == settings_.channel : event.channel != drum_channel;
  }

  const MusicSettings& settings_;
  std::map<std::tuple<int, int, int>, std::vector<Real>> sounding_;  // track, channel, note: starts
  std::vector<Tone> notes_;
  Voices voices_;
};

}  // namespace

Melody read_midi(const std::string& name, const std::string& bytes, const MusicSettings& settings) {
  const MidiFile file = read_midi_file(name, bytes);
  NoteCollector collector(settings);
  for (const MidiEvent& event : file.events) collector.take(event);
  const std::string where = list_of(collector.voices());
  const bool unended = collector.only_unended();
  Melody melody = melody_of_notes(std::move(collector).notes(file.length));
  if (melody.tones.empty() && unended) {
    throw InputError(name +
                     ": its notes begin at the end of the piece and never end (no note-off), so that nothing "
                     "sounds; save it again from the program that made it");
  }
  if (melody.tones.empty()) {
    std::string chosen = settings.track != 0 ? " in track " + std::to_string(settings.track) : "";
    chosen += settings.channel != 0 ? " on channel " + std::to_string(settings.channel) : " (drums, channel 10, apart)";
    throw InputError(name + ": no note" + chosen + "; " + where + "; change track or channel of the [[fountain]]");
  }
  return melody;
}

}  // namespace trevi

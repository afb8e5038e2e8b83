// Standard MIDI Files, read by libsmf, which also turns ticks into seconds by the file's tempo map.
// First: smf.h includes it as C, where its C++ parts do not compile.
#include <glib.h>
//
#include <smf.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "music/midi_notes.hpp"
#include "music/music.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr int drum_channel = 10;

/// What glib would print belongs into our own message, or nowhere.
class GlibMessages {
 public:
  GlibMessages() : before_(g_log_set_default_handler(&keep, this)) {}
  ~GlibMessages() { g_log_set_default_handler(before_, nullptr); }
  GlibMessages(const GlibMessages&) = delete;
  GlibMessages& operator=(const GlibMessages&) = delete;
  const std::string& last() const { return last_; }

 private:
  static void keep(const gchar*, GLogLevelFlags, const gchar* message, gpointer self) {
    if (message != nullptr) static_cast<GlibMessages*>(self)->last_ = message;
  }

  std::string last_;
  GLogFunc before_;
};

struct SmfDelete {
  void operator()(smf_t* smf) const { smf_delete(smf); }
};
using Song = std::unique_ptr<smf_t, SmfDelete>;

Song load(const std::string& name, const std::string& bytes) {
  const MidiNotes notes = midi_notes(name, bytes);
  const GlibMessages messages;
  if (notes.bytes.size() > std::numeric_limits<int>::max())
    throw InputError(name + ": more than 2 GB of MIDI; is it one?");
  Song song(smf_load_from_memory(notes.bytes.data(), static_cast<int>(notes.bytes.size())));
  if (!song || song->number_of_tracks != notes.tracks) {
    throw InputError(name + ": libsmf cannot read it (" +
                     (messages.last().empty() ? "no reason given" : messages.last()) + "); export the MIDI file again");
  }
  return song;
}

/// Where notes are, for a user who chose a track or channel that has none.
using Places = std::set<std::pair<int, int>>;  ///< track, channel

std::string list_of(const Places& places) {
  if (places.empty()) return "the file has no notes at all";
  std::string text = "notes are in";
  for (const auto& [track, channel] : places) {
    text +=
        (text.back() == 'n' ? " track " : ", track ") + std::to_string(track) + " channel " + std::to_string(channel);
  }
  return text;
}

/// Pairs note-ons with note-offs. The note that began first ends first, where one is struck again before its end.
class NoteCollector {
 public:
  explicit NoteCollector(const MusicSettings& settings) : settings_(settings) {}

  void take(const smf_event_t& event) {
    last_time_ = std::max(last_time_, event.time_seconds);
    if (event.midi_buffer_length < 3) return;
    const int status = event.midi_buffer[0] & 0xf0, channel = (event.midi_buffer[0] & 0x0f) + 1;
    if (status != 0x80 && status != 0x90) return;
    const bool begins = status == 0x90 && event.midi_buffer[2] > 0;
    if (begins) places_.insert({event.track_number, channel});
    if (!wanted(event.track_number, channel)) return;
    std::vector<Real>& starts = sounding_[{event.track_number, channel, event.midi_buffer[1]}];
    if (begins) {
      starts.push_back(event.time_seconds);
    } else if (!starts.empty()) {
      notes_.push_back({starts.front(), event.time_seconds, static_cast<Real>(event.midi_buffer[1])});
      starts.erase(starts.begin());
    }
  }

  /// Notes without an end last to the end of the piece.
  std::vector<Tone> notes() && {
    for (const auto& [key, starts] : sounding_) {
      for (const Real start : starts) notes_.push_back({start, last_time_, static_cast<Real>(std::get<2>(key))});
    }
    return std::move(notes_);
  }
  const Places& places() const { return places_; }

 private:
  bool wanted(int track, int channel) const {
    if (settings_.track != 0 && track != settings_.track) return false;
    return settings_.channel != 0 ? channel == settings_.channel : channel != drum_channel;
  }

  const MusicSettings& settings_;
  std::map<std::tuple<int, int, int>, std::vector<Real>> sounding_;  // track, channel, note: starts
  std::vector<Tone> notes_;
  Places places_;
  Real last_time_ = 0;
};

}  // namespace

Melody read_midi(const std::string& name, const std::string& bytes, const MusicSettings& settings) {
  const Song song = load(name, bytes);
  NoteCollector collector(settings);
  while (const smf_event_t* event = smf_get_next_event(song.get())) collector.take(*event);
  const std::string where = list_of(collector.places());
  Melody melody = melody_of_notes(std::move(collector).notes());
  if (melody.tones.empty()) {
    std::string chosen = settings.track != 0 ? " in track " + std::to_string(settings.track) : "";
    chosen += settings.channel != 0 ? " on channel " + std::to_string(settings.channel) : " (drums, channel 10, apart)";
    throw InputError(name + ": no note" + chosen + "; " + where + "; change track or channel of the [[fountain]]");
  }
  return melody;
}

}  // namespace trevi

// Music as the speed of a fountain's pump: a score, a MIDI file or a sound file becomes a Melody, a Melody a Pump.
// Invariant: a Melody plays one tone at a time (of notes that overlap the highest sounds), and where none sounds the
// pump is off; a higher tone never gives a lower speed. Times are simulated times: the piece begins at time 0. The same
// bytes give the same Melody on all ranks. Collective: make_music_pump() only, which reads the file on rank 0. A build
// without this module has music_absent.cpp in its place.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fluid/forcings/fountain.hpp"
#include "trevi/forcing.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// An interval of time, including its start but not its stop, with one height: a MIDI number (60 is middle C, 69 the A
/// of 440 Hz), or a loudness, 1 for the loudest of the piece.
struct Tone {
  Real start = 0, stop = 0;  ///< s
  Real height = 0;
};

/// What one fountain plays.
struct Melody {
  Follow follow = Follow::pitch;
  std::vector<Tone> tones;       ///< in order of time, never two at a time
  Real lowest = 0, highest = 1;  ///< what the ends of speed_range represent

  /// The tone that sounds at a time, or null.
  const Tone* at(Real time) const;
};

/// The melody of notes in any order: the highest of those that sound together, over the range of all of them.
Melody melody_of_notes(std::vector<Tone> notes);

/// MIDI number of a note name: a letter, # or b, an octave ("C4" is 60, "Bb3" is 58); nothing if it is not a note name.
std::optional<Real> note_number(std::string_view name);

/// A text score: lines "time pitch length", in seconds, the pitch a note name or a MIDI number from 0 to 127; # begins
/// a comment. `name` is for messages. InputError lists the bad lines as "name:line: ...".
Melody read_score(const std::string& name, const std::string& text);

/// A Standard MIDI File, format 0 or 1, according to its tempo map. `track` and `channel` as in MusicSettings; the
/// notes of other tracks and channels do not count for the range. InputError names the byte where the file is damaged.
Melody read_midi(const std::string& name, const std::string& bytes, const MusicSettings& settings);

/// A sound file, with all channels combined, by loudness or by pitch (sound.hpp). InputError for an empty or silent
/// one.
Melody read_sound(const std::string& name, const std::string& bytes, Follow follow);

/// The melody in the bytes of settings.source, a file, according to its kind.
Melody read_melody(const std::string& bytes, const MusicSettings& settings);

/// Maps x in [0, 1], low to high, to a speed. Either the speed is linear in x, or its square, so that equal steps of x
/// are equal steps of energy and of the height v²/2g of a jet.
class SpeedScale {
 public:
  explicit SpeedScale(const MusicSettings& settings) : range_(settings.speed_range), mapping_(settings.mapping) {}
  Real speed(Real x) const;

 private:
  std::pair<Real, Real> range_;
  SpeedMapping mapping_;
};

/// Plays a melody. A piece of one note only plays it at the high end of the range.
class MelodyPump : public Pump {
 public:
  MelodyPump(Melody melody, const SpeedScale& scale) : melody_(std::move(melody)), scale_(scale) {}
  std::optional<FountainState> at(Real time) const override;
  std::optional<Real> fastest(const TimeSpan& times) const override;

 private:
  Real speed_of(const Tone& tone) const;

  Melody melody_;
  SpeedScale scale_;
};

class LiveSound;

/// The pump of a fountain with music. Fountains that follow standard input share `live`, which the first of them makes.
/// Collective. InputError for a file that cannot be used, or of a kind that is not built in.
std::unique_ptr<Pump> make_music_pump(MPI_Comm comm, const MusicSettings& settings, std::shared_ptr<LiveSound>& live);

}  // namespace trevi

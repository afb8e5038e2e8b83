// The notes of a Standard MIDI File, format 0 or 1, at their times in seconds according to the file's tempo map. The
// file is checked to its last event, and an error names the byte. Invariant: events of a track are in order of time.
// Not collective. Format: Standard MIDI Files 1.0 (MIDI Manufacturers Association, RP-001).
#pragma once

#include <string>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

/// The beginning or the end of a note.
struct MidiEvent {
  std::int64_t tick = 0;
  int track = 0, channel = 0;  ///< from 1
  int note = 0;
  bool begins = false;
  Real time = 0;  ///< s
};

struct MidiFile {
  std::vector<MidiEvent> events;  ///< track by track
  Real length = 0;                ///< s, to the end of the longest track
};

/// InputError "name: byte 123: ..." with a remedy.
MidiFile read_midi_file(const std::string& name, const std::string& bytes);

}  // namespace trevi

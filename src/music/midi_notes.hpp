// A Standard MIDI File, format 0 or 1, checked to its last event and cut down to its notes and tempi.
// libsmf gets to see only this: it loses the rest of a track after a text of more than 127 bytes, skips damaged tracks
// without an error, and ends the program on some; and only a reader that counts can tell a user which byte is wrong.
// Not collective.
#pragma once

#include <string>

namespace trevi {

struct MidiNotes {
  int tracks = 0;
  std::string bytes;  ///< a MIDI file of note-ons, note-offs and tempi, each with its own status byte
};

/// InputError "name: byte 123: ..." with a remedy.
MidiNotes midi_notes(const std::string& name, const std::string& bytes);

}  // namespace trevi

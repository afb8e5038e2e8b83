#!/usr/bin/python3
"""Writes the music of the example scenes: the first eight bars of Beethoven's Ode to Joy (1824, public domain).

Three files of the same melody, beside each other:
  ode_to_joy.txt   a text score: time, pitch, length (seconds)
  ode_to_joy.mid   a Standard MIDI File, format 1: track 1 the tempo, track 2 the melody (channel 1), track 3 a bass
                   (channel 2). The last bar is slower, so that whoever reads it must follow the tempo map
  ode_to_joy.wav   8 kHz, 16 bits, mono: the melody alone, the higher the louder, so that loudness and pitch both rise
"""

import argparse
import struct
import sys
import wave
from collections import namedtuple
from pathlib import Path

import numpy as np

# Pitch and length in quarter notes.
MELODY = [
    "E4 1, E4 1, F4 1, G4 1", "G4 1, F4 1, E4 1, D4 1", "C4 1, C4 1, D4 1, E4 1", "E4 1.5, D4 .5, D4 2",
    "E4 1, E4 1, F4 1, G4 1", "G4 1, F4 1, E4 1, D4 1", "C4 1, C4 1, D4 1, E4 1", "D4 1.5, C4 .5, C4 2",
]
BASS = ["C3 2, C3 2", "G2 2, G2 2", "C3 2, C3 2", "G2 2, G2 2", "C3 2, C3 2", "G2 2, G2 2", "C3 2, C3 2", "G2 2, C3 2"]
BAR = 4  # quarter notes
TICKS = 480  # per quarter note
GAP = 0.12  # quarter notes of silence at the end of each note, so that equal notes stay apart
TEMPI = [(0, 500000), (7 * BAR, 600000)]  # from this quarter note on, microseconds per quarter note
RATE = 8000  # Hz
QUIETEST, LOUDEST = 0.2, 0.7  # peak of the lowest and highest note, of full scale
RAMP = 0.01  # seconds to full loudness and back, against clicks

Note = namedtuple("Note", "start length pitch")  # in quarter notes; MIDI number


def midi_number(name):
    letter, accidental, octave = name[0], name[1:-1], int(name[-1])
    return 12 * (octave + 1) + "C D EF G A B".index(letter) + {"": 0, "#": 1, "b": -1}[accidental]


def notes_of(bars):
    notes, time = [], 0.0
    for word in ", ".join(bars).split(", "):
        name, length = word.split()
        notes.append(Note(time, float(length) - GAP, midi_number(name)))
        time += float(length)
    return notes


def seconds(quarter):
    """Time of a quarter note by the tempo map."""
    time = 0.0
    for (start, tempo), (end, _) in zip(TEMPI, TEMPI[1:] + [(float("inf"), 0)]):
        time += max(0.0, min(quarter, end) - start) * tempo * 1e-6
    return time


def in_seconds(note):
    start = seconds(note.start)
    return start, seconds(note.start + note.length) - start


def write_score(path, notes):
    names = "C C# D D# E F F# G G# A A# B".split()
    lines = ["# Ode to Joy (Beethoven, 1824), first eight bars; by postprocess/make_music.py", "# time pitch length"]
    for note in notes:
        start, length = in_seconds(note)
        lines.append(f"{start:.6g} {names[note.pitch % 12]}{note.pitch // 12 - 1} {length:.6g}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def variable_length(value):
    digits = [value & 0x7F]
    while value := value >> 7:
        digits.append(value & 0x7F | 0x80)
    return bytes(reversed(digits))


def track_chunk(events):
    """events: (tick, bytes) in any order; at one tick they stay in order, an end before a start."""
    body, last = b"", 0
    for tick, message in sorted(events, key=lambda event: event[0]):
        body += variable_length(tick - last) + message
        last = tick
    body += b"\x00\xff\x2f\x00"
    return b"MTrk" + struct.pack(">I", len(body)) + body


def tick(quarter):
    return round(quarter * TICKS)


def voice_track(name, notes, channel):
    text = name.encode()
    events = [(0, b"\xff\x03" + variable_length(len(text)) + text)]
    for note in notes:
        events.append((tick(note.start), bytes([0x90 | channel - 1, note.pitch, 80])))
        events.append((tick(note.start + note.length), bytes([0x80 | channel - 1, note.pitch, 64])))
    return track_chunk(events)


def write_midi(path, melody, bass):
    tempo = track_chunk([(tick(at), b"\xff\x51\x03" + value.to_bytes(3, "big")) for at, value in TEMPI])
    header = b"MThd" + struct.pack(">IHHH", 6, 1, 3, TICKS)
    path.write_bytes(header + tempo + voice_track("Melody", melody, 1) + voice_track("Bass", bass, 2))


def write_sound(path, notes):
    low, high = min(note.pitch for note in notes), max(note.pitch for note in notes)
    samples = np.zeros(round(seconds(len(MELODY) * BAR) * RATE))
    for note in notes:
        start, length = in_seconds(note)
        first, count = round(start * RATE), round(length * RATE)
        time = np.arange(count) / RATE
        phase = 2 * np.pi * 440 * 2 ** ((note.pitch - 69) / 12) * time
        tone = (np.sin(phase) + 0.4 * np.sin(2 * phase) + 0.2 * np.sin(3 * phase)) / 1.3
        ramp = np.clip(np.minimum(time, time[::-1]) / RAMP, 0, 1)
        loudness = QUIETEST + (LOUDEST - QUIETEST) * (note.pitch - low) / (high - low)
        samples[first:first + count] += loudness * ramp * tone
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes(np.round(samples * 32767).astype("<i2").tobytes())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).resolve().parent.parent / "inputs",
                        help="where to write (default: inputs/ of this project)")
    folder = parser.parse_args().folder
    melody = notes_of(MELODY)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_score(folder / "ode_to_joy.txt", melody)
        write_midi(folder / "ode_to_joy.mid", melody, notes_of(BASS))
        write_sound(folder / "ode_to_joy.wav", melody)
    except OSError as error:
        print(f"make_music.py: {error}", file=sys.stderr)
        return 2
    print(f"{folder}/ode_to_joy.txt .mid .wav: {seconds(len(MELODY) * BAR):.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())

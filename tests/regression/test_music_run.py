#!/usr/bin/python3
"""The program with music: preview and run agree, on any number of ranks; bad music and live sound.

Usage: test_music_run.py TREVI MPIEXEC. Needs no sound library, but tests what happens without or with it.
"""

import csv
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from program import INPUTS, WITHOUT, with_instruction_set

ROOT = Path(__file__).resolve().parents[2]
SCENE = INPUTS / "musical_fountain_small.toml"
QUIET = ["--progress", "none", "--set", f"output.{'vtkhdf' if 'VTK' in WITHOUT else 'vtu'}.every=100.0"]
TREVI, MPIEXEC = "build/release/trevi", "mpiexec"


def trevi(*arguments, ranks=1, **options):
    environment = os.environ | {
        "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}
    options = {"stdin": subprocess.DEVNULL} | options if "input" not in options else options
    launcher = [MPIEXEC, "-n", str(ranks)] if ranks else []
    return subprocess.run([*launcher, TREVI, *map(str, arguments)], env=environment, timeout=100,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, **options)


def columns(file):
    header, *rows = list(csv.reader(file.read_text().splitlines()))
    return dict(zip(header, zip(*rows)))


def fountain(**keys):
    return "fountain=[{center=[1.2,0.8]," + ",".join(f"{key}={value}" for key, value in keys.items()) + "}]"


class MusicRun(unittest.TestCase):
    def setUp(self):
        self.folder_object = tempfile.TemporaryDirectory()
        self.folder = Path(self.folder_object.name)
        self.addCleanup(self.folder_object.cleanup)

    def run_scene(self, *arguments, **options):
        output = self.folder / f"out{len(list(self.folder.iterdir()))}"
        result = trevi(SCENE, *QUIET, "--output", output, *arguments, **options)
        self.assertEqual(result.returncode, 0, result.stderr.decode())
        return columns(output / "series.csv")

    def refused(self, *words, **keys):
        result = trevi(SCENE, "--output", self.folder / "none", "--set", fountain(**keys), ranks=0)
        message = result.stderr.decode()
        self.assertEqual(result.returncode, 2, message)
        for word in words:
            self.assertIn(word, message)

    def test_preview_and_run_agree_on_any_number_of_ranks(self):
        preview = self.folder / "preview.csv"
        self.assertEqual(trevi(SCENE, "--preview", preview, "--steps", 60, ranks=2).returncode, 0)
        expected = columns(preview)
        one, two = (self.run_scene("--steps", "60", ranks=ranks) for ranks in (1, 2))
        self.assertEqual(len(expected["time"]), 61)
        for name in ("time", "note_0", "speed_0"):
            self.assertEqual(expected[name], one[name])
        for name in one.keys() - {"imbalance", "wall_seconds"}:
            self.assertEqual(one[name], two[name], name)
        self.assertEqual(one["note_0"][0], "64")
        self.assertEqual((one["note_0"][28], one["speed_0"][28]), ("nan", "0"))  # between two notes

    def test_bad_music_is_bad_input(self):
        score = self.folder / "bad.txt"
        score.write_text("0 C4 1\n1 H4 1\n")
        self.refused(f"{score}:2: pitch", music=f"'{score}'")
        self.refused("missing.txt: cannot be read", music="'missing.txt'")
        midi = self.folder / "cut.mid"
        midi.write_bytes((ROOT / "inputs/ode_to_joy.mid").read_bytes()[:100])
        self.refused("cut.mid: byte 100:", music=f"'{midi}'")
        sound = self.folder / "empty.wav"
        sound.touch()
        self.refused("empty.wav", music=f"'{sound}'")
        self.refused("unknown kind", music="'score.pdf'")
        self.refused("track", "MIDI files only", music="'a.txt'", track=1)
        self.refused("follow", "there is no music", follow="'pitch'")
        self.refused("channel", "from 1 to 16", music="'a.mid'", channel=17)

    def test_a_pipe_into_rank_0_moves_the_fountain_on_two_ranks(self):
        voice = b"".join(struct.pack("<h", round(16000 * math.sin(2 * math.pi * 440 * i / 8000))) for i in range(16000))
        for follow in ("loudness", "pitch"):
            keys = {"music": "'-'", "rate": 8000, "follow": f"'{follow}'", "speed_range": "[3,6]"}
            # Ends within the first steps: then the pump is off. The reader of the pipe may lag, so only sums are sure.
            series = self.run_scene("--steps", "40", "--set", fountain(**keys), ranks=2, input=voice)
            self.assertTrue(all(0 <= float(speed) <= 6 for speed in series["speed_0"]))
            file = self.folder / "voice.raw"
            file.write_bytes(voice)
            with open(file, "rb") as stdin:  # without mpiexec, which forwards a pipe: a plain file by simulated time
                result = subprocess.run([TREVI, str(SCENE), "--preview", str(self.folder / "live.csv"), "--steps", "30",
                                         "--set", fountain(**keys)], stdin=stdin, check=False, timeout=60)
            self.assertEqual(result.returncode, 0)
            heard = columns(self.folder / "live.csv")
            self.assertGreater(float(heard["speed_0"][20]), 3)
            if follow == "pitch":
                self.assertAlmostEqual(float(heard["note_0"][20]), 69, delta=0.3)

    def test_the_curves_are_drawn(self):
        picture = self.folder / "curves.png"
        script = ROOT / "postprocess/preview_music.py"
        result = subprocess.run([script, SCENE, "--trevi", TREVI, "--output", picture], capture_output=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
        result = subprocess.run([script, ROOT / "inputs/falling_cube.toml", "--trevi", TREVI], capture_output=True,
                                check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn(b"no [[fountain]]", result.stderr)


if __name__ == "__main__":
    TREVI, MPIEXEC = with_instruction_set(sys.argv[1]), sys.argv[2]
    unittest.main(argv=sys.argv[:1])

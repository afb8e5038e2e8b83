#!/usr/bin/python3
"""render.py and surface.py on a small run: all the water is in the picture, a film has each frame and its sound, and a
missing run is told. Exit code 77: there is no virtual display or no VTK for Python here, so nothing was tested."""

import importlib.util
import json
import shutil
import subprocess
import sys
import unittest

from matplotlib import image
from program import INPUTS, ProgramTest, main

POSTPROCESS = INPUTS.parent / "postprocess"


class Pictures(ProgramTest):
    def draw(self, script, *arguments):
        return subprocess.run(["xvfb-run", "-a", "/usr/bin/python3", POSTPROCESS / script, *map(str, arguments)],
                              cwd=self.folder, capture_output=True, text=True, timeout=100, check=False)

    def test_all_the_water_is_in_the_picture(self):
        self.run_well(2, INPUTS / "fountain_small.toml", "--output", "run", "--steps", 60)
        for script in ("render.py", "surface.py"):
            with self.subTest(script):
                result = self.draw(script, "run", "--output", f"{script}.png", "--size", 240, 180)
                self.assertEqual(result.returncode, 0, result.stderr)
                picture = image.imread(self.folder / f"{script}.png")[..., :3]
                self.assertEqual(picture.shape, (180, 240, 3))
                brightness = picture.max(axis=2)
                self.assertGreater((brightness > 0.5).mean(), 0.05)  # water
                self.assertLess(max(brightness[0].max(), brightness[:, 0].max(), brightness[:, -1].max()), 0.5)

    def test_obstacles_are_stone_and_the_run_knows_its_spacing(self):
        """A ball above the water: warm pixels, as many with a lattice of another spacing; the floor is the box's."""
        scene = (self.folder / "ball.toml")
        scene.write_text("""[domain]\nmin = [0, 0, 1]\nmax = [2, 1, 2.5]\n[fluid]\nspacing = 0.1\n[time]\ndt = 0.01\nend = 0
[[particles]]\nmin = [0, 0, 1]\nmax = [2, 1, 1.4]\n[[obstacle]]\ntype = "sphere"\ncenter = [1, 0.5, 1.6]\nradius = 0.3
[output.vtkhdf]\nevery = 1\n""")
        warm = {}
        for spacing in (0.1, 0.05):
            self.run_well(1, scene, "--output", f"run{spacing}", "--set", f"fluid.spacing={spacing}")
            for script in ("render.py", "surface.py"):
                name = f"{script}{spacing}.png"
                result = self.draw(script, f"run{spacing}", "--output", name, "--size", 240, 180)
                self.assertEqual(result.returncode, 0, result.stderr)
                picture = image.imread(self.folder / name)[..., :3]
                warm[script, spacing] = (picture[..., 0] > 1.1 * picture[..., 2]).mean()
                self.assertGreater((picture[..., 2] > 1.1 * picture[..., 0]).mean(), 0.1)  # water, sky
        for script in ("render.py", "surface.py"):
            self.assertGreater(warm[script, 0.1], 0.01)
            self.assertAlmostEqual(warm[script, 0.05] / warm[script, 0.1], 1, delta=0.2)

    def test_the_surface_is_a_file_for_other_programs(self):
        self.run_well(1, INPUTS / "falling_cube_small.toml", "--output", "run", "--steps", 2, "--set",
                      "output.vtkhdf.every=1")
        for ending, words in ((".ply", b"element vertex"), (".obj", b"\nf ")):
            result = self.draw("surface.py", "run", "--output", f"water{ending}")
            self.assertEqual(result.returncode, 0, result.stderr)
            data = (self.folder / f"water{ending}").read_bytes()
            self.assertIn(words, data)
            self.assertGreater(len(data), 10000)
        for script in ("render.py", "surface.py"):
            result = self.draw(script, "run", "--output", "water.gif")
            self.assertEqual(result.returncode, 2)
            self.assertIn("water.gif: cannot be made; give --output a name that ends in .png", result.stderr)

    @unittest.skipUnless(shutil.which("ffprobe"), "no ffmpeg here")
    def test_a_film_has_each_frame_and_its_sound(self):
        self.run_well(2, INPUTS / "fountain_small.toml", "--output", "run", "--steps", 12)
        sound = INPUTS / "ode_to_joy.wav"
        result = self.draw("render.py", "run", "--output", "film.mp4", "--size", 80, 60, "--sound", sound)
        self.assertEqual(result.returncode, 0, result.stderr)
        asked = ["-v", "error", "-show_entries", "stream=codec_type,nb_frames,duration", "-of", "csv=p=0", "film.mp4"]
        told = subprocess.run(["ffprobe", *asked], cwd=self.folder, capture_output=True, text=True, check=True).stdout
        (picture, shown, frames), (melody, seconds, _) = sorted(line.split(",") for line in told.split())[::-1]
        self.assertEqual((picture, melody), ("video", "audio"))
        written = (self.folder / "run/particles.pvd").read_text(encoding="utf-8").count("<DataSet")
        self.assertGreater(int(frames), written)  # the last one stays as long as there is sound
        self.assertAlmostEqual(float(seconds), 16.4, delta=0.2)
        self.assertAlmostEqual(float(shown), 16.4, delta=0.4)
        result = self.draw("render.py", "run", "--output", "silent.mp4", "--size", 80, 60)
        self.assertEqual(result.returncode, 0, result.stderr)
        told = subprocess.run(["ffprobe", *asked[:-1], "silent.mp4"], cwd=self.folder, capture_output=True, text=True,
                              check=True).stdout
        self.assertEqual(int(told.strip().split(",")[2]), written)

    @unittest.skipUnless(importlib.util.find_spec("PIL"), "no Pillow here")
    def test_a_film_of_some_frames_in_webp(self):
        from PIL import Image  # pylint: disable=import-outside-toplevel
        self.run_well(1, INPUTS / "falling_cube_small.toml", "--output", "run", "--steps", 24, "--set",
                      "output.vtkhdf.every=0.1")
        for script in ("render.py", "surface.py"):
            result = self.draw(script, "run", "--output", "film.webp", "--size", 80, 60, "--times", 0.1, 0.3, "--slow", 2)
            self.assertEqual(result.returncode, 0, result.stderr)
            film = Image.open(self.folder / "film.webp")
            self.assertEqual((film.n_frames, film.size), (3, (80, 60)))
            film.seek(1)
            film.load()
            self.assertEqual(film.info["duration"], 200)
            for arguments, words in ((("--times", 3, 4), "the run has them from 0 to"), (("--slow", 0), "must be above 0"),
                                     (("--times", 0, 1, "--output", "film.png"), "a name that ends in .webp")):
                result = self.draw(script, "run", "--output", "film.webp", *arguments)
                self.assertEqual(result.returncode, 2)
                self.assertIn(words, result.stderr)

    @unittest.skipUnless(importlib.util.find_spec("scipy"), "no scipy here")
    def test_the_surface_holds_the_water(self):
        """Of blocks, sheets and drops: volume within 2 %, no open edge, in one piece or as many as there are."""
        code = ("import json, sys; sys.path.insert(0, sys.argv[1]); import study_surface as study; "
                "cases = [case for case in study.shapes() if len(case[1]) < 10000]; "
                "print(json.dumps([list(study.rows(*case[:2], study.SPACING, case[2]))[1] for case in cases]))")
        result = subprocess.run(["xvfb-run", "-a", "/usr/bin/python3", "-c", code, POSTPROCESS], capture_output=True,
                                text=True, timeout=200, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        found = json.loads(result.stdout)
        self.assertGreater(len(found), 6)
        for row in found:
            with self.subTest(row["case"]):
                self.assertLess(abs(float(row["volume_error_percent"])), 2)
                self.assertEqual(row["open_edges"], 0)
                self.assertEqual(row["pieces"], row["pieces_known"])

    def test_what_cannot_be_drawn_is_told(self):
        for script in ("render.py", "surface.py"):
            result = self.draw(script, "nowhere")
            self.assertEqual(result.returncode, 2)
            self.assertIn("[output.vtu]", result.stderr)


if __name__ == "__main__":
    if not shutil.which("xvfb-run") or not importlib.util.find_spec("vtkmodules"):
        sys.exit(77)
    main()

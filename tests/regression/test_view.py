#!/usr/bin/python3
"""trevi-view in a real window: what the keys do to the picture, judged by its pixels; pictures without hands; and what
becomes of directories that are missing, damaged or still growing."""

import re
import shutil
import subprocess
import unittest
import wave
from pathlib import Path

import numpy
from PIL import Image

from runs import FOUNTAIN, MUSIC, SCORE, WITHOUT, Folder, run_well
from screen import SIZE, VIEW, Screen, Viewer, changed, like, wait_until, water

FRAMES = """
[colour]
by = "rainbow_x"
[output.vtu]
every_steps = 2
fields = ["velocity", "density", "id", "rgb"]
[output.vtkhdf]
every_steps = 2
fields = ["velocity", "density", "id", "rgb"]
[output.checkpoint]
every_steps = 1000
"""
STEPS, COUNT = 40, 21


class ViewTest(unittest.TestCase):
    scene = FOUNTAIN + FRAMES

    @classmethod
    def setUpClass(cls):
        cls.screen = Screen()
        cls.addClassCleanup(cls.screen.close)
        cls.folder = Folder()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.folder.scene(SCORE, "score.txt")
        cls.run_folder = cls.folder.path("out")
        run_well(2, cls.folder.scene(cls.scene), cls.run_folder, "--steps", STEPS)

    def viewer(self, *arguments):
        viewer = Viewer(self.screen, *arguments, folder=self.folder.name)
        self.addCleanup(viewer.__exit__)
        return viewer

    def view(self, *arguments, display=True):
        environment = self.screen.environment()
        if not display:
            del environment["DISPLAY"]
        return subprocess.run([VIEW, *map(str, arguments)], env=environment, capture_output=True, text=True, timeout=60,
                              check=False, cwd=self.folder.name)


class Keys(ViewTest):
    def test_steps_and_pause(self):
        viewer = self.viewer(self.run_folder, "--paused")
        viewer.wait_title("step 0, paused")
        first = viewer.settled()
        self.assertGreater(water(first).sum(), 2000)
        viewer.press("End", f"step {STEPS}, paused")
        last = viewer.settled()
        self.assertGreater(changed(first, last), 0.1)
        viewer.press("Left", f"step {STEPS - 2}, paused")
        self.assertGreater(changed(last, viewer.settled()), 0.02)
        viewer.press("Home", "step 0, paused")
        self.assertEqual(changed(first, viewer.settled()), 0)
        viewer.press("Right", "step 2, paused")
        self.assertGreater(changed(first, viewer.settled()), 0.005)  # two steps of a jet that begins

    def test_playing(self):
        viewer = self.viewer(self.run_folder, "--paused", "--speed", "0.25")
        viewer.press("l", "x0.25 loop")
        viewer.press("minus", "x0.125 loop")
        before = viewer.settled()
        viewer.press("space", "playing")
        wait_until(lambda: viewer.step() >= 6, "the picture to move on", viewer.process)
        viewer.press("space", "paused")
        after, step = viewer.settled(), viewer.step()
        self.assertGreater(changed(before, after), 0.02)
        self.assertEqual(changed(after, viewer.settled()), 0)
        self.assertEqual(viewer.step(), step)
        for _ in range(8):
            viewer.press("plus")
        viewer.press("space", "playing")
        seen = set()
        wait_until(lambda: seen.add(viewer.step()) or (min(seen) < 10 and max(seen) > 30), "a loop", viewer.process)
        viewer.press("q")
        wait_until(lambda: viewer.process.poll() is not None, "the end")
        self.assertEqual(viewer.process.returncode, 0)

    def test_camera(self):
        viewer = self.viewer(self.run_folder, "--paused")
        viewer.wait_title("step 0")
        before = viewer.settled()
        viewer.drag(300, -60)
        turned = viewer.settled()
        self.assertGreater(changed(before, turned), 0.2)
        viewer.do("click", "--repeat", 8, 5)  # the wheel, towards the hand: farther away
        self.assertLess(water(viewer.settled()).sum(), 0.8 * water(turned).sum())
        viewer.press("r")
        self.assertEqual(changed(before, viewer.settled()), 0)

    def test_colours(self):
        viewer = self.viewer(self.run_folder, "--paused")
        viewer.wait_title("points, rainbow")
        viewer.press("End", f"step {STEPS}")
        rainbow = viewer.settled()
        for channel in range(3):  # red, green and blue each stand out somewhere
            others = rainbow[:, :, [k for k in range(3) if k != channel]].max(axis=2)
            self.assertGreater((rainbow[:, :, channel] - others > 100).sum(), 100)
        pictures = [rainbow]
        for name in ("speed", "density", "rank"):
            viewer.press("c", f"points, {name}")
            pictures.append(viewer.settled())
            self.assertGreater(changed(pictures[-2], pictures[-1]), 0.5)
        for colour in ((86, 180, 233), (230, 159, 0)):  # of ranks 0 and 1
            self.assertGreater(like(pictures[-1], colour), 500)
        viewer.press("c", "points, rainbow")
        self.assertEqual(changed(rainbow, viewer.settled()), 0)

    def test_styles_and_saving(self):
        viewer = self.viewer(self.run_folder, "--paused")
        areas = []
        for style in ("points", "spheres", "fluid"):
            viewer.wait_title(f"{style}, rainbow")
            areas.append(water(viewer.settled()).sum())
            viewer.press("p")
        self.assertGreater(min(areas), 2000)
        viewer.wait_title("points, rainbow")
        viewer.press("s")
        saved = self.folder.path("trevi_view_000000.png")
        wait_until(saved.exists, "the file", viewer.process)
        picture = numpy.asarray(Image.open(saved))[:, :, :3].astype(int)
        self.assertEqual(picture.shape, (SIZE[1], SIZE[0], 3))
        self.assertEqual(changed(viewer.settled(), picture[:viewer.settled().shape[0]]), 0)

    def test_growing(self):
        growing = self.folder.path("growing")
        shutil.copytree(self.run_folder, growing)
        whole = (growing / "particles.pvd").read_text()
        lines = whole.splitlines(keepends=True)
        (growing / "particles.pvd").write_text("".join(lines[:6] + lines[-2:]))
        viewer = self.viewer(growing, "--paused")
        viewer.press("End", "step 4, .*frame 3/3")
        new = growing / "new"
        new.write_text(whole)
        new.rename(growing / "particles.pvd")
        viewer.press("End")
        wait_until(lambda: viewer.press("End") or f"frame {COUNT}/{COUNT}" in viewer.title(), "new frames",
                   viewer.process)


# Plays by keeping the file, and by lasting until it is told to end.
PLAYER = """#!/bin/sh
/bin/cp "$1" "{heard}.part" && /bin/mv "{heard}.part" "{heard}"
echo $$ >"{heard}.pid"
exec /bin/sleep 60
"""


@unittest.skipIf("MUSIC" in WITHOUT, "this build plays no music")
class Music(ViewTest):
    scene = FOUNTAIN + MUSIC + FRAMES

    def test_plays_with_the_picture(self):
        programs, heard = self.folder.path("programs"), self.folder.path("heard.wav")
        programs.mkdir()
        (programs / "pw-play").write_text(PLAYER.format(heard=heard))
        (programs / "pw-play").chmod(0o755)
        viewer = Viewer(self.screen, self.run_folder, "--paused", folder=self.folder.name, path=programs)
        self.addCleanup(viewer.__exit__)
        viewer.press("space")
        pid_file = heard.with_suffix(".wav.pid")
        wait_until(lambda: pid_file.exists() and pid_file.read_text().strip(), "the music", viewer.process)
        with wave.open(str(heard)) as music:
            self.assertEqual((music.getnchannels(), music.getsampwidth(), music.getframerate()), (1, 2, 22050))
            samples = numpy.frombuffer(music.readframes(music.getnframes()), numpy.int16)
        self.assertGreater(numpy.abs(samples).max(), 3000)
        viewer.wait_title(f"step {STEPS}, at the end")
        wait_until(lambda: not Path(f"/proc/{pid_file.read_text().strip()}").exists(), "silence", viewer.process)

    def test_a_machine_without_sound_says_so_once(self):
        viewer = Viewer(self.screen, self.run_folder, folder=self.folder.name, path=self.folder.path("nothing"))
        self.addCleanup(viewer.__exit__)
        viewer.wait_title("at the end")
        viewer.press("q")
        self.assertEqual(viewer.process.wait(60), 0)
        self.assertEqual(viewer.process.stdout.read().count("no music: none of"), 1)


class WithoutHands(ViewTest):
    def test_both_formats_give_the_same_picture(self):
        pictures = []
        for name in ("particles.pvd", "particles.hdf.series"):
            result = self.view(self.run_folder / name, "--screenshot", "shot.png", "--at", "20", "--colour", "rank",
                               "--size", *SIZE)
            self.assertEqual(result.returncode, 0, result.stderr)
            pictures.append(self.folder.path("shot.png").read_bytes())
        self.assertEqual(pictures[0], pictures[1])

    def shot(self, *arguments):
        result = self.view(self.run_folder, "--screenshot", "shot.png", "--size", *SIZE, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return numpy.asarray(Image.open(self.folder.path("shot.png")))[:-60, :, :3].astype(int)  # without the status

    def test_fluid_has_the_colours_of_its_particles(self):
        """Where two colours meet in depth or side by side there is no dark line."""
        for colour in ("rank", "rainbow"):
            seen = water(self.shot("--style", "spheres", "--colour", colour))
            self.assertGreater(seen.sum(), 2000)
            fluid = self.shot("--style", "fluid", "--colour", colour)
            self.assertLess((seen & (fluid.max(axis=2) < 100)).sum(), 0.02 * seen.sum(), colour)

    def test_from_near_too(self):
        for style in ("points", "spheres", "fluid"):
            self.assertGreater(water(self.shot("--style", style, "--camera", 30, 20, 4)).mean(), 0.2, style)

    def test_frames(self):
        result = self.view(self.run_folder, "--frames", "pictures", "--size", 160, 120)
        self.assertEqual(result.returncode, 0, result.stderr)
        names = sorted(path.name for path in self.folder.path("pictures").iterdir())
        self.assertEqual(names, [f"frame_{step:06d}.png" for step in range(0, STEPS + 1, 2)])

    def test_thinning(self):
        result = self.view(self.run_folder, "--benchmark", "0.1", "--budget", "100", "--size", 160, 120)
        self.assertEqual(result.returncode, 0, result.stderr)
        drawn = int(result.stdout.split(": ")[1].split()[0])
        self.assertTrue(20 < drawn <= 130, result.stdout)
        result = self.view(self.run_folder, "--benchmark", "0.1", "--all", "--size", 160, 120)
        self.assertIn("576 of 576 particles", result.stdout)

    def test_help_and_no_screen(self):
        result = self.view("--help", display=False)
        self.assertEqual(result.returncode, 0)
        for word in ("--listen", "--screenshot", "space", "exactly one step", "hash of the id"):
            self.assertIn(word, result.stdout)
        self.refused("xvfb-run", self.run_folder, display=False)

    def refused(self, words, *arguments, display=True):
        result = self.view(*arguments, display=display)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(words, result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)

    def test_bad_input(self):
        self.refused("give a directory")
        self.refused("nowhere: no such file", "nowhere")
        empty = self.folder.path("empty")
        empty.mkdir()
        self.refused("[output.vtu]", empty)
        self.refused("unknown", self.run_folder, "--wrong")
        self.refused("--style", self.run_folder, "--style", "smoke")
        self.refused("not an address", "--listen", "127.0.0.1:port", "x")

    def test_damaged(self):
        damaged = self.folder.path("damaged")
        shutil.copytree(self.run_folder, damaged)
        for name in ("vtu/particles_000000_1.vtu", "vtu/particles_000000.pvtu", "particles.pvd", "particles_000000.hdf",
                     "particles.hdf.series"):
            path = damaged / name
            path.write_bytes(path.read_bytes()[:path.stat().st_size // 2])
            target = damaged / ("particles.hdf.series" if "hdf" in name else "particles.pvd")
            with self.subTest(name):
                self.refused(f"{name}: damaged", target, "--screenshot", "none.png", "--at", 0)
            if name.endswith("pvtu"):
                path.unlink()
                self.refused("not there", target, "--screenshot", "none.png", "--at", 0)
        self.assertFalse(self.folder.path("none.png").exists())

    def test_the_box_of_a_run_without_its_scene(self):
        """Pictures are the same with the scene, with run.json alone, and the box is guessed only when that is told."""
        def picture(folder):
            result = self.view(folder / "particles.hdf.series", "--screenshot", "box.png", "--at", 0)
            self.assertEqual(result.returncode, 0, result.stderr)
            return numpy.asarray(Image.open(self.folder.path("box.png"))).astype(int), result.stderr
        whole, told = picture(self.run_folder)
        self.assertEqual(told, "")
        bare = self.folder.path("bare")
        shutil.copytree(self.run_folder, bare)
        for checkpoint in bare.glob("checkpoint_*"):
            checkpoint.unlink()
        report = bare / "run.json"
        self.assertIn(f'"scene": "{self.folder.path("scene.toml")}"', report.read_text())
        report.write_text(re.sub(r'"scene": "[^"]*"', '"scene": "/gone.toml"', report.read_text()))
        by_report, told = picture(bare)
        self.assertEqual(told, "")
        self.assertLess(changed(whole, by_report), 0.02)  # the name above it is another
        report.unlink()
        _, told = picture(bare)
        self.assertIn("the box is that of the first frame's particles; give --scene", told)

    def test_the_colour_of_the_scene(self):
        folder = self.folder.path("by_speed")
        scene = self.folder.scene(self.scene.replace("rainbow_x", "speed").replace(', "rgb"', ""), "by_speed.toml")
        run_well(1, scene, folder, "--steps", 4)
        for more, colour in (([], "speed"), (["--colour", "rank"], "rank")):
            viewer = self.viewer(folder, "--paused", *more)
            viewer.wait_title(f"points, {colour}")
            viewer.process.kill()  # as windows are found by their title
            viewer.process.wait()

    def test_counts_that_cannot_be(self):
        copy = self.folder.path("counts")
        shutil.copytree(self.run_folder, copy)
        piece = copy / "vtu/particles_000000_1.vtu"
        good = piece.read_bytes()
        for count in (b"-1", b"4000000000000", b"99999999999999999999", b"many", b""):
            with self.subTest(count):
                piece.write_bytes(re.sub(b'NumberOfPoints="[0-9]+', b'NumberOfPoints="' + count, good))
                self.refused(f"{piece}: damaged", copy / "particles.pvd", "--screenshot", "none.png", "--at", 0)


if __name__ == "__main__":
    unittest.main()

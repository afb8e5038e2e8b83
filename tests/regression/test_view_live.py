#!/usr/bin/python3
"""Runs that are watched while they compute: paused, stepped, stopped, abandoned; the same bits as unwatched ones."""

import json
import os
import re
import signal
import socket
import subprocess
import time
import unittest
from pathlib import Path

import runs
from program import INSTRUCTION_SET
from runs import CHECKPOINTS, FOUNTAIN, Folder
from screen import Screen, Viewer, VIEW, changed, like, wait_until, water

SCENE = FOUNTAIN + CHECKPOINTS.format(1000, 2)
if INSTRUCTION_SET:  # runs that the viewer starts must use it, too
    SCENE += f'[run]\ninstruction_set = "{INSTRUCTION_SET}"\n'


def free_address():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{probe.getsockname()[1]}"


def times_asleep(pid):
    """How often the main thread has gone to sleep of itself; one that spins never does, however busy the machine."""
    return int(re.search(r"^voluntary_ctxt_switches:\s*(\d+)", Path(f"/proc/{pid}/status").read_text(), re.MULTILINE)[1])


def rows(output):
    """Steps that the run has written."""
    return [int(row) for row in runs.column(output, "step")]


class LiveTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.screen = Screen()
        cls.addClassCleanup(cls.screen.close)

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.scene = self.folder.scene(SCENE)
        self.output = self.folder.path("out")
        self.address = free_address()

    def viewer(self, *arguments):
        viewer = Viewer(self.screen, *arguments, folder=self.folder.name)
        self.addCleanup(viewer.__exit__)
        return viewer

    def watched_run(self, ranks, *arguments):
        """A run that holds at step 0 until its viewer lets it go, and the viewer."""
        viewer = self.viewer("--listen", self.address, self.output, "--paused")
        run = self.start(ranks, *arguments)
        viewer.wait_title("step 0, live: paused")
        return run, viewer

    def start(self, ranks, *arguments):
        run = runs.start(ranks, self.scene, self.output, "--view", self.address, *arguments)
        self.addCleanup(lambda: run.poll() is None and run.kill())
        self.addCleanup(run.stdout.close)
        return run


class Steering(LiveTest):
    def test_pause_and_single_steps(self):
        run, viewer = self.watched_run(2, "--steps", 40)
        start = viewer.settled()
        self.assertGreater(water(start).sum(), 2000)
        for step in (1, 2, 3):
            viewer.press("n", f"step {step}, live: paused")
        ranks = runs.ranks_of(run)
        self.assertEqual(len(ranks), 2)
        before = [times_asleep(pid) for pid in ranks]
        after_three = viewer.settled()
        self.assertGreater(changed(start, after_three), 0.005)
        time.sleep(1)  # a held run stays where it is, and sleeps
        self.assertEqual(changed(after_three, viewer.settled()), 0)
        self.assertEqual(rows(self.output), [0, 1, 2, 3])
        for pid, slept in zip(ranks, before):
            wait_until(lambda: times_asleep(pid) > slept + 200, "a held rank to sleep again and again")
        viewer.press("space", "live: over")
        code, text = runs.finish(run)
        self.assertEqual(code, 0, text)
        viewer.wait_title("step 40")
        self.assertEqual(rows(self.output), list(range(41)))

    def test_stop_from_a_pause(self):
        run, viewer = self.watched_run(2)
        viewer.press("n", "step 1,")
        viewer.press("q", "live: over")
        code, text = runs.finish(run)
        self.assertEqual(code, 4, text)
        self.assertEqual(json.loads((self.output / "run.json").read_text())["exit_reason"], "stopped: the viewer")
        self.assertTrue((self.output / f"checkpoint_{rows(self.output)[-1]:06d}.h5").exists())
        viewer.press("q")
        wait_until(lambda: viewer.process.poll() == 0, "the end of the viewer")

    def test_a_signal_ends_a_pause(self):
        run, _ = self.watched_run(2)
        run.send_signal(signal.SIGUSR2)
        code, text = runs.finish(run)
        self.assertEqual(code, 4, text)

    def test_started_by_the_viewer(self):
        viewer = self.viewer(self.scene, "-np", 2, "--paused", "--output", self.output, "--progress", "none")
        viewer.wait_title("step 0, live: paused +2 ranks")
        viewer.press("c")
        viewer.press("c", "density")
        viewer.press("n", "step 1,")
        viewer.press("c", "rank")
        for colour in ((86, 180, 233), (230, 159, 0)):  # on a busy machine the picture may come late
            wait_until(lambda colour=colour: like(viewer.settled(), colour) > 500, "the colour of a rank")
        viewer.press("q", "live: over")
        wait_until(lambda: (self.output / "run.json").exists(), "the run's report")


class Partings(LiveTest):
    def test_same_bits(self):
        unwatched = self.folder.path("unwatched")
        runs.run_well(2, self.scene, unwatched, "--steps", 60)
        shot = self.folder.path("shot.png")
        words = [VIEW, self.scene, "-np", "2", "--colour", "density", "--screenshot", shot, "--steps", "60", "--output",
                 self.output, "--progress", "none"]
        result = subprocess.run([str(word) for word in words], env=self.screen.environment(), timeout=100,
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        wait_until(lambda: (self.output / "run.json").exists(), "the run's report")
        self.assertTrue(shot.exists())
        self.assertEqual(runs.differences(unwatched, self.output), [])

    def test_viewer_killed_while_paused_and_another_comes(self):
        run, viewer = self.watched_run(2, "--set", "time.end=1000.0")
        viewer.press("n", "step 1,")
        viewer.process.kill()
        wait_until(lambda: rows(self.output)[-1] > 3, "the run to go on")
        second = self.viewer("--listen", self.address, self.output)
        second.wait_title(r"step \d+, live ")
        moved = second.step()
        wait_until(lambda: second.step() > moved, "new frames", second.process)
        second.press("space", "live: paused")
        second.press("q", "live: over")
        self.assertEqual(runs.finish(run)[0], 4)

    def test_stopped_viewer_costs_nothing(self):
        run, viewer = self.watched_run(1, "--steps", 40)
        viewer.press("space")
        viewer.process.send_signal(signal.SIGSTOP)
        self.assertEqual(runs.finish(run)[0], 0)
        viewer.process.send_signal(signal.SIGCONT)
        viewer.wait_title("live: over")

    def test_run_killed(self):
        run, viewer = self.watched_run(1)
        calm = viewer.settled()
        os.kill(run.pid, signal.SIGKILL)
        viewer.wait_title("live: over")
        told = viewer.settled()
        letters = (abs(told - (255, 217, 102)).max(axis=2) < 30) & (abs(calm - told).max(axis=2) > 50)
        self.assertGreater(letters.sum(), 100)  # the message
        self.assertGreater(water(told).sum(), 0.8 * water(calm).sum())  # and the last picture
        viewer.press("Escape")
        wait_until(lambda: viewer.process.poll() == 0, "the end of the viewer")

    def test_nobody_listens(self):
        code, text = runs.finish(self.start(2, "--steps", 20))
        self.assertEqual(code, 0, text)
        self.assertIn(f"warning: --view: nobody has answered at tcp://{self.address}", text)

    def test_strangers_are_turned_away(self):
        # A viewer of another run is no viewer of this one, however it pauses; nor is a caller that sends by hand.
        other = self.viewer("--listen", self.address, self.folder.path("other"), "--paused")
        code, text = runs.finish(self.start(2, "--steps", 20))
        self.assertEqual(code, 0, text)
        self.assertIn(f"what listens at tcp://{self.address} does not have the key in {self.output}", text)
        self.assertNotIn("step", other.title())
        with socket.create_connection(self.address.split(":")) as caller:  # ZeroMQ without a key
            caller.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00NULL" + bytes(48))
            caller.settimeout(20)
            while caller.recv(100):
                pass  # until the viewer hangs up
        other.process.terminate()
        other.process.wait()
        self.assertEqual(other.process.stdout.read().count("refused a caller that does not have the key"), 1)

    def test_bad_addresses_and_scenes(self):
        code, text = runs.run(2, self.scene, self.output, "--view", "here")
        self.assertEqual(code, 2)
        self.assertEqual(len(re.findall("not an address", text)), 1)
        self.assertFalse(self.output.exists())
        bad = self.folder.scene("[domain]\n", "bad.toml")
        result = subprocess.run([VIEW, bad], env=self.screen.environment(), capture_output=True, text=True, timeout=60,
                                check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("[domain] min", result.stderr)
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            address = f"127.0.0.1:{taken.getsockname()[1]}"
            result = subprocess.run([VIEW, "--listen", address, str(self.folder.path("x"))], env=self.screen.environment(), capture_output=True,
                                    text=True, timeout=60, check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("choose another port", result.stderr)
        result = subprocess.run([VIEW, "--listen", address], env=self.screen.environment(), capture_output=True,
                                text=True, timeout=60, check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("give the folder of the run", result.stderr)


if __name__ == "__main__":
    unittest.main()

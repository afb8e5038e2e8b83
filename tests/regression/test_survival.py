#!/usr/bin/python3
"""Runs that survive: signals, stop file, wall limit, kill -9, full disk, blow-up.

Small scenes with the real program (runs.py says how it is found). A class for each subject, so that
    tests/regression/test_survival.py Signals Kill
runs these two.
"""

import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest

import h5py
import runs
from runs import CHECKPOINTS, CUBE, FOUNTAIN, FRAMES, MUSIC, SCORE, Folder


def reason(output):
    return json.loads((output / "run.json").read_text())["exit_reason"]


ENDLESS = 10**7  # steps: a run that is interrupted must not end first, however late that comes


class Signals(unittest.TestCase):
    """Runs without end, interrupted; what is printed is typed in with an end that is near, and what then comes out
    compared with a run that was left alone."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.output = self.folder.path("out")

    def interrupt(self, text, act, ranks=2, extra=None):
        scene = self.folder.scene(text)
        process = runs.start(ranks, scene, self.output, "--steps", ENDLESS, extra=extra)
        runs.wait_for_row(self.output, 20, process)
        act(process)
        return runs.finish(process)

    def go_on(self, told):
        line = told.splitlines()[[k for k, line in enumerate(told.splitlines()) if "go on with" in line][0] + 1]
        self.assertIn(f"--steps {ENDLESS}", line)
        line = line.replace(f"--steps {ENDLESS}", f"--steps {runs.last_step(self.output) + 30}")
        done = subprocess.run(line, shell=True, env=runs.environment(), capture_output=True, text=True, timeout=runs.TIMEOUT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(reason(self.output), "done")

    def check_against_undisturbed(self, text):
        undisturbed = self.folder.path("undisturbed")
        runs.run_well(1, self.folder.scene(text), undisturbed, "--steps", runs.last_step(self.output))
        self.assertEqual(runs.rows(undisturbed), runs.rows(self.output))

    def test_usr2_without_checkpoints_in_the_scene(self):
        code, told = self.interrupt(CUBE, lambda process: process.send_signal(signal.SIGUSR2))
        self.assertEqual(code, 4, told)
        self.assertEqual(reason(self.output), "stopped: SIGUSR2")
        self.assertEqual(len(list(self.output.glob("checkpoint_*.h5"))), 1)
        self.go_on(told)
        self.check_against_undisturbed(CUBE)

    def test_usr1_saves_once_and_goes_on(self):
        def act(process):
            process.send_signal(signal.SIGUSR1)
            runs.wait_for(lambda: list(self.output.glob("checkpoint_*.h5")), process, "the checkpoint")
            saved = int(runs.last_checkpoint(self.output).stem[-6:])
            runs.wait_for_row(self.output, saved + 20, process)
            self.assertEqual(len(list(self.output.glob("checkpoint_*.h5"))), 1)
            process.send_signal(signal.SIGUSR2)
        code, told = self.interrupt(CUBE, act)
        self.assertEqual(code, 4, told)
        self.assertEqual(len(list(self.output.glob("checkpoint_*.h5"))), 2)

    def test_usr2_to_one_rank_alone(self):
        code, told = self.interrupt(CUBE, lambda process: os.kill(runs.ranks_of(process)[-1], signal.SIGUSR2), ranks=3)
        self.assertEqual(code, 4, told)

    def test_term_to_a_single_rank_run(self):
        code, told = self.interrupt(CUBE, lambda process: process.terminate(), ranks=1)
        self.assertEqual(code, 4, told)
        self.assertIn("SIGTERM", reason(self.output))

    def test_hup_to_a_run_whose_terminal_is_gone(self):
        code, told = self.interrupt(CUBE, lambda process: process.send_signal(signal.SIGHUP), ranks=1)
        self.assertEqual(code, 4, told)
        self.assertIn("SIGHUP", reason(self.output))
        self.assertEqual(len(list(self.output.glob("checkpoint_*.h5"))), 1)

    def test_hup_under_nohup_is_ignored(self):
        def act(process):
            process.send_signal(signal.SIGHUP)
            runs.wait_for_row(self.output, len(runs.rows(self.output)) + 20, process)
            process.send_signal(signal.SIGUSR2)
        old = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # which the run inherits
        try:
            code, told = self.interrupt(CUBE, act, ranks=1)
        finally:
            signal.signal(signal.SIGHUP, old)
        self.assertEqual(code, 4, told)
        self.assertEqual(reason(self.output), "stopped: SIGUSR2")

    def test_term_to_mpirun_with_time_to_stop(self):
        # Open MPI waits that many seconds, sends SIGTERM to the ranks, and waits as many again before it kills them.
        code, told = self.interrupt(CUBE, lambda process: process.terminate(),
                                    extra={"OMPI_MCA_odls_base_sigkill_timeout": "4"})
        self.assertNotEqual(code, 0, told)
        self.assertTrue(list(self.output.glob("checkpoint_*.h5")), told)
        self.assertIn("stopped", reason(self.output))

    def test_stop_file(self):
        def act(process):
            (self.output / "stop").mkdir()  # no file, so no request
            time.sleep(2)  # the run looks once a second
            (self.output / "stop").rmdir()
            (self.output / "stop").touch()
        code, told = self.interrupt(CUBE + CHECKPOINTS.format(ENDLESS, 2), act)
        self.assertEqual(code, 4, told)
        self.assertFalse((self.output / "stop").exists())
        self.assertEqual(reason(self.output), "stopped: the stop file")
        more = ["--restart", "latest", "--steps", runs.last_step(self.output) + 5]
        runs.run_well(2, self.folder.path("scene.toml"), self.output, *more)

    def test_nobody_reads_the_progress(self):
        launched = [runs.TREVI, self.folder.scene(CUBE), "--output", self.output, "--steps", "50", "--progress", "bar"]
        reading, writing = os.pipe()
        os.close(reading)
        done = subprocess.run(launched, stderr=writing, env=runs.environment(), timeout=runs.TIMEOUT, check=False)
        os.close(writing)
        self.assertEqual(done.returncode, 0)

    def test_wall_limit(self):
        scene = self.folder.scene(CUBE + '[run]\nwall_limit = "0.2s"\n')
        code, told = runs.run(2, scene, self.output, "--steps", ENDLESS)
        self.assertEqual(code, 4, told)
        self.assertEqual(reason(self.output), "stopped: the wall limit")
        self.assertEqual(len(list(self.output.glob("checkpoint_*.h5"))), 1)


class Kill(unittest.TestCase):
    """kill -9 of one rank; TREVI_KILLS random moments (default 3) beside the chosen ones."""

    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.scene = cls.folder.scene(FOUNTAIN + FRAMES + CHECKPOINTS.format(3, 2))
        cls.undisturbed = cls.folder.path("undisturbed")
        runs.run_well(2, cls.scene, cls.undisturbed, "--steps", 60)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def survive(self, name, moment, which):
        """moment(output, process) returns when it is time to kill. Tells whether there was still a run to kill, and
        what the restart said."""
        output = self.folder.path(name)
        process = runs.start(2, self.scene, output, "--steps", 60)
        try:
            moment(output, process)
            killed = runs.kill_one(process, which)
        except runs.EndedBefore:
            killed = False
        code, told = runs.finish(process)
        self.assertTrue(not killed or code != 0, told)
        told = runs.run_well(2 + which, self.scene, output, "--steps", 60, "--restart", "latest")
        self.assertEqual(runs.differences(self.undisturbed, output), [], told)
        return killed, told.splitlines()[0] if told else ""

    def survive_when_there(self, name, pattern, which):
        """A checkpoint is under way for a millisecond or two, which a busy machine may let pass unseen."""
        for attempt in range(10):
            if self.survive(f"{name}_{attempt}", self.when_there(pattern), which)[0]:
                return
        self.skipTest(f"{pattern} was not caught in ten runs")

    def when_there(self, pattern):
        def moment(output, process):
            runs.wait_for(lambda: any(output.glob(pattern)), process, pattern)
        return moment

    def test_before_anything_is_written(self):
        self.survive("nothing", lambda output, process: runs.wait_for(lambda: runs.ranks_of(process), process, "ranks"), 0)

    def test_at_step_0(self):
        self.survive("step_0", self.when_there("series.csv"), 1)

    def test_during_the_first_checkpoint(self):
        self.survive_when_there("first", "checkpoint_000000.h5.tmp", 0)

    def test_during_a_checkpoint(self):
        self.survive_when_there("later", "checkpoint_0000[1-5]?.h5.tmp", 1)

    def test_at_random_moments(self):
        generator = random.Random(int(os.environ.get("TREVI_KILL_SEED", "1")))
        for k in range(int(os.environ.get("TREVI_KILLS", "3"))):
            row, which = generator.randrange(60), generator.randrange(2)
            _, told = self.survive(f"random_{k}", lambda output, process: runs.wait_for_row(output, row, process), which)
            print(f"killed rank {which} after row {row}: {told}", flush=True)


class Failures(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)

    def test_blow_up_is_told_and_kept(self):
        for ranks in (1, 2):
            output = self.folder.path(f"out{ranks}")
            scene = self.folder.scene(CUBE + CHECKPOINTS.format(1, 5))
            code, told = runs.run(ranks, scene, output, "--set", "gravity.acceleration=[0,0,-1e308]",
                                  "--set", "time.dt=20.0", "--set", "time.end=1000.0", "--set", "time.cfl=0",
                                  "--steps", 50)
            self.assertEqual(code, 3, told)
            self.assertRegex(told, r"trevi: rank \d, step \d+: particle \d+ is at .* not a number: .*smaller dt")
            self.assertEqual(told.count("not a number"), 1)
            file, = output.glob("blowup_*.h5")
            with h5py.File(file) as content:
                self.assertEqual(content["particles/position"].shape, (576, 3))
                self.assertEqual(content["VTKHDF"].attrs["Type"], b"UnstructuredGrid")
                self.assertIn(b"not a number", bytes(content.attrs["message"]))
            self.assertTrue(reason(output).startswith("failed: rank"))
            self.assertTrue(file.with_suffix(".hdf").exists())

    def test_disk_full(self):
        outputs = {"checkpoint": CHECKPOINTS.format(1, 1000), "series": CHECKPOINTS.format(10, 1000),
                   **{name: CHECKPOINTS.format(5, 2) + f"[output.{name}]\nevery_steps = 1\nfields = ['velocity', 'density', 'id']"
                      for name in ("vtu", "vtkhdf") if f"[output.{name}]" in FRAMES}}
        for name, text in outputs.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as disk:
                mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", disk], capture_output=True)
                if mounted.returncode != 0:
                    self.skipTest("cannot mount a small disk here: " + mounted.stderr.decode().strip())
                try:
                    self.fill(disk, CUBE + text)
                finally:
                    subprocess.run(["umount", disk], check=True)

    def fill(self, disk, text):
        output = self.folder.path("full") if disk is None else runs.Path(disk) / "out"
        scene = self.folder.scene(text)
        code, told = runs.run(2, scene, output, "--steps", ENDLESS)
        self.assertEqual(code, 3, told)
        self.assertRegex(told, r"trevi: (rank \d: )?/\S+: cannot")
        self.assertNotIn("Signal", told)
        self.assertFalse(list(output.glob("*.tmp")))
        checkpoint = runs.last_checkpoint(output)
        step = int(checkpoint.stem[-6:])
        with tempfile.TemporaryDirectory() as elsewhere:
            runs.run_well(2, scene, elsewhere + "/out", "--restart", checkpoint, "--steps", step + 2, "--set",
                          "output.checkpoint.keep=1")

    def test_unwritable_directory(self):
        file = self.folder.path("file")
        file.write_text("not a folder")
        code, told = runs.run(2, self.folder.scene(CUBE), file / "out", "--steps", 1)
        self.assertEqual(code, 3, told)
        self.assertIn(str(file / "out"), told)

    def test_a_folder_that_is_removed_under_a_run(self):
        scene = self.folder.scene(CUBE)
        for ranks, back in ((1, False), (2, True)):
            output = self.folder.path(f"gone{ranks}")
            process = runs.start(ranks, scene, output, "--steps", ENDLESS)
            runs.wait_for_row(output, 20, process)
            output.rename(self.folder.path("away"))  # at once, as no run can be caught between two files
            if back:
                output.mkdir()  # another folder of that name is not ours to write into
            shutil.rmtree(self.folder.path("away"))
            code, told = runs.finish(process)
            self.assertEqual(code, 3, told)
            rescued = self.folder.path(f"gone{ranks}.rescued")
            self.assertRegex(told, f"series.csv: cannot write: .*removed(.|\n)*--output {rescued} --restart latest")
            self.assertIn("removed", reason(rescued))
            self.assertEqual(list(output.glob("*")) if back else output.exists(), [] if back else False)
            step, straight = int(runs.last_checkpoint(rescued).stem[-6:]), self.folder.path(f"straight{ranks}")
            checkpoints = ["--set", "output.checkpoint.every_steps=1000000"]
            runs.run_well(1, scene, straight, "--steps", step, *checkpoints)
            self.assertEqual(runs.particles(runs.last_checkpoint(straight))["particles/position"],
                             runs.particles(runs.last_checkpoint(rescued))["particles/position"])
            runs.run_well(2, scene, rescued, "--steps", step + 2, "--restart", "latest")

    @unittest.skipIf("MUSIC" in runs.WITHOUT, "this build plays no music")
    def test_a_folder_and_the_music_are_removed_under_a_run(self):
        """What a checkpoint tells of the run was read at its start."""
        scene, score = self.folder.scene(FOUNTAIN + MUSIC), self.folder.scene(SCORE, "score.txt")
        output, rescued = self.folder.path("gone"), self.folder.path("gone.rescued")
        process = runs.start(2, scene, output, "--steps", ENDLESS)
        runs.wait_for_row(output, 10, process)
        score.unlink()
        output.rename(self.folder.path("away"))
        shutil.rmtree(self.folder.path("away"))
        code, told = runs.finish(process)
        self.assertEqual(code, 3, told)
        self.assertIn(f"--output {rescued} --restart latest", told)
        self.folder.scene(SCORE, "score.txt")
        runs.run_well(1, scene, rescued, "--steps", int(runs.last_checkpoint(rescued).stem[-6:]) + 2, "--restart", "latest")

    def test_another_run_is_not_overwritten(self):
        scene, output = self.folder.scene(CUBE), self.folder.path("out")
        runs.run_well(1, scene, output, "--steps", 1)
        code, told = runs.run(2, scene, output, "--steps", 1)
        self.assertEqual(code, 2, told)
        self.assertIn("holds another run", told)
        code, told = runs.run(2, scene, output, "--steps", 1, "--restart", "latest")  # past step 0, no checkpoint
        self.assertEqual(code, 2, told)
        self.assertIn("no checkpoint", told)


class TwoRuns(unittest.TestCase):
    """In one folder at a time."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.scene, self.output = self.folder.scene(CUBE + CHECKPOINTS.format(5, 2)), self.folder.path("out")

    def test_beside_a_live_one_nothing_is_done_and_after_its_kill_all(self):
        live = runs.start(2, self.scene, self.output, "--steps", ENDLESS)
        runs.wait_for_row(self.output, 20, live)
        for ranks, arguments in ((1, []), (2, ["--restart", "latest"])):
            code, told = runs.run(ranks, self.scene, self.output, "--steps", 10, *arguments)
            self.assertEqual(code, 2, told)
            self.assertIn(f"another run is writing here (host {socket.gethostname()}, process ", told)
            self.assertIn(int(re.search(r"process (\d+)", told)[1]), runs.ranks_of(live))
        self.assertFalse(list(self.output.glob("*.stale")))
        runs.kill_one(live, 0)
        self.assertNotEqual(runs.finish(live)[0], 0)
        steps = runs.column(self.output, "step")
        self.assertEqual(steps, list(range(len(steps))))
        runs.run_well(2, self.scene, self.output, "--steps", int(steps[-1]) + 10, "--restart", "latest")
        self.assertFalse((self.output / "run.lock").exists())


class Slurm(unittest.TestCase):
    """jobs/trevi.sbatch, without Slurm: a stand-in for scontrol starts it again."""

    def test_goes_on_after_the_time_limit(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        scene, output = folder.scene(CUBE), folder.path("out")
        folder.scene("#!/bin/sh\necho scontrol \"$@\"\n", "scontrol").chmod(0o755)
        extra = {"PATH": f"{folder.name}:{os.environ['PATH']}", "TREVI": runs.TREVI, "MPIRUN": runs.MPIEXEC,
                 "SLURM_NTASKS": "2", "SLURM_JOB_ID": "77"}
        job = ["bash", str(runs.ROOT / "jobs/trevi.sbatch"), str(scene), "--output", str(output), "--progress", "none",
               "--steps"]
        process = subprocess.Popen([*job, str(ENDLESS)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   env=runs.environment(extra))
        runs.wait_for_row(output, 20, process)
        process.send_signal(signal.SIGUSR2)
        code, told = runs.finish(process)
        self.assertEqual(code, 0, told)
        self.assertIn("scontrol requeue 77", told)
        self.assertEqual(reason(output), "stopped: SIGUSR2")
        last = runs.last_step(output) + 30
        done = subprocess.run([*job, str(last)], env=runs.environment(extra), capture_output=True, text=True,
                              timeout=runs.TIMEOUT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("scontrol", done.stdout)
        straight = folder.path("straight")
        runs.run_well(1, scene, straight, "--steps", last)
        self.assertEqual(runs.rows(straight), runs.rows(output))

    def signalled_deaf(self, *signals):
        """What the job says when its signals come before the run listens: the launcher here never does."""
        folder = Folder()
        self.addCleanup(folder.cleanup)
        folder.scene("#!/bin/sh\necho scontrol \"$@\"\n", "scontrol").chmod(0o755)
        launcher = folder.scene("#!/bin/sh\necho started\nexec sleep 3\n", "launcher")
        launcher.chmod(0o755)
        process = subprocess.Popen(["bash", str(runs.ROOT / "jobs/trevi.sbatch"), "scene.toml"], stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, env=runs.environment({
                                       "PATH": f"{folder.name}:{os.environ['PATH']}", "MPIRUN": str(launcher),
                                       "SLURM_JOB_ID": "77"}))
        self.assertEqual(process.stdout.readline(), "started\n")
        for one in signals:
            time.sleep(0.5)
            process.send_signal(one)
        told, _ = process.communicate(timeout=runs.TIMEOUT)
        return process.returncode, told

    def test_a_signal_before_the_run_listens_puts_it_back(self):
        code, told = self.signalled_deaf(signal.SIGUSR2)
        self.assertEqual(code, 0, told)
        self.assertIn("scontrol requeue 77", told)

    def test_a_request_before_the_run_listens_is_lost(self):
        code, told = self.signalled_deaf(signal.SIGUSR1, signal.SIGUSR1)
        self.assertEqual((code, told), (0, ""))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""Runs that survive: restart on another rank count, signals, stop file, wall limit, kill -9, full disk, blow-up.

Small scenes with the real program (runs.py says how it is found). A class for each subject, so that
    tests/regression/test_survival.py Restart Kill
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


class Restart(unittest.TestCase):
    def same_bits(self, text, *settings):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        folder.scene(SCORE, "score.txt")
        scene = folder.scene(text + FRAMES + CHECKPOINTS.format(30, 2))
        straight, parted = folder.path("straight"), folder.path("parted")
        runs.run_well(2, scene, straight, "--steps", 60, *settings)
        runs.run_well(2, scene, parted, "--steps", 30, *settings)
        runs.run_well(3, scene, parted, "--steps", 60, "--restart", "latest", *settings)
        self.assertEqual(runs.differences(straight, parted), [])
        self.assertEqual(len(runs.rows(parted)), 62)
        seconds = runs.column(parted, "wall_seconds")
        self.assertEqual(seconds, sorted(seconds))
        return parted

    def test_cube(self):
        self.same_bits(CUBE)

    def test_musical_fountain(self):
        parted = self.same_bits(FOUNTAIN + MUSIC)
        self.assertGreater(len(set(runs.column(parted, "speed_0"))), 3)

    def test_single_precision_with_substeps(self):
        self.same_bits(CUBE, "--set", "density.precision=single", "--set", "time.cfl=0.1")

    def test_step_0_and_another_folder(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        scene = folder.scene(CUBE + CHECKPOINTS.format(20, 10))
        straight, other = folder.path("straight"), folder.path("other")
        runs.run_well(1, scene, straight, "--steps", 20)
        runs.run_well(2, scene, other, "--steps", 20, "--restart", straight / "checkpoint_000000.h5")
        self.assertEqual(runs.particles(straight / "checkpoint_000020.h5"),
                         runs.particles(other / "checkpoint_000020.h5"))

    def test_later_files_are_set_aside(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        scene, output = folder.scene(CUBE + FRAMES + CHECKPOINTS.format(10, 10)), folder.path("out")
        runs.run_well(1, scene, output, "--steps", 30)
        before = runs.rows(output)
        runs.run_well(2, scene, output, "--steps", 30, "--restart", output / "checkpoint_000010.h5")
        self.assertEqual(runs.rows(output), before)
        names = ["checkpoint_000020.h5", "particles_000020.hdf"]
        if "[output.vtu]" in FRAMES:
            names.append("vtu/particles_000020.pvtu")
        for name in names:
            self.assertTrue((output / f"{name}.stale").exists(), name)

    def test_never_backwards(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        text, output = CUBE + CHECKPOINTS.format(10, 10), folder.path("out")
        scene = folder.scene(text)
        runs.run_well(1, scene, output, "--steps", 30)
        kept = {path: path.read_bytes() for path in output.iterdir()}
        early = folder.scene(text.replace("end = 1.0", "end = 0.3"), "early.toml")
        for ranks in (1, 2):
            for path, arguments, expected, words in ((scene, ["--steps", 20], 2, "--steps 20: "), (early, [], 2, "[time] end"),
                                                     (scene, ["--steps", 30], 0, "nothing to do")):
                code, told = runs.run(ranks, path, output, "--restart", "latest", *arguments)
                self.assertEqual(code, expected, told)
                self.assertIn(words, told)
                self.assertIn("checkpoint_000030.h5", told)
                self.assertEqual({path: path.read_bytes() for path in output.iterdir()}, kept)

    def test_copies_that_a_user_made_are_left_alone(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        scene, output = folder.scene(CUBE + FRAMES + CHECKPOINTS.format(10, 1)), folder.path("out")
        runs.run_well(1, scene, output, "--steps", 20)
        copies = [(output / name, output / copy) for name, copy in (
            ("checkpoint_000020.h5", "checkpoint_000005_good.h5"), ("checkpoint_000020.h5", "checkpoint_000099_final.h5"),
            ("checkpoint_000020.h5", "checkpoint_21.h5"), ("vtu/particles_000020.pvtu", "vtu/particles_000099_mine.pvtu"),
            ("particles_000020.hdf", "particles_000099_mine.hdf"))]
        for name, copy in copies:
            shutil.copyfile(name, copy)
        runs.run_well(2, scene, output, "--steps", 40, "--restart", "latest")
        self.assertEqual([copy.name for _, copy in copies if not copy.exists()], [])
        self.assertEqual(sorted(path.name for path in output.glob("checkpoint_??????.h5")), ["checkpoint_000040.h5"])


class SceneChanges(unittest.TestCase):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.output = self.folder.path("out")
        self.text = CUBE + CHECKPOINTS.format(10, 2)
        runs.run_well(1, self.folder.scene(self.text), self.output, "--steps", 10)

    def restart(self, text, *arguments):
        return runs.run(2, self.folder.scene(text), self.output, "--restart", "latest", "--steps", 12, *arguments)

    def test_times_and_outputs_may_change(self):
        text = self.text.replace("end = 1.0", "end = 2.0").replace("keep = 2", "keep = 3") + FRAMES
        code, told = self.restart("# another comment\n" + text)
        self.assertEqual(code, 2, told)  # rainbow_x needs the hue of the start
        self.assertIn("rainbow_x", told)
        code, told = self.restart(text.replace("rainbow_x", "speed"))
        self.assertEqual(code, 0, told)
        for change in ("time.end: 1 -> 2", "output.checkpoint.keep: 2 -> 3", "colour.by: (absent) -> "):
            self.assertIn(change, told)
        self.assertNotIn("comment", told)

    def test_physics_may_not(self):
        code, told = self.restart(self.text.replace("k = 0.001", "k = 0.0011").replace("[viscosity]\nc = 0.001", ""))
        self.assertEqual(code, 2, told)
        line = self.text.splitlines().index("k = 0.001") + 1
        self.assertIn(f"scene.toml:{line}: tensile.k: 0.001 -> 0.0011", told)
        self.assertIn("viscosity.c: 0.001 -> (absent)", told)

    def test_physics_may_when_told_so(self):
        code, told = self.restart(self.text, "--set", "tensile.k=0.002")
        self.assertEqual(code, 0, told)
        self.assertIn("tensile.k: 0.001 -> 0.002", told)
        code, told = self.restart(self.text)  # the override is part of the run now
        self.assertEqual(code, 2, told)
        self.assertIn("say --set tensile.k=0.002 again, or say --set tensile.k=0.001", told)

    def test_music_under_its_old_name(self):
        scene, output = self.folder.scene(FOUNTAIN + MUSIC + CHECKPOINTS.format(10, 2)), self.folder.path("music")
        self.folder.scene(SCORE, "score.txt")
        runs.run_well(2, scene, output, "--steps", 10)
        self.folder.scene(SCORE.replace("E4", "F4"), "score.txt")
        code, told = runs.run(2, scene, output, "--restart", "latest", "--steps", 12)
        self.assertEqual(code, 2, told)
        self.assertIn("score.txt: fountain.0.music: not what the run has played so far", told)
        os.rename(self.folder.path("score.txt"), self.folder.path("new.txt"))
        runs.run_well(1, scene, output, "--restart", "latest", "--steps", 12, "--set", "fountain.0.music=new.txt")

    def test_particles_never(self):
        code, told = self.restart(self.text, "--set", "particles.0.velocity=[1,0,0]")
        self.assertEqual(code, 2, told)
        self.assertIn("particles.0.velocity: (absent) -> [1, 0, 0]; a restart has its particles from the checkpoint", told)

    def test_an_override_that_is_left_out(self):
        code, told = self.restart(self.text, "--set", "domain.slab_axis=y")
        self.assertEqual(code, 0, told)
        code, told = self.restart(self.text)
        self.assertEqual(code, 2, told)
        self.assertIn("say --set domain.slab_axis=y again", told)

    def test_length_of_a_step_never(self):
        code, told = self.restart(self.text, "--set", "time.dt=0.01")
        self.assertEqual(code, 2, told)
        self.assertIn("--set time.dt=0.01", told)


class Signals(unittest.TestCase):
    """500 steps, interrupted; what is printed is typed in, and the end compared with a run that was left alone."""

    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.cleanup)
        self.output = self.folder.path("out")

    def interrupt(self, text, act, ranks=2, extra=None, steps=500):
        scene = self.folder.scene(text)
        process = runs.start(ranks, scene, self.output, "--steps", steps, extra=extra)
        runs.wait_for_row(self.output, 20, process)
        act(process)
        return runs.finish(process)

    def go_on(self, told):
        line = told.splitlines()[[k for k, line in enumerate(told.splitlines()) if "go on with" in line][0] + 1]
        done = subprocess.run(line, shell=True, env=runs.environment(), capture_output=True, text=True, timeout=runs.TIMEOUT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(reason(self.output), "done")

    def check_against_undisturbed(self, text):
        undisturbed = self.folder.path("undisturbed")
        runs.run_well(1, self.folder.scene(text), undisturbed, "--steps", 500)
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
        code, told = self.interrupt(CUBE, act)
        self.assertEqual(code, 0, told)
        self.assertEqual(len(list(self.output.glob("checkpoint_*.h5"))), 1)
        self.assertEqual(reason(self.output), "done")

    def test_usr2_to_one_rank_alone(self):
        code, told = self.interrupt(CUBE, lambda process: os.kill(runs.ranks_of(process)[-1], signal.SIGUSR2), ranks=3)
        self.assertEqual(code, 4, told)

    def test_term_to_a_single_rank_run(self):
        code, told = self.interrupt(CUBE, lambda process: process.terminate(), ranks=1)
        self.assertEqual(code, 4, told)
        self.assertIn("SIGTERM", reason(self.output))

    def test_term_to_mpirun_with_time_to_stop(self):
        # Open MPI waits that many seconds, sends SIGTERM to the ranks, and waits as many again before it kills them.
        code, told = self.interrupt(CUBE, lambda process: process.terminate(), steps=10**7,
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
        code, told = self.interrupt(CUBE + CHECKPOINTS.format(100000, 2), act, steps=10**7)
        self.assertEqual(code, 4, told)
        self.assertFalse((self.output / "stop").exists())
        self.assertEqual(reason(self.output), "stopped: the stop file")
        last = int(runs.column(self.output, "step")[-1])
        runs.run_well(2, self.folder.path("scene.toml"), self.output, "--restart", "latest", "--steps", last + 5)

    def test_nobody_reads_the_progress(self):
        launched = [runs.TREVI, self.folder.scene(CUBE), "--output", self.output, "--steps", "50", "--progress", "bar"]
        reading, writing = os.pipe()
        os.close(reading)
        done = subprocess.run(launched, stderr=writing, env=runs.environment(), timeout=runs.TIMEOUT, check=False)
        os.close(writing)
        self.assertEqual(done.returncode, 0)

    def test_wall_limit(self):
        code, told = runs.run(2, self.folder.scene(CUBE + '[run]\nwall_limit = "0.2s"\n'), self.output, "--steps", 5000)
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
        """moment(output, process) returns when it is time to kill."""
        output = self.folder.path(name)
        process = runs.start(2, self.scene, output, "--steps", 60)
        moment(output, process)
        killed = runs.kill_one(process, which)
        code, told = runs.finish(process)
        self.assertTrue(not killed or code != 0, told)
        told = runs.run_well(2 + which, self.scene, output, "--steps", 60, "--restart", "latest")
        self.assertEqual(runs.differences(self.undisturbed, output), [], told)
        return told.splitlines()[0] if told else ""

    def when_there(self, pattern):
        def moment(output, process):
            runs.wait_for(lambda: any(output.glob(pattern)), process, pattern)
        return moment

    def test_before_anything_is_written(self):
        self.survive("nothing", lambda output, process: runs.wait_for(lambda: runs.ranks_of(process), process, "ranks"), 0)

    def test_at_step_0(self):
        self.survive("step_0", self.when_there("series.csv"), 1)

    def test_during_the_first_checkpoint(self):
        self.survive("first", self.when_there("checkpoint_000000.h5.tmp"), 0)

    def test_during_a_checkpoint(self):
        self.survive("later", self.when_there("checkpoint_0000[1-5]?.h5.tmp"), 1)

    def test_at_random_moments(self):
        generator = random.Random(int(os.environ.get("TREVI_KILL_SEED", "1")))
        for k in range(int(os.environ.get("TREVI_KILLS", "3"))):
            row, which = generator.randrange(60), generator.randrange(2)
            told = self.survive(f"random_{k}", lambda output, process: runs.wait_for_row(output, row, process), which)
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
                                  "--set", "time.dt=20.0", "--set", "time.cfl=0",
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
        code, told = runs.run(2, scene, output, "--steps", 5000)
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
        live = runs.start(2, self.scene, self.output, "--steps", 10**7)
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
               "--steps", "300"]
        process = subprocess.Popen(job, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   env=runs.environment(extra))
        runs.wait_for_row(output, 20, process)
        process.send_signal(signal.SIGUSR2)
        code, told = runs.finish(process)
        self.assertEqual(code, 0, told)
        self.assertIn("scontrol requeue 77", told)
        self.assertEqual(reason(output), "stopped: SIGUSR2")
        done = subprocess.run(job, env=runs.environment(extra), capture_output=True, text=True, timeout=runs.TIMEOUT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("scontrol", done.stdout)
        straight = folder.path("straight")
        runs.run_well(1, scene, straight, "--steps", 300)
        self.assertEqual(runs.rows(straight), runs.rows(output))


if __name__ == "__main__":
    unittest.main()

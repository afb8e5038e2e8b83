#!/usr/bin/python3
"""Threads of a run: who names their number and who beats whom, what is refused, and where the run tells of them."""

import json
import os
import re
import subprocess
from unittest import mock

from program import INPUTS, MPI_SETTINGS, TIME_LIMIT, ProgramTest, main

CUBE = INPUTS / "falling_cube_small.toml"
FIRST_LINE = re.compile(r"trevi \d+\.\d+\.\d+: (\d+) ranks? x (\d+) threads?, ([\w-]+), (single|double) precision, "
                        r"([\d,]+) particles?\n")
CORES = len(os.sched_getaffinity(0))  # processors, rather: there may be two a core


class ThreadsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        environment = mock.patch.dict(os.environ)
        environment.start()
        self.addCleanup(environment.stop)
        os.environ.pop("OMP_NUM_THREADS", None)  # the tests' own, for all runs that are not about threads
        self.runs = 0

    def told(self, ranks, *arguments):
        """(ranks, threads) in the first line of a run, which run.json must have, too."""
        self.runs += 1
        result = self.run_well(ranks, CUBE, "--output", f"run_{self.runs}", "--steps", 1, *arguments)
        report = json.loads((self.folder / f"run_{self.runs}" / "run.json").read_text())
        # OpenMP's library has its own word about a number that it cannot use, mpiexec about a signal.
        match = FIRST_LINE.match(re.sub(r"\s*(libgomp|mpiexec): .*\n", "", result.stderr))
        self.assertTrue(match, result.stderr)
        self.assertEqual(report["threads"], report["threads_min"])
        self.assertEqual(match.groups(), (str(report["ranks"]), str(report["threads"]), report["instruction_set"],
                                          report["precision"], f"{report['particles']:,}"))
        return report["ranks"], report["threads"]


class Precedence(ThreadsTest):
    def test_each_beats_the_next(self):
        table, line = ["--set", "run.threads=3"], ["--threads", 2]
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                os.environ.pop("OMP_NUM_THREADS", None)
                self.assertEqual(self.told(ranks, *table), (ranks, 3))
                os.environ["OMP_NUM_THREADS"] = "4"
                self.assertEqual(self.told(ranks), (ranks, 4))
                self.assertEqual(self.told(ranks, *table), (ranks, 3))
                self.assertEqual(self.told(ranks, *table, *line), (ranks, 2))

    def test_in_the_scene(self):
        (self.folder / "threads.toml").write_text(CUBE.read_text() + "\n[run]\nthreads = 2\n")
        told = self.run_well(1, "threads.toml", "--dry-run").stdout
        self.assertIn("1 rank x 2 threads, ", told)

    def test_a_list_in_the_environment(self):
        os.environ["OMP_NUM_THREADS"] = " 3,2"
        self.assertEqual(self.told(1), (1, 3))
        os.environ["OMP_NUM_THREADS"] = ""
        self.assertLessEqual(self.told(1)[1], CORES)

    def test_more_than_there_are_cores_are_allowed(self):
        self.assertEqual(self.told(1, "--threads", CORES + 3), (1, CORES + 3))


class Automatic(ThreadsTest):
    def test_ranks_share_the_cores_that_they_may_use(self):
        alone = self.told(1)[1]
        self.assertGreaterEqual(alone, 1)
        self.assertLessEqual(alone, CORES)
        for ranks in (2, 3):
            self.assertEqual(self.told(ranks), (ranks, max(1, alone // ranks)))  # unbound, by MPI_SETTINGS

    def test_of_one_core(self):
        everywhere = os.sched_getaffinity(0)
        self.addCleanup(os.sched_setaffinity, 0, everywhere)
        os.sched_setaffinity(0, {min(everywhere)})
        self.assertEqual(self.told(1), (1, 1))

    def test_openmp_that_binds_the_first_thread(self):
        alone = self.told(1)
        os.environ["OMP_PROC_BIND"] = "close"
        self.assertEqual(self.told(1), alone)

    def test_a_rank_that_mpirun_binds_to_one_core(self):
        command = [self.mpirun, "-np", "1", "--bind-to", "core", self.trevi, CUBE, "--dry-run"]
        result = subprocess.run(command, cwd=self.folder, env={**os.environ, **MPI_SETTINGS}, capture_output=True,
                                text=True, timeout=TIME_LIMIT, check=False)
        if result.returncode != 0 and "bind" in result.stderr:
            self.skipTest("mpirun cannot bind here")
        self.assertIn("1 rank x 1 thread, ", result.stdout, result.stderr)


class Results(ThreadsTest):
    def test_the_same_bits(self):
        checkpoints = []
        for ranks, threads in ((1, 1), (1, 3), (2, 2)):
            output = self.folder / f"on_{ranks}_{threads}"
            self.run_well(ranks, CUBE, "--output", output, "--steps", 22, "--threads", threads)  # it lands in frame 20
            checkpoints.append((output / "checkpoint_000022.h5").read_bytes())
        self.assertTrue(checkpoints[0] == checkpoints[1] == checkpoints[2])


class Refused(ThreadsTest):
    def refused(self, said, *arguments, rank_counts=(1,)):
        for ranks in rank_counts:
            result = self.run_trevi(ranks, CUBE, "--output", "none", *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertEqual(len(re.findall(said, result.stderr)), 1, result.stderr)
            self.assertFalse((self.folder / "none").exists())

    def test_on_the_command_line(self):
        said = r"--threads: must be a whole number from 1 to 1024\n"
        for number in ("0", "-1", "1025", "1.5", "many", "99999999999999999999"):
            with self.subTest(number):
                self.refused(said, f"--threads={number}")
        self.refused(said, "--threads", 0, rank_counts=[2])

    def test_in_the_scene(self):
        for number, said in (("0", "must be at least 1, got 0"), ("1025", "must be at most 1024; leave it out"),
                             ("2.5", "must be a whole number"), ("'all'", "must be a whole number")):
            with self.subTest(number):
                self.refused(rf"run.threads={number}: {said}", "--set", f"run.threads={number}")

    def test_in_the_environment(self):
        for number, ranks in (("0", 1), ("many", 1), ("1025", 2)):
            with self.subTest(number):
                os.environ["OMP_NUM_THREADS"] = number
                self.refused(rf"trevi: OMP_NUM_THREADS={number}: must be a whole number from 1 to 1024; unset it",
                             rank_counts=[ranks])
                self.assertEqual(self.told(ranks, "--threads", 2), (ranks, 2))  # nobody asks for it


if __name__ == "__main__":
    main()

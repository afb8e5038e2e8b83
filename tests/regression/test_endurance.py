#!/usr/bin/python3
"""Many restarts of one run, many ranks on few cores, and a run of hours: the same bits, and the same memory.

A class for each subject. jobs/faults.sh runs them at full length by the environment: TREVI_RESTARTS, how many (default
6), TREVI_RANKS, how many (default 12), TREVI_SECONDS, simulated ones (default 300). How the program is found: runs.py.
"""

import os
import random
import re
import unittest
from pathlib import Path

import runs
from runs import CHECKPOINTS, FLOW, FRAMES, JET, Folder
from scenes import tank

RESTARTS, RANKS, SECONDS = (int(os.environ.get(f"TREVI_{name}", default))
                            for name, default in (("RESTARTS", 6), ("RANKS", 12), ("SECONDS", 300)))
# All that has a state of its own: two inlets, one of which recycles, a drain, and a fountain's random numbers.
RESTARTED = FLOW + JET
# A plane of cells for each rank.
LONG = tank("{length}, 0.4, 0.6", ("0, 0, 0", "{length}, 0.4, 0.3", "velocity = [1.0, 0.0, 0.0]"),
            domain='slab_axis = "x"') + """
[output.series]
every_steps = 1
[output.checkpoint]
every_steps = 4
[output.vtkhdf]
every_steps = 4
"""
SMALL = tank("0.8, 0.6, 1.2", ("0, 0, 0", "0.8, 0.6, 0.3"), end="{seconds}.0") + """
[viscosity]
c = 0.001
[[fountain]]
center = [0.4, 0.3]
diameter = 0.25
height = 0.2
speed = 3.0
jitter = 1.0
[output.series]
every = 1.0
[output.checkpoint]
every = 10.0
[output.vtkhdf]
every = 10.0
"""
if "VTK" not in runs.WITHOUT:
    SMALL += "[output.vtu]\nevery = 10.0\n"


class Restarts(unittest.TestCase):
    def test_a_step_at_a_time_on_any_ranks(self):
        with Folder() as folder:
            scene = folder.scene(RESTARTED + FRAMES + CHECKPOINTS.format(1, 2))
            straight, parted = folder.path("straight"), folder.path("parted")
            runs.run_well(1, scene, straight, "--steps", RESTARTS + 1)
            generator, tried = random.Random(1), [0] * 6
            runs.run_well(1, scene, parted, "--steps", 1)
            for step in range(2, RESTARTS + 2):
                ranks = generator.choice((1, 1, 2, 2, 3, 4, 5))
                tried[ranks] += 1
                runs.run_well(ranks, scene, parted, "--steps", step, "--restart", "latest")
            self.assertEqual(runs.differences(straight, parted), [])
        print(f"{RESTARTS} restarts: {', '.join(f'{n} on {k} ranks' for k, n in enumerate(tried) if n)}: the same bits")


class ManyRanks(unittest.TestCase):
    def test_more_than_cores(self):
        with Folder() as folder:
            scene = folder.scene(LONG.format(length=0.2 * RANKS))
            one, many = folder.path("one"), folder.path("many")
            runs.run_well(1, scene, one, "--steps", 8)
            runs.run_well(RANKS, scene, many, "--steps", 4)
            runs.run_well(RANKS, scene, many, "--steps", 8, "--restart", "latest")
            self.assertEqual(runs.differences(one, many), [])


class Hours(unittest.TestCase):
    def test_memory_stays(self):
        with Folder() as folder:
            output = folder.path("out")
            run = runs.start(1, folder.scene(SMALL.format(seconds=SECONDS)), output)

            def resident():  # kB
                return int(re.search(r"VmRSS:\s*(\d+)", Path(f"/proc/{run.pid}/status").read_text())[1])
            seen = {}
            for share in (1 / 120, 1 / 5, 1 / 2, 0.9):  # of two hours: after a minute, an hour, at the end
                second = max(60, int(share * SECONDS))
                runs.wait_for_row(output, second, run)
                seen[second] = resident()
            code, told = runs.finish(run)
            self.assertEqual(code, 0, told)
            self.assertEqual(runs.column(output, "time")[-1], SECONDS)
            print(f"{SECONDS} s simulated; resident, kB, after so many seconds: {seen}")
            first = seen[60]
            self.assertLess(max(abs(kept / first - 1) for kept in seen.values()), 0.01, seen)


if __name__ == "__main__":
    unittest.main()

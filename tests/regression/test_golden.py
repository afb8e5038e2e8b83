#!/usr/bin/python3
"""Results have the bits that golden.txt says, on any number of ranks and threads and on every instruction set with a
fused multiply-add that this machine has: particles of the last checkpoint, and series.csv but for times.

After a change that is meant to change results TREVI_WRITE_GOLDEN=1 makes it write golden.txt anew; the commit says why.
TREVI_GOLDEN_CASES names the runs to do in place of all, TREVI_GOLDEN_SHAPES their ranks x threads: "1x2 5x1", where
"3*2x1" are 3 slabs of 2 ranks each.

TREVI_GOLDEN_RESTARTS=1 makes it run all cases, and scenes that have no hash, in every one of these shapes (default: a
wide choice), each run parted: steps 1 to 30 in a shape, steps 31 to 60 from the checkpoint in the shape after it. That
takes hours on two cores, so ctest does not:
    TREVI_GOLDEN_RESTARTS=1 tests/regression/test_golden.py build/release/trevi mpirun Golden.test_restarts
"""

import hashlib
import itertools
import os
import re
import tempfile
import unittest
from pathlib import Path

import h5py
from program import INPUTS, WITHOUT, ProgramTest, main
from runs import last_checkpoint, rows
from scenes import tank

GOLDEN = Path(__file__).with_name("golden.txt")
CASES = os.environ.get("TREVI_GOLDEN_CASES", "").split()
ALL_SHAPES = "1x1 1x2 1x4 2x1 2x4 3x1 3x2 5x1 5x2 2x2"  # the last for all cases, the others for "everything"
ONE_SET = "TREVI_GOLDEN_ONE_SET" in os.environ  # the best alone

def shapes_of(text):
    """Slabs, ranks of each and threads of each rank."""
    shapes = []
    for shape in text.split():
        ranks, threads = shape.split("x")
        slabs, _, parts = ranks.partition("*")
        shapes.append((int(slabs), int(parts or 1), int(threads)))
    return shapes


SHAPES = shapes_of(os.environ.get("TREVI_GOLDEN_SHAPES", ALL_SHAPES))
NAMED_SHAPES = "TREVI_GOLDEN_SHAPES" in os.environ
CUT_SHAPES = shapes_of("" if NAMED_SHAPES else "1*2x1 2*4x1 3*2x1 2*2x2")  # as ALL_SHAPES
# Of runs that change their shape half-way, in this order.
RESTARTED = shapes_of(os.environ.get("TREVI_GOLDEN_SHAPES", "1x1 2x1 1*2x1 2*2x1 3*2x1 4*4x1 8*2x1 "
                                     "1x2 2x2 1*2x2 2*2x2 3*2x2 4*4x2 8*2x2"))
LONG_SCENES = "channel_weir", "floating_bodies", "wave_tank"  # what the small ones have not: openings, bodies, paddles
SPOIL = "TREVI_SPOIL_SCRATCH"  # fills the memory that stages share with what is not a number
ROUNDED = {"SSE2", "SSSE3", "SSE4"}  # without a fused multiply-add: to rounding only

# Everything that a scene may have, and enough of it that all of it acts: jets through a pool, drops that meet walls.
EVERYTHING = tank("1.6, 0.8, 2.0", ("0, 0, 0", "1.6, 0.8, 0.5"),
                  ("0.2, 0.2, 1.0", "0.6, 0.6, 1.4", "velocity = [1, 0.3, 0]")) + """
[walls]
floor_friction = 0.02
[tensile]
[vorticity]
[viscosity]
[[fountain]]
center = [1.0, 0.4]
diameter = 0.3
height = 0.3
speed = 5.0
jitter = 2.0
{music}
[colour]
by = "rainbow_x"
[output.series]
every_steps = 1
[output.checkpoint]
every_steps = 30
"""
# The same in two dimensions, with obstacles that move, an inlet and a drain.
EVERYTHING_IN_PLANE = """
[domain]
dimensions = 2
min = [0, 0]
max = [1.6, 2.0]
[fluid]
spacing = 0.05
[[particles]]
min = [0, 0]
max = [1.6, 0.5]
[[particles]]
min = [0.2, 1.0]
max = [0.6, 1.4]
velocity = [1, 0.3]
[time]
dt = 0.016666666666666667
end = 1.0
[gravity]
[walls]
floor_friction = 0.02
[tensile]
[vorticity]
[viscosity]
nu = 1e-4
no_slip = true
[[obstacle]]
type = "cylinder"
center = [0.8, 0.45]
radius = 0.13
angular_velocity = [0, 3, 0]
[[obstacle]]
type = "box"
center = [1.3, 0.3]
size = [0.2, 0.3]
rotate = [0, 30, 0]
friction = 0.1
motion = { type = "sine", amplitude = [0.1, 0.02], period = 0.7 }
[[fountain]]
center = [0.3, 0]
diameter = 0.2
height = 0.3
speed = 4.0
jitter = 1.0
[[inlet]]
center = [0.1, 1.6]
radius = 0.1
direction = [1, 0.2]
speed = 2.0
jitter = 0.5
[[drain]]
min = [1.5, 0]
max = [1.6, 0.1]
[[gauge]]
type = "pressure"
center = [0, 0.2]
normal = [1, 0]
[[gauge]]
type = "height"
center = [0.5, 0]
[[gauge]]
type = "velocity"
center = [0.5, 0.3]
[output.series]
every_steps = 1
[output.checkpoint]
every_steps = 30
"""
# Two jets that meet in a box that repeats along both axes, without gravity.
PERIODIC_PLANE = """
[domain]
dimensions = 2
min = [0, 0]
max = [2.0, 1.6]
periodic = ["x", "z"]
[fluid]
spacing = 0.05
[[particles]]
min = [0.2, 0.4]
max = [0.9, 1.0]
velocity = [4, 1]
[[particles]]
min = [1.1, 0.4]
max = [1.8, 1.1]
velocity = [-4, 0]
[[obstacle]]
type = "cylinder"
center = [1.0, 1.2]
radius = 0.15
[time]
dt = 0.005
end = 1.0
[output.series]
[output.checkpoint]
"""
MUSIC = 'music = "ode.txt"\nspeed_range = [3.0, 6.0]'
SCORE = "0 C4 0.2\n0.2 E4 0.2\n0.3 G4 0.3\n"


def digest(folder):
    """Hash of what two runs with the same bits have in common."""
    state = hashlib.sha256()
    with h5py.File(last_checkpoint(folder)) as file:
        for name in ("id", "position", "velocity"):
            state.update(file["particles"][name][()].tobytes())
    for row in rows(folder)[1:]:
        state.update(",".join(row).encode())
    return state.hexdigest()[:16]


def cases(folder):
    """Name, scene, overrides of each run."""
    for scene in sorted(INPUTS.glob("*_small.toml")):
        needs = [part for part, word in (("MUSIC", "\nmusic"), ("VTK", ".ply")) if word in scene.read_text()]
        if not set(needs) & set(WITHOUT):
            yield scene.stem, scene, []
    for name, text in (("everything_in_plane", EVERYTHING_IN_PLANE), ("periodic_plane", PERIODIC_PLANE)):
        (folder / f"{name}.toml").write_text(text)
        for precision in ("single", "double"):
            yield f"{name}_{precision}", folder / f"{name}.toml", [f"density.precision='{precision}'"]
    if "MUSIC" in WITHOUT:
        return
    everything = folder / "everything.toml"
    everything.write_text(EVERYTHING.format(music=MUSIC))
    (folder / "ode.txt").write_text(SCORE)
    for precision in ("single", "double"):
        for method in ("jacobi", "chebyshev"):
            yield (f"everything_{precision}_{method}", everything,
                   [f"density.precision='{precision}'", f"density.method='{method}'"])


class Golden(ProgramTest):
    def setUp(self):
        super().setUp()
        self.trevi = self.program  # each run names its instruction set itself

    def run_to(self, step, case, instruction_set, shape, out, *more):
        _, scene, overrides = case
        slabs, parts, threads = shape
        sets = [*overrides, f"run.instruction_set='{instruction_set}'", "output.series.every_steps=1",
                "output.checkpoint.every_steps=1000000"]
        if parts > 1:
            sets.append(f"domain.ranks=[{slabs}, {parts}]")
        self.run_well(slabs * parts, scene, "--steps", step, "--output", out, "--threads", threads, *more,
                      *(f"--set={o}" for o in sets))

    def hash_of(self, case, instruction_set, shape):
        with tempfile.TemporaryDirectory() as out:
            self.run_to(60, case, instruction_set, shape, f"{out}/run")
            return digest(Path(out) / "run")

    def hash_of_parted(self, case, instruction_set, shapes):
        with tempfile.TemporaryDirectory() as out:
            self.run_to(30, case, instruction_set, shapes[0], f"{out}/run")
            self.run_to(60, case, instruction_set, shapes[1], f"{out}/run", "--restart", "latest")
            return digest(Path(out) / "run")

    def fits(self, case, shape):
        """Whether there are planes and rows of cells enough. In two dimensions there is one row."""
        slabs, parts, _ = shape
        refused = self.run_trevi(slabs * parts, case[1], "--dry-run", f"--set=domain.ranks=[{slabs}, {parts}]")
        if refused.returncode != 0:
            self.assertRegex(refused.stderr, "cell planes along the slab axis, fewer|rows of cells, fewer")
        return refused.returncode == 0

    def instruction_sets(self):
        """Those with a fused multiply-add, the best first, as the refusal of another one names them."""
        refused = self.run_trevi(1, INPUTS / "falling_cube_small.toml", "--dry-run", "--set=run.instruction_set='none'")
        names = re.search(r"this run has \(([^)]*)\)", refused.stderr)[1].split(", ")
        return [name for name in names if name not in ROUNDED][:1 if ONE_SET else None]

    @staticmethod
    def runs_of(number, name, sets):
        """(set, shape): scenes in the last shape on each set; "everything" on the best set in each shape, or, if no shapes
        are named, in a part of them, so that its cases together meet all of them; and on another set in a quarter of
        them, which differs among its cases. So each set has met each shape."""
        has_rows = "plane" not in name  # of cells across a scene of two dimensions there is one
        shapes, cut = (SHAPES, CUT_SHAPES) if has_rows else ([shape for shape in SHAPES if shape[1] == 1], [])
        if not name.startswith("everything"):
            return [*itertools.product(sets, shapes[-1:]), *itertools.product(sets[:1], cut[-1:])]
        own = [*shapes, *cut]
        if not NAMED_SHAPES:
            own = own[number % 4::4] if has_rows else own[number % 2::2]
        rest = shapes[number % 4::4] or shapes[-1:]
        return [*itertools.product(sets[:1], own), *itertools.product(sets[1:], rest)]

    def test_bits(self):
        golden = dict(line.split() for line in GOLDEN.read_text().splitlines() if not line.startswith("#"))
        sets = self.instruction_sets()
        if not sets:
            self.skipTest("no instruction set of this machine has a fused multiply-add")
        self.assertLessEqual(set(CASES), set(golden), "TREVI_GOLDEN_CASES")
        for number, case in enumerate(case for case in cases(self.folder) if not CASES or case[0] in CASES):
            for run, (instruction_set, shape) in enumerate(self.runs_of(number, case[0], sets)):
                os.environ.pop(SPOIL, None)  # every other run, so that memory with other values is no other result
                os.environ.update({SPOIL: "1"} if run % 2 == 1 else {})
                with self.subTest(case[0], instruction_set=instruction_set, shape=shape):
                    found = self.hash_of(case, instruction_set, shape)
                    verdict = "as" if found == golden[case[0]] else "NOT as"
                    slabs, parts, threads = shape
                    print(f"{case[0]}, {instruction_set}, {slabs} * {parts} x {threads}: {found}, {verdict} in "
                          "golden.txt", flush=True)
                    self.assertEqual(found, golden[case[0]])

    @unittest.skipUnless(os.environ.get("TREVI_GOLDEN_RESTARTS"), "takes hours")
    def test_restarts(self):
        golden = dict(line.split() for line in GOLDEN.read_text().splitlines() if not line.startswith("#"))
        best = self.instruction_sets()[0]
        all_cases = [*cases(self.folder), *((name, INPUTS / f"{name}.toml", []) for name in LONG_SCENES)]
        for case in (case for case in all_cases if not CASES or case[0] in CASES):
            expected = golden.get(case[0]) or self.hash_of(case, best, (1, 1, 1))
            fitting = {shape[:2]: self.fits(case, shape) for shape in RESTARTED}
            shapes = [shape for shape in RESTARTED if fitting[shape[:2]]]
            for k, shape in enumerate(shapes):
                after = shapes[(k + 1) % len(shapes)]
                with self.subTest(case[0], shapes=(shape, after)):
                    found = self.hash_of_parted(case, best, (shape, after))
                    told = " then ".join("{} * {} x {}".format(*one) for one in (shape, after))
                    print(f"{case[0]}, {best}, {told}: {found}, {'as' if found == expected else 'NOT as'} "
                          f"{'in golden.txt' if case[0] in golden else 'on one rank'}", flush=True)
                    self.assertEqual(found, expected)

    @unittest.skipUnless(os.environ.get("TREVI_WRITE_GOLDEN"), "only after a change that is meant to change results")
    def test_write(self):
        best = self.instruction_sets()[0]
        lines = [f"{case[0]} {self.hash_of(case, best, (1, 1, 1))}" for case in cases(self.folder)]
        GOLDEN.write_text("# Hashes of small runs after 60 steps; test_golden.py says of what.\n" + "\n".join(lines) + "\n")


if __name__ == "__main__":
    main()

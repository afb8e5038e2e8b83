#!/usr/bin/python3
"""The program as a user runs it: the same results on any rank count and across a restart, nothing overwritten, nothing
touched by a dry run, and a profile that names the phases of the method."""

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from program import INPUTS, MPI_SETTINGS, TIME_LIMIT, ProgramTest, main

sys.path.append(str(Path(__file__).resolve().parents[2] / "postprocess"))
import study  # noqa: E402

CUBE, FOUNTAIN = INPUTS / "falling_cube_small.toml", INPUTS / "fountain_small.toml"
BASIN, COLUMN = INPUTS / "bench_rest.toml", INPUTS / "stress" / "column.toml"


def rows(run):
    """The rows of series.csv without what may depend on ranks and machine."""
    with open(run / "series.csv", newline="") as file:
        return [{key: value for key, value in row.items() if key not in ("imbalance", "wall_seconds")}
                for row in csv.DictReader(file)]


class SameResults(ProgramTest):
    def run_to(self, name, ranks, scene, steps, *more):
        self.run_well(ranks, scene, "--output", name, "--steps", steps, *more)
        return self.folder / name

    def assert_same(self, run, reference, step):
        name = f"checkpoint_{step:06d}.h5"
        self.assertTrue((run / name).read_bytes() == (reference / name).read_bytes(), f"{run.name}: {name} differs")
        self.assertEqual(rows(run), rows(reference))
        self.assertEqual([int(row["step"]) for row in rows(run)], list(range(step + 1)))

    def on_any_rank_count(self, scene, steps, *more, rank_counts=(2, 3, 5)):
        alone = self.run_to("alone", 1, scene, steps, *more)
        for ranks in rank_counts:
            with self.subTest(ranks=ranks):
                self.assert_same(self.run_to(f"on_{ranks}", ranks, scene, steps, *more), alone, steps)

    def test_falling_cube(self):
        self.on_any_rank_count(CUBE, 24)  # it lands in frame 20

    def test_fountain(self):
        self.on_any_rank_count(FOUNTAIN, 12)

    def test_single_precision(self):
        self.on_any_rank_count(CUBE, 22, "--set", "density.precision='single'", rank_counts=[3])

    def test_report_preset(self):
        self.on_any_rank_count(CUBE, 22, "--set", "density.preset='report'", rank_counts=[2])

    def test_restart_on_another_rank_count(self):
        for scene, first, last in ((CUBE, 18, 26), (FOUNTAIN, 5, 12)):
            with self.subTest(scene.stem):
                whole = self.run_to(f"whole_{scene.stem}", 1, scene, last)
                parts = self.run_to(f"parts_{scene.stem}", 2, scene, first)
                self.run_to(parts.name, 3, scene, last, "--restart", "latest")
                self.assert_same(parts, whole, last)


class InstructionSets(ProgramTest):
    def setUp(self):
        super().setUp()
        self.trevi = self.program

    def names(self):
        """Those of this machine, as the refusal of another one lists them."""
        for ranks in (1, 2):
            refused = self.run_trevi(ranks, CUBE, "--output", "none", "--set", "run.instruction_set=MMX")
            self.assertEqual(refused.returncode, 2, refused.stderr)
            listed = re.findall(r"^trevi: --set run.instruction_set=MMX: must be .*\((.*)\), got .MMX.; give", refused.stderr,
                                re.MULTILINE)
            self.assertEqual(len(listed), 1, refused.stderr)
        return listed[0].split(", ")

    def test_each_can_be_named_and_none_changes_a_free_fall(self):
        steps = 18  # it lands in frame 20
        heights = []
        for name in self.names():
            text = CUBE.read_text() + f"\n[run]\ninstruction_set = '{name}'\n"
            (self.folder / f"{name}.toml").write_text(text)
            self.run_well(2, f"{name}.toml", "--output", name, "--steps", steps)
            report = json.loads((self.folder / name / "run.json").read_text())
            self.assertEqual(report["instruction_set"], name)
            heights.append(float(rows(self.folder / name)[-1]["com_z"]))
        self.assertLess(max(heights) - min(heights), 1e-6)


class Outputs(ProgramTest):
    def test_run_json_tells_how_it_ended(self):
        self.run_well(2, CUBE, "--output", "run", "--steps", 2)
        report = json.loads((self.folder / "run" / "run.json").read_text())
        self.assertRegex(report["versions"]["mpi"], r"^[^\n\t,]+$")  # not how it was built
        self.assertIn("done", json.dumps(report))

    def test_missed_tolerances_are_told(self):
        for name, tolerance in (("strict", 1e-9), ("loose", 0.5)):
            result = self.run_well(2, CUBE, "--output", name, "--steps", 22, "--set", f"density.tolerance={tolerance}")
            missed = json.loads((self.folder / name / "run.json").read_text())["unconverged_solves"]
            self.assertEqual(missed > 0, name == "strict")  # it lands in frame 20, and in free fall all is well
            self.assertEqual(f"{missed} of 22 density solves missed density.tolerance" in result.stderr, missed > 0)

    def test_energy_that_rose_is_told(self):
        # Five layers of water at rest: with two sweeps and no coarse grid they fall in and spring up
        # again, 2 % above where they were.
        shallow = ["--set", "particles.0.max=[1.0,1.0,0.5]", "--set", "domain.max=[1.0,1.0,1.0]", "--set",
                   f"time.dt={1 / 120!r}"]
        springy = ["--set", "density.coarse_grid=false", "--set", "density.iterations=2"]
        for ranks, settings in ((1, springy), (2, springy), (2, [])):
            run = f"run_{ranks}_{len(settings)}"
            result = self.run_well(ranks, COLUMN, "--output", run, *shallow, *settings)
            report = json.loads((self.folder / run / "run.json").read_text())
            gain = study.energy_gain(study.columns_of(self.folder / run / "series.csv"))
            self.assertLess(abs(report["energy_gain"] - gain), 0.02 * gain + 1e-9)  # the mass is the calibrated one
            self.assertEqual(gain > 0.005, settings == springy)
            told = re.findall(r"warning: the total energy rose by [\d.]+ % above .*\n", result.stderr)
            self.assertEqual(len(told), gain > 0.005, result.stderr)
            self.assertEqual([text for text in report["warnings"] if "energy rose" in text],
                             [text[len("warning: "):-1] for text in told])

    def test_energy_is_known_with_what_pumps_and_moves_but_not_without_a_series(self):
        (self.folder / "plain.toml").write_text(COLUMN.read_text().split("[output")[0])
        small = ["--set", "particles.0.max=[1.0,1.0,0.5]", "--set", "domain.max=[1.0,1.0,1.0]"]
        (self.folder / "stirred.toml").write_text(CUBE.read_text() + "\n[[obstacle]]\ntype = 'sphere'\nradius = 0.2\n"
                                                  "center = [0.5, 0.5, 0.3]\nvelocity = [1, 0, 0]\n")
        for scene, settings in ((FOUNTAIN, []), ("plain.toml", small), ("stirred.toml", [])):
            run = self.folder / f"run_{scene if isinstance(scene, str) else scene.stem}"
            self.run_well(2, scene, "--output", run, "--steps", 3, *settings)
            gain = json.loads((run / "run.json").read_text())["energy_gain"]
            if scene == "plain.toml":
                self.assertIsNone(gain)
            else:
                self.assertLess(gain, 0.005)
                rows = study.columns_of(run / "series.csv")
                self.assertGreater(abs(rows["supplied_energy"][-1]), 0)

    def test_time_of_a_pair_is_that_of_the_passes_made(self):
        # Without rows and frames, whose passes for the density alone have fewer operations.
        (self.folder / "plain.toml").write_text(CUBE.read_text().split("[output")[0])
        self.run_well(2, "plain.toml", "--output", "run", "--steps", 3)
        report = json.loads((self.folder / "run" / "run.json").read_text())
        phases = {phase["name"]: phase for phase in report["phases"]}
        seconds = 2 * sum(phases[name]["seconds"]["mean"] for name in ("Lambda", "Delta"))
        passes = phases["Lambda"]["flops"] / 27 + phases["Delta"]["flops"] / 24  # DensityConstraint: of a pair
        self.assertAlmostEqual(report["nanoseconds_per_pair"] / (1e9 * seconds / passes), 1, 6)

    def test_forces_are_means_between_rows(self):
        """Also where the run was interrupted between two rows."""
        scene = self.folder / "gauged.toml"
        scene.write_text((INPUTS / "dam_break_obstacle_small.toml").read_text() +
                         '[[gauge]]\ntype = "pressure"\ncenter = [0.3, 0.5, 0.0]\nnormal = [0, 0, 1]\n')

        def numbers(folder, name):
            with open(self.folder / folder / name, newline="") as file:
                return [[float(value) for value in row] for row in list(csv.reader(file))[1:]]

        def run(folder, every, *more):
            self.run_well(2, scene, "--output", folder, "--set", f"output.series.every_steps={every}", *more)

        run("each", 1, "--steps", 40)
        run("tenth", 10, "--steps", 40)
        run("halved", 10, "--steps", 25, "--set", "output.checkpoint.every_steps=25")
        run("halved", 10, "--steps", 40, "--set", "output.checkpoint.every_steps=25", "--restart", "latest")
        for name in ("obstacles.csv", "gauges.csv"):
            each, tenth = numbers("each", name), numbers("tenth", name)
            self.assertEqual([row[0] for row in tenth], [0, 10, 20, 30, 40])
            columns = range(2, len(tenth[0])) if name == "obstacles.csv" else [
                k for k, title in enumerate((self.folder / "tenth" / name).read_text().splitlines()[0].split(","))
                if title.startswith("pressure")]
            self.assertTrue(columns)
            for row in tenth[1:]:
                for column in columns:
                    mean = sum(one[column] for one in each if row[0] - 10 < one[0] <= row[0]) / 10
                    self.assertAlmostEqual(row[column], mean, delta=1e-9 * (1 + abs(mean)))
            self.assertEqual(numbers("halved", name), tenth)

    def test_second_run_into_the_same_folder_is_refused(self):
        self.run_well(1, CUBE, "--output", "run", "--steps", 1)
        before = self.contents()
        for ranks in (1, 2):
            result = self.run_trevi(ranks, CUBE, "--output", "run", "--steps", 1)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("run", result.stderr)
            self.assertEqual(self.contents(), before)

    def test_dry_run_touches_nothing(self):
        for ranks in (1, 3):
            result = self.run_well(ranks, CUBE, "--dry-run")
            self.assertIn("3072", result.stdout.replace(",", ""))
            self.assertEqual(self.contents(), {})
        result = self.run_well(4, CUBE, "--dry-run", "--set", "domain.ranks=[2, 2]")
        self.assertRegex(result.stdout, r"rank 3 +planes \d+ to \d+, rows \d+ to \d+:")
        self.assertRegex(result.stdout, r"slabs .* 2 for each of 2 slabs")
        shared = re.search(r"halos +(\S+) [kM]B and (\d+) messages a substep", result.stdout).groups()
        result = self.run_well(4, CUBE, "--dry-run", "--set", "domain.ranks=auto")
        slabs, parts = map(int, re.search(r"ranks = \[(\d+), (\d+)\] by the model", result.stdout).groups())
        self.assertEqual(slabs * parts, 4)
        result = self.run_well(4, CUBE, "--dry-run")
        alone = re.search(r"halos +(\S+) [kM]B and (\d+) messages a substep", result.stdout).groups()
        self.assertGreater(int(shared[1]), int(alone[1]))

    def test_dry_run_draws_the_scene(self):
        water, stone, arrow, drain = (0.25, 0.55, 0.95), (0.62, 0.58, 0.54), (0.95, 0.5, 0.1), (0.8, 0.15, 0.3)

        def shades(*settings, ranks=1):
            self.run_well(ranks, CUBE, "--dry-run", "--picture", "scene.png", *settings)
            pixels = plt.imread(self.folder / "scene.png")[..., :3].reshape(-1, 3)
            return pixels[pixels.min(axis=1) < 0.97]

        def seen(pixels, colour, opacity):
            """Pixels with a shade of a colour laid over white."""
            shade = (pixels - (1 - opacity)) / opacity / np.array(colour)
            return int(((shade.max(axis=1) - shade.min(axis=1) < 0.03) & (shade.min(axis=1) > 0.4)).sum())

        plain = shades()
        self.assertGreater(seen(plain, water, 0.55), 10000)
        self.assertTrue(np.array_equal(plain, shades(ranks=3)), "a picture that is there is replaced")
        things = ('obstacle=[{type="sphere",center=[0.3,0.3,0.3],radius=0.25}]', 'inlet=[{center=[1.0,0.4,1.5],radius=0.2,speed=1}]',
                  'drain=[{type="box",min=[0.7,0,0],max=[1.2,0.5,0.2]}]')
        settings = [word for thing in things for word in ("--set", thing)]
        rich = shades(*settings)
        for colour, opacity in ((stone, 1), (arrow, 1), (drain, 0.35)):
            self.assertEqual(seen(plain, colour, opacity), 0)
            self.assertGreater(seen(rich, colour, opacity), 500)
        (self.folder / "mine.png").write_text("precious")
        for name, word in (("scene.jpg", ".png"), ("mine.png", "no picture"), ("nowhere/scene.png", "nowhere")):
            result = self.run_trevi(2, CUBE, "--dry-run", "--picture", name)
            self.assertEqual(result.returncode, 2)
            self.assertEqual(result.stdout, "")
            self.assertIn(word, result.stderr)
        self.assertEqual((self.folder / "mine.png").read_text(), "precious")
        self.assertEqual(self.run_trevi(1, CUBE, "--picture", "scene.png").returncode, 2)
        many = self.run_trevi(1, CUBE, "--dry-run", "--picture", "scene.png", "--set", "fluid.spacing=0.001",
                              "--set", "fluid.kernel_radius=0.002")
        self.assertIn("too many for a picture", many.stderr)

    def test_dry_run_tells_what_obstacles_take(self):
        block = ["--set", "particles.0.min=[0,0,0]", "--set", "particles.0.max=[1,1,0.5]", "--set", "domain.min=[0,0,0]",
                 "--set", "domain.max=[2,1,1]", "--set", "fluid.spacing=0.1"]
        ball = 'obstacle=[{type="box",center=[0.5,0.5,0.25],size=[0.4,0.4,0.7]},' \
               '{type="cylinder",center=[1,0.5,0.5],radius=2,height=1,inside=true}]'
        told = self.run_well(1, CUBE, "--dry-run", *block, "--set", ball).stdout
        self.assertIn("left out    80 of 500 places of the blocks", told)
        self.assertIn("obstacle 0  from (0.3, 0.3, -0.1) to (0.7, 0.7, 0.6) m, reaches out of the box", told)
        self.assertIn("a vessel: solid all around it, also above z = 1", told)

    def test_dry_run_knows_the_cfl_number_of_the_run(self):
        for cfl, told in ((2, "CFL 2: "), (0.5, "CFL 0.5: 0.0155 s"), (0, "CFL 0.4: 0.0124 s")):
            result = self.run_well(1, CUBE, "--dry-run", "--set", f"time.cfl={cfl}")
            self.assertIn(told, result.stdout)
            self.assertEqual("steps are split" in result.stdout, cfl > 0)

    def test_dry_run_knows_the_memory_of_the_run(self):
        for ranks, settings in ((1, []), (2, ["--set", "vorticity.epsilon=0.002", "--set", "viscosity.c=0.001"])):
            told = self.run_well(ranks, BASIN, "--dry-run", *settings).stdout
            megabytes = sum(float(number) for number in re.findall(r"ghosts .* ([\d.]+) MB", told))
            self.run_well(ranks, BASIN, "--output", f"on_{ranks}", "--steps", 5, *settings)
            report = json.loads((self.folder / f"on_{ranks}" / "run.json").read_text())
            used = report["bytes_per_particle"] * report["particles"] / 1e6
            # Told is what disordered water needs, whose lists are longer than those of this lattice at rest.
            self.assertGreater(megabytes / used, 0.97, f"{megabytes} MB told, {used} MB used")
            self.assertLess(megabytes / used, 1.1, f"{megabytes} MB told, {used} MB used")

    def test_dry_run_of_a_scene_too_large_for_the_machine(self):
        depth = ["--set", "particles.0.max=[6.0, 4.0, 12000.0]", "--set", "domain.max=[6.0, 4.0, 12000.0]"]
        self.assertIn("288000000 ", self.run_well(1, BASIN, "--dry-run", *depth).stdout)  # 85 GB
        result = self.run_trevi(1, BASIN, "--dry-run", *[word.replace("12000.0", "120000.0") for word in depth])
        self.assertEqual(result.returncode, 2)
        self.assertIn("use more ranks", result.stderr)

    def test_version_and_the_scene_behind_an_override(self):
        self.assertRegex(self.run_well(2, "--version").stdout, r"^trevi \d+\.\d+\.\d+\n$")
        told = self.run_well(1, "--set", "fluid.spacing=0.05", "--set", "time.dt=0.005", CUBE, "--dry-run").stdout
        self.assertNotEqual(told, self.run_well(1, CUBE, "--dry-run").stdout)

    def test_help_tells_limits_and_formats(self):
        told = " ".join(self.run_well(1, "--help").stdout.split())
        for words in ("inputs/README.md", "at least one kernel radius wide (two spacings)", "two dimensions",
                      '"time pitch length"', "/particles/position (N x 3), velocity (N x 3) and id (N)",
                      "default twice the spacing"):
            self.assertIn(words, told)

    def test_a_method_without_the_same_bits_says_so_at_the_start(self):
        for ranks in (1, 2):
            told = self.run_well(ranks, CUBE, "--output", f"run{ranks}", "--steps", 1, "--set", "density.method=anderson")
            self.assertEqual(told.stderr.count('density.method = "anderson" are PETSc\'s'), 1, told.stderr)
            warnings = json.loads((self.folder / f"run{ranks}/run.json").read_text())["warnings"]
            self.assertEqual(sum("not in bits" in warning and "anderson" in warning for warning in warnings), 1)

    def test_lost_output_is_told(self):
        with open("/dev/full", "w") as full:
            for arguments in ([CUBE, "--dry-run"], ["--help"]):
                result = subprocess.run([self.trevi, *arguments], cwd=self.folder, stdout=full, stderr=subprocess.PIPE,
                                        env={**os.environ, **MPI_SETTINGS}, text=True, timeout=TIME_LIMIT, check=False)
                self.assertEqual(result.returncode, 3, result.stderr)
                self.assertRegex(result.stderr, "^trevi: standard output: cannot write: .*\n$")

    def test_slips_among_the_options_of_petsc_are_told(self):
        told = self.run_well(2, CUBE, "--output", "run", "--steps", 1, "-log_veiw", "-log_view").stderr
        warnings = [line for line in told.splitlines() if "warning" in line and "fused multiply-add" not in line]
        self.assertEqual(len(warnings), 1, told)
        self.assertIn("-log_veiw was not used", warnings[0])
        refused = self.run_trevi(1, CUBE, "-np", 4)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("mpirun -np", refused.stderr)


class Profile(ProgramTest):
    def events(self, *overrides):
        """Name -> (calls, flops) of the lines of -log_view, largest over ranks; and the whole text."""
        settings = [word for override in overrides for word in ("--set", override)]
        text = self.run_well(2, CUBE, "--output", f"run_{len(overrides)}", "--steps", 3, *settings, "-log_view").stdout
        lines = re.findall(r"^(\w+) +(\d+) [\d.]+ [\d.e+-]+ +[\d.]+ ([\d.e+-]+) ", text, re.MULTILINE)
        return {name: (int(calls), float(flops)) for name, calls, flops in lines}, text

    def test_log_view_reads_as_a_profile_of_the_method(self):
        # A block in flight, which is not compressed: an inequality would have no shifts.
        events, text = self.events("density.iterations=5", "density.method='jacobi'", "density.coarse_grid=false",
                                   "density.constraint='equality'")
        self.assertRegex(text, r"\d: +Solve:")
        for name in ("Lambda", "Delta", "Vorticity", "XsphViscosity", "NeighbourSearch"):
            self.assertIn(name, events)
        self.assertGreaterEqual(events["Delta"][0], 12)  # the coarse grid and four sweeps in each of three steps
        for name in ("Lambda", "Delta", "Vorticity", "XsphViscosity"):
            self.assertGreater(events[name][1], 1e5, f"no flops are logged for {name}")

    def test_what_a_scene_does_not_name_has_no_line(self):
        text = CUBE.read_text()
        for table in ("vorticity", "viscosity"):
            text = re.sub(rf"\[{table}\][^\[]*", "", text)
        (self.folder / "plain.toml").write_text(text)
        result = self.run_well(2, "plain.toml", "--output", "run", "--steps", 2, "-log_view")
        self.assertIn("Lambda", result.stdout)
        for name in ("Vorticity", "Xsph", "Fountain"):
            self.assertNotIn(name, result.stdout)

    def test_a_profile_that_only_the_run_finds_bad(self):
        """It is no number in one substep of two thousand, between the times that are looked at before."""
        scene = ("[domain]\nmin = [0, 0, 0]\nmax = [2, 1, 1]\n[fluid]\nspacing = 0.1\n[time]\ndt = 0.01\nend = 20\n[gravity]\n"
                 "[[inlet]]\ntype = 'rectangle'\n"
                 "center = [0.05, 0.5, 0.25]\nsize = [0.4, 0.4]\ndirection = [1, 0, 0]\n"
                 "profile = 'abs(t - 0.01) < 1e-9 ? 0/0 : 0.1'\n")
        (self.folder / "scene.toml").write_text(scene)
        for ranks in (1, 2):
            result = self.run_trevi(ranks, "scene.toml", "--steps", "4", "--output", f"on {ranks}", folder=self.folder)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertEqual(result.stderr.count("scene.toml:15: [[inlet]] profile: "), 1, result.stderr)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Restarts: the same bits on another rank count, what a user keeps in the folder, and what may have changed since.

Small scenes with the real program (runs.py says how it is found). A class for each subject, to be named:
    tests/regression/test_restart.py SceneChanges
"""

import os
import re
import shutil
import subprocess
import unittest

import h5py
import runs
from runs import BOX, CHECKPOINTS, CUBE, FLOW, FOUNTAIN, FRAMES, MUSIC, SCORE, Folder


def set_to(settings):
    """Arguments of the program."""
    return [word for setting in settings for word in ("--set", setting)]


class Restart(unittest.TestCase):
    def same_bits(self, text, *settings):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        folder.scene(SCORE, "score.txt")
        scene = folder.scene(text + FRAMES + CHECKPOINTS.format(30, 2))
        straight, parted = folder.path("straight"), folder.path("parted")
        runs.run_well(1, scene, straight, "--steps", 60, *settings)
        # Ranks that share slabs first, where there are rows of cells to share, then slabs.
        shared = set_to(["domain.ranks=[2, 2]"]) if "domain.dimensions=2" not in settings else []
        runs.run_well(4 if shared else 2, scene, parted, "--steps", 30, *settings, *shared)
        runs.run_well(3, scene, parted, "--steps", 60, "--restart", "latest", *settings)
        self.assertEqual(runs.differences(straight, parted), [])
        self.assertEqual(len(runs.rows(parted)), 62)
        seconds = runs.column(parted, "wall_seconds")
        self.assertEqual(seconds, sorted(seconds))
        return parted

    def test_cube(self):
        self.same_bits(CUBE)

    @unittest.skipIf("MUSIC" in runs.WITHOUT, "this build plays no music")
    def test_musical_fountain(self):
        parted = self.same_bits(FOUNTAIN + MUSIC)
        self.assertGreater(len(set(runs.column(parted, "speed_0"))), 3)

    def test_inlets_and_drain(self):
        parted = self.same_bits(FLOW)
        inflow, outflow, waiting, there = (runs.column(parted, name) for name in ("inflow", "outflow", "waiting", "particles"))
        self.assertGreater(inflow[-1] - inflow[30], 50)
        self.assertEqual([n - i + o for n, i, o in zip(there, inflow, outflow)], [there[0]] * len(there))
        self.assertGreater(max(waiting), 0)

    def test_openings_in_walls(self):
        parted = self.same_bits("""drain = [{min = [0.8, 0, 0], max = [1.6, 0.6, 1.4], flow = 0.2}]
""" + BOX.format(low=0.0, high=1.6, height=0.0, top=0.6) + """
[[inlet]]
type = "rectangle"
center = [0.05, 0.3, 0.3]
size = [0.4, 0.6]
direction = [1, 0, 0]
profile = "0.4 + z * min(1, t)"
level = 0.62
""")
        self.assertGreater(min(runs.column(parted, name)[-1] for name in ("inflow", "outflow")), 50)

    def test_periodic_tank(self):
        """Deep water around a ring in both directions, with an inlet and a drain in it."""
        tank = BOX.format(low=0.0, high=1.6, height=0.0, top=0.6) + """
[[inlet]]
center = [0.8, 0.7, 1.0]
direction = [0.2, 0, -1]
radius = 0.1
speed = 2
[[drain]]
min = [1.0, 0.4, 0]
max = [1.3, 0.9, 0.15]
"""
        wider = ("domain.periodic=['x', 'y']", "domain.max=[1.6, 1.4, 1.4]", "particles.0.max=[1.6, 1.4, 0.6]")
        parted = self.same_bits(tank, *set_to(wider))
        self.assertGreater(runs.column(parted, "outflow")[-1], 50)

    def test_cells_are_counted_from_where_they_were(self):
        """The particle of the least id starts in the third cell along x, and is elsewhere when the run goes on."""
        ring = BOX.format(low=0.4, high=1.3, height=0.0, top=0.8)
        parted = self.same_bits(ring, *set_to(("domain.periodic=['x', 'y']", "domain.max=[1.6, 0.6, 1.4]")))
        for path in parted.glob("checkpoint_*.h5"):
            with h5py.File(path) as file:
                self.assertEqual(list(file["first_cell"]), [2, 0, 0])
                self.assertNotEqual(int(file["particles/position"][0][0] / 0.2), 2)

    def test_tank_that_overflows(self):
        full = ("particles.0.min=[0, 0, 0]", "particles.0.max=[0.8, 0.6, 0.6]", "inlet.0.flow=0.2")
        parted = self.same_bits((runs.ROOT / "tests/solver/weir.toml").read_text(), *set_to(full))
        inflow, outflow, there = (runs.column(parted, name) for name in ("inflow", "outflow", "particles"))
        self.assertGreater(outflow[-1] - outflow[30], 20)
        self.assertEqual([n - i + o for n, i, o in zip(there, inflow, outflow)], [there[0]] * len(there))

    def test_obstacles_beside_the_frames(self):
        """The list names each frame with the surfaces of its time, and a restart leaves the same list and the same files."""
        obstacles = """
[[obstacle]]
type = "torus"
center = [0.8, 0.3, 0.9]
radius = 0.2
tube = 0.05
motion = [[0, 0.8, 0.3, 0.9], [0.5, 0.8, 0.3, 0.6], [1, 0.9, 0.3, 0.9]]
[[obstacle]]
type = "sphere"
center = [0.4, 0.3, 0.3]
radius = 0.1
[[gauge]]
type = "height"
center = [0.7, 0.3, 0.05]
[[gauge]]
type = "pressure"
center = [0.4, 0.3, 0.4]
normal = [0, 0, 1]
radius = 0.1
"""
        parted = self.same_bits(CUBE + obstacles)
        straight = parted.parent / "straight"
        steps = sorted(int(file.stem.split("_")[1]) for file in parted.glob("obstacles_*.vtp"))
        self.assertEqual(steps, sorted(int(file.stem.split("_")[1]) for file in parted.glob("particles_*.hdf")))
        self.assertEqual(len({file.read_bytes() for file in parted.glob("obstacles_*.vtp")}), len(steps), "it moves")
        for name in ("obstacles.csv", "gauges.csv"):
            self.assertEqual((parted / name).read_bytes(), (straight / name).read_bytes(), name)
            self.assertEqual(len((parted / name).read_text().splitlines()), 62, name)
        lists = ["obstacles.vtp.series", *(["particles.pvd"] if "[output.vtu]" in FRAMES else [])]
        for name in [*lists, "obstacles.vtp", *(file.name for file in parted.glob("obstacles_*.vtp"))]:
            self.assertEqual((parted / name).read_bytes(), (straight / name).read_bytes(), name)
        if "[output.vtu]" in FRAMES:
            listed = re.findall(r'part="(\d)" file="([^"]*)"', (parted / "particles.pvd").read_text())
            self.assertEqual([part for part, _ in listed], ["0", "1", "2"] * len(steps))
            for _, file in listed:
                self.assertTrue((parted / file).exists(), file)

    def test_single_precision_with_substeps(self):
        self.same_bits(CUBE, "--set", "density.precision=single", "--set", "time.cfl=0.1")

    def test_two_dimensions(self):
        """A slice of what flows, beside a wheel that turns."""
        wheel = 'obstacle=[{type="cylinder",center=[0.7,0.3],radius=0.12,angular_velocity=[0,3,0]}]'
        self.same_bits(FLOW, *set_to(("domain.dimensions=2", "fluid.spacing=0.05", wheel)))

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

    @unittest.skipIf("VTK" in runs.WITHOUT, "the copies are of VTU files")
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

    def test_a_damaged_checkpoint_is_passed_over(self):
        folder = Folder()
        self.addCleanup(folder.cleanup)
        scene = folder.scene(CUBE + CHECKPOINTS.format(10, 3))
        straight, output = folder.path("straight"), folder.path("out")
        runs.run_well(1, scene, straight, "--steps", 40)
        runs.run_well(1, scene, output, "--steps", 30)
        newest, older = (output / f"checkpoint_0000{step}.h5" for step in (30, 20))
        newest.write_bytes(newest.read_bytes()[:-1000])
        damaged = newest.read_bytes()
        told = runs.run_well(2, scene, output, "--steps", 40, "--restart", "latest")
        self.assertIn(f"goes on from {older}, step 20", told)
        self.assertRegex(told, f"passed over, .*{newest}: damaged or cut short")
        self.assertEqual((output / "checkpoint_000030.h5.stale").read_bytes(), damaged)
        self.assertEqual(runs.differences(straight, output), [])
        for path in output.glob("checkpoint_*.h5"):
            path.write_bytes(b"")
        code, told = runs.run(2, scene, output, "--steps", 50, "--restart", "latest")
        self.assertEqual(code, 2, told)
        self.assertIn("no good checkpoint", told)
        self.assertEqual(told.count("not an HDF5 file"), 3)


    def test_only_damage_is_passed_over(self):
        """What keeps a good checkpoint from being read is told, and nothing is set aside."""
        folder = Folder()
        self.addCleanup(folder.cleanup)
        scene, output = folder.scene(CUBE + CHECKPOINTS.format(10, 3)), folder.path("out")
        runs.run_well(1, scene, output, "--steps", 30)
        newest = output / "checkpoint_000030.h5"
        good = newest.read_bytes()
        def refuse(words, limit="unlimited"):
            before = sorted(output.iterdir())
            command = runs.command(1, scene, output, "--steps", 40, "--restart", "latest")
            run = subprocess.run(["bash", "-c", f'ulimit -v {limit}; exec "$@"', "limited", *command], capture_output=True,
                                 text=True, env=runs.environment(), timeout=runs.TIMEOUT, check=False)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertRegex(run.stderr, f"checkpoint_000030.h5: {words}")
            self.assertEqual(sorted(output.iterdir()), before)
        newest.unlink()
        newest.symlink_to(newest.name)  # permissions do not hold for root
        refuse("cannot read: Too many levels of symbolic links")
        newest.unlink()
        os.mkfifo(newest)
        refuse("not an HDF5 file, nor any other with data")
        newest.unlink()
        newest.write_bytes(good)
        with h5py.File(newest, "r+") as file:
            file.attrs["format"] = 2
        refuse(r"attribute format: 2, but only 1 is known here; restart with trevi \d\.\d\.\d, which wrote it")
        with h5py.File(newest, "r+") as file:
            file.attrs["format"] = 1
            del file["particles/position"]
            rows = file.create_dataset("particles/position", (400_000_000, 3), float, chunks=(500_000, 3))
            rows[:500_000] = 0.5
        refuse("/particles/position: 400000000 rows need 9.6 GB, and .* are free here", 8_000_000)


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

    @unittest.skipIf("MUSIC" in runs.WITHOUT, "this build plays no music")
    def test_music_under_its_old_name(self):
        scene, output = self.folder.scene(FOUNTAIN + MUSIC + CHECKPOINTS.format(10, 2)), self.folder.path("music")
        self.folder.scene(SCORE, "score.txt")
        runs.run_well(2, scene, output, "--steps", 10)
        self.folder.scene(SCORE.replace("E4", "F4"), "score.txt")
        code, told = runs.run(2, scene, output, "--restart", "latest", "--steps", 12)
        self.assertEqual(code, 2, told)
        self.assertIn("score.txt: fountain.0.music: not what the run has had so far", told)
        os.rename(self.folder.path("score.txt"), self.folder.path("new.txt"))
        runs.run_well(1, scene, output, "--restart", "latest", "--steps", 12, "--set", "fountain.0.music=new.txt")

    def test_obstacles(self):
        """Their keys go by the rules of all keys, their files by that of music; water does not end up in stone."""
        mesh = "[[obstacle]]\ntype = 'mesh'\npath = 'ball.obj'\n" if "VTK" not in runs.WITHOUT else ""
        ball = "[[obstacle]]\ntype = 'sphere'\ncenter = [1.5, 0.5, 1.5]\nradius = 0.05\nmotion = 'way.csv'\n"
        text = self.text + ball + mesh
        way, corners = self.folder.path("way.csv"), self.folder.path("ball.obj")
        way.write_text("0, 1.5, 0.5, 1.5\n2, 1.5, 0.5, 1.4\n")
        def tetrahedron(size):
            corners.write_text(f"v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        tetrahedron(0.05)
        output = self.folder.path("obstacles")
        runs.run_well(2, self.folder.scene(text), output, "--steps", 10)
        def restart(*settings):
            folder = self.folder.path("again")
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(output, folder)
            with (folder / "series.csv").open("a") as file:
                file.write("11,rows past the checkpoint\n")
            return runs.run(2, self.folder.scene(text), folder, "--restart", "latest", "--steps", 12, *set_to(settings))
        def answers(words, settings, expected):
            code, told = restart(*settings)
            self.assertEqual(code, expected, told)
            self.assertIn(words, told)
        def past():
            return "rows past" in (self.folder.path("again") / "series.csv").read_text()
        def refuse(words, *settings):
            answers(words, settings, 2)
            self.assertTrue(past(), "a refused restart has cut the series")
        def allow(words, *settings):
            answers(words, settings, 0)
            self.assertFalse(past())
        allow("obstacle.0.radius: 0.05 -> 0.06", "obstacle.0.radius=0.06")
        allow("obstacle.0.motion: 'way.csv' -> [[0, 1.5, 0.5, 1.5], [1, 1.5, 0.5, 1.4]]",
              "obstacle.0.motion=[[0, 1.5, 0.5, 1.5], [1, 1.5, 0.5, 1.4]]")
        refuse("would be in obstacle 0, which has changed", "obstacle.0.radius=0.15",
               "obstacle.0.motion=[[0, 0.8, 0.3, 0.8], [1, 0.8, 0.3, 0.7]]")
        refuse("its columns are not those", "obstacle.2.type=sphere", "obstacle.2.center=[1.5,0.1,1.5]", "obstacle.2.radius=0.05")
        shutil.copyfile(way, self.folder.path("other.csv"))
        with way.open("a") as file:
            file.write("3, 1.5, 0.5, 1.3\n")
        refuse("way.csv: obstacle.0.motion: not what the run has had so far; put the file back")
        allow("obstacle.0.motion: 'way.csv' -> 'other.csv'", "obstacle.0.motion=other.csv")
        shutil.copyfile(self.folder.path("other.csv"), way)
        if mesh:
            allow("obstacle.1.scale: (absent) -> 1.5", "obstacle.1.scale=1.5")
            tetrahedron(0.04)
            refuse("ball.obj: obstacle.1.path: not what the run has had so far; put the file back")
            shutil.copyfile(corners, self.folder.path("small.obj"))
            allow("obstacle.1.path: 'ball.obj' -> 'small.obj'", "obstacle.1.path=small.obj")

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

    def test_mass_of_the_particles_never(self):
        volume = self.text.replace("spacing = 0.1", 'spacing = 0.1\nmass = "volume"')
        output = self.folder.path("volume")
        runs.run_well(1, self.folder.scene(volume), output, "--steps", 10)
        for text, folder, settings, words in (
                (self.text, self.output, ["fluid.spacing=0.09"], "fluid.spacing: 0.1 -> 0.09; the particles of the checkpoint"),
                (self.text, self.output, ["fluid.rest_density=900.0"], "fluid.rest_density: (absent) -> 900; it would change the mass"),
                (self.text, self.output, ["domain.dimensions=2"], "the particles of the checkpoint are not those of another space"),
                (self.text, self.output, ["fluid.mass=volume"], "it would change the mass"),
                (self.text, self.output, ["density.preset=report"], "it would change the mass"),
                (self.text, self.output, ["fluid.kernel_radius=0.21"], "it would change the density of the water"),
                (self.text, self.output, ["fluid.density_kernel=poly6"], "it would change the density of the water"),
                (volume, output, ["fluid.kernel_radius=0.25"], "it would change the density of the water")):
            more = [word for setting in settings for word in ("--set", setting)]
            code, told = runs.run(1, self.folder.scene(text), folder, "--restart", "latest", "--steps", 12, *more)
            self.assertEqual(code, 2, told)
            self.assertIn(words, told)

    def test_length_of_a_step_never(self):
        code, told = self.restart(self.text, "--set", "time.dt=0.01")
        self.assertEqual(code, 2, told)
        self.assertIn("--set time.dt=0.01", told)


if __name__ == "__main__":
    unittest.main()

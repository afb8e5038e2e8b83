#!/usr/bin/python3
"""The Python module as its users have it: scripts under mpirun, the bits of the program, errors on all ranks alike."""

import re
from pathlib import Path

import h5py
import numpy as np
from program import INPUTS, main
from python_module import TANK, ModuleTest

ROOT = Path(__file__).resolve().parents[2]
SCENE = INPUTS / "fountain_small.toml"


class Module(ModuleTest):
    def test_ten_lines_give_the_bits_of_the_program(self):
        script = """
            import sys, numpy as np, trevi
            scene = trevi.read_scene(sys.argv[1], {"time.end": 0.5, "output.series.every_steps": 10})
            solver = trevi.make_solver(scene)
            solver.run()
            positions = solver.gather_positions()
            if solver.rank == 0:
                np.save("positions.npy", positions)
                print(*(solver.series[name][-1] for name in ("step", "kinetic_energy", "supplied_energy")))
        """
        self.run_well(1, SCENE, "--output", "run", "--set", "time.end=0.5")
        with h5py.File(self.folder / "run/checkpoint_000030.h5") as file:
            expected = file["particles/position"][:][np.argsort(file["particles/id"][:])]
        told = set()
        for ranks in (1, 2, 3):
            told.add(self.run_fine(ranks, script, SCENE))
            self.assertTrue((np.load(self.folder / "positions.npy") == expected).all())
        self.assertEqual(len(told), 1, told)
        last = [line for line in (self.folder / "run/series.csv").read_text().splitlines()][-1].split(",")
        self.assertEqual(float(told.pop().split()[1]), float(last[12]), "kinetic_energy")

    def test_a_callable_forcing_keeps_momentum(self):
        script = TANK, """
            # Pairs of ids are pushed apart: nothing in all.
            def swirl(water, step):
                sign = np.where(water.ids % 2 == 0, 1.0, -1.0)
                water.velocities[:, 1] += 0.3 * step.dt * sign
            free = lattice[(abs(lattice - [1, 0.5, 0.25]) < [0.6, 0.2, 0.25]).all(axis=1)] + [0, 0, 0.5]
            mine = free[trevi.rank::trevi.size]
            solver = trevi.make_solver(settings, mine, forcings=[swirl], rows=1)
            solver.run(steps=20)
            rows = solver.series
            if solver.rank == 0:
                print(rows["kinetic_energy"][-1], max(abs(rows["momentum_" + axis]).max() for axis in "xyz"))
        """
        for ranks in (1, 3):
            energy, momentum = map(float, self.run_fine(ranks, script).split())
            self.assertGreater(energy, 0.1)
            self.assertLess(momentum, 1e-9)

    def test_an_exception_in_a_forcing_of_one_rank_ends_all(self):
        script = TANK, """
            def wind(water, step):
                if step.step == 1 and 0 in water.ids:
                    raise ValueError("the wind has dropped")
            first = trevi.rank == 0
            solver = trevi.make_solver(settings, lattice if first else lattice[:0], forcings=[wind])
            try:
                solver.run(steps=5)
            except trevi.RunError as error:
                assert "the wind has dropped" in str(error)
                sys.stdout.write(f"ended after {solver.steps}\\n")
        """
        for ranks in (1, 3):
            self.assertEqual(self.run_fine(ranks, script), "ended after 1\n" * ranks)

    def test_arrays_are_views(self):
        script = TANK, """
            settings.gravity = [0, 0, -9.81]
            solver = trevi.make_solver(settings, lattice)
            before = solver.positions
            assert before.ctypes.data == solver.positions.ctypes.data and not before.flags.owndata
            for array in (solver.positions, solver.velocities, solver.ids):
                try:
                    array[0] = 1
                except ValueError:
                    continue
                raise SystemExit("an array can be written to")
            try:
                solver.positions = lattice
            except trevi.InputError:
                pass
            with solver.change():
                solver.velocities[:] = [0.5, 0, 0]
            assert (solver.velocities == [0.5, 0, 0]).all()
            with solver.change():
                solver.positions = np.vstack([solver.positions, [[1, 0.5, 1.2]]])
                solver.velocities = np.vstack([solver.velocities, [[0, 0, -1]]])
                solver.ids = np.append(solver.ids, 1000)
            assert len(solver.ids) == 1001
            solver.step()
            try:
                with solver.change():
                    solver.ids[:] = 7
                    raise KeyError("no")
            except KeyError:
                pass
            assert len(set(solver.ids)) == 1001
            print(solver.gather_velocities()[1000])
        """
        told = self.run_fine(1, script)
        self.assertRegex(told, r"-1\.16")

    def test_numpy_keeps_its_denormals(self):
        script = TANK, """
            import warnings
            warnings.simplefilter("error")
            tiny = np.full(100000, np.finfo(float).tiny)
            def ok():
                return (tiny / 8 * 8 == tiny).all() and np.finfo(float).smallest_subnormal > 0
            seen = [ok()]
            trevi.use_threads(2)
            settings.gravity = [0, 0, -9.81]
            solver = trevi.make_solver(settings, lattice, forcings=[lambda water, step: seen.append(ok())])
            seen.append(ok())
            solver.step()
            with solver.change():
                solver.velocities[:] = tiny[0] / 8
            seen.append(ok())
            assert len(seen) > 3 and all(seen), seen
            solver.step()
            solver.close()
            assert ok()
        """
        self.run_fine(1, script)

    def test_errors_are_those_of_the_program_on_all_ranks(self):
        script = TANK, """
            def told(kind, work):
                try:
                    work()
                except kind as error:
                    return str(error)
                return "nothing"
            all = [told(trevi.InputError, lambda: trevi.read_scene(sys.argv[1], {"fluid.spacing": -1, "time.dt": "x"})),
                   told(ValueError, lambda: trevi.read_scene("nowhere.toml")),
                   told(trevi.InputError, lambda: trevi.make_solver(settings, lattice[:, :2])),
                   told(trevi.InputError, lambda: trevi.make_solver(settings, lattice + [5, 0, 0])),
                   told(trevi.InputError, lambda: trevi.make_solver(settings, lattice, ids=np.zeros(1000, int))),
                   told(AttributeError, lambda: setattr(settings.fluid, "spcing", 0.2)),
                   told(trevi.InputError, lambda: trevi.use_threads(0))]
            settings.dt = -1
            all.append(told(trevi.InputError, lambda: trevi.make_solver(settings, lattice)))
            sys.stdout.write(" | ".join(one.replace("\\n", " ") for one in all) + "\\n")
        """
        for ranks in (1, 2):
            lines = self.run_fine(ranks, script, SCENE).splitlines()
            self.assertEqual(len(lines), ranks)
            for line, words in zip(lines[0].split(" | "), ("fluid.spacing=-1: must be positive", "nowhere.toml", "(n, 3)", "outside the box",
                                                           "particle 0 is there twice", "no setting spcing", "0 threads", "dt")):
                self.assertIn(words, line)

    def test_settings_are_changed_in_place(self):
        script = TANK, """
            settings.gravity = [0, 0, -9.81]
            settings.domain.max[2] = 2.5
            assert list(settings.domain.max) == [2, 1, 2.5]
            ball = trevi.ObstacleSettings()
            ball.shape, ball.center, ball.radius = trevi.Shape.sphere, [1, 0.5, 0.3], 0.2
            settings.obstacles.append(ball)
            settings.obstacles[0].center[0] = 0.9
            assert settings.obstacles[0].center[0] == 0.9 and len(settings.obstacles) == 1
            gauge = trevi.GaugeSettings()
            gauge.kind, gauge.center, gauge.radius = trevi.GaugeKind.height, [1.6, 0.5, 0], 0.2
            settings.gauges.append(gauge)
            free = np.linalg.norm(lattice - [0.9, 0.5, 0.3], axis=1) > 0.25
            solver = trevi.make_solver(settings, lattice[free], rows=5)
            seen = []
            solver.run(until=1, callback=lambda one: seen.append(one.time))
            assert len(seen) == solver.steps == 60
            one = solver.obstacles[0]
            assert np.allclose(one["center"], [0.9, 0.5, 0.3]) and np.allclose(one["rotation"], np.eye(3))
            assert len(solver.gauges["height_0"]) == len(solver.forces["force_z_0"]) == 13
            print(one["force"][2], solver.gauges["height_0"][-1])
        """
        force, height = map(float, self.run_fine(1, script).split())
        self.assertAlmostEqual(force, 1000 * 9.81 * 4 / 3 * np.pi * 0.2**3, delta=0.35 * 330, msg="Archimedes, of a coarse ball")
        self.assertAlmostEqual(height, 0.49, delta=0.05)

    def test_the_page_runs(self):
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / "python/README.md").read_text(), re.DOTALL)
        self.assertEqual(len(blocks), 2)
        text = "\n".join(blocks).replace('"inputs/', f'"{INPUTS}/').replace('"time.end": 2', '"time.end": 0.4')
        for ranks in (1, 2):
            self.run_fine(ranks, text.replace("out/by_hand", f"out/by_hand_{ranks}"))
            self.assertTrue((self.folder / f"out/by_hand_{ranks}/particles.hdf.series").exists())

    def test_what_a_scene_says_can_be_filled_by_hand(self):
        script = """
            import sys, numpy as np, trevi
            settings = trevi.Settings()
            settings.domain.max = [1.6, 0.8, 1.6]
            settings.dt = 0.0166666667
            settings.gravity = [0, 0, -9.8]
            fountain = trevi.FountainSettings()
            fountain.center, fountain.diameter, fountain.height = (0.4, 0.4), 0.3, 0.4
            fountain.direction, fountain.speed, fountain.jitter = [1, 0, 3], 2, 0.5
            settings.fountains.append(fountain)
            inlet = trevi.InletSettings()
            inlet.center, inlet.direction, inlet.radius, inlet.flow = [1.0, 0.4, 1.4], [1, 0.2, -0.5], 0.15, 0.1
            settings.inlets.append(inlet)
            drain = trevi.DrainSettings()
            drain.min, drain.max = [1.2, 0, 0], [1.6, 0.8, 0.1]
            settings.drains.append(drain)
            settings.seed = 12
            settings.output.series = trevi.Schedule(every_steps=5)
            settings.output.checkpoint = trevi.CheckpointSettings(keep=1)
            cells = trevi.FrameSetSettings(trevi.Schedule(every_steps=10), trevi.FrameContent.cells)
            corner = trevi.FrameSetSettings(trevi.Schedule(every_steps=30))
            box = trevi.Box()
            box.max = [0.8, 0.4, 0.4]
            corner.name, corner.one_in, corner.box = "corner", 2, box
            corner.precision, corner.fields = trevi.Precision.single, ["id"]
            settings.output.frames = [cells, corner]
            if len(sys.argv) > 1:
                settings.output.directory = sys.argv[1]
            k, j, i = np.meshgrid(range(5), range(8), range(16), indexing="ij")
            lattice = 0.1 * (np.stack([i, j, k], -1).reshape(-1, 3) + 0.5)
            mine = slice(trevi.rank, None, trevi.size)
            solver = trevi.make_solver(settings, lattice[mine], ids=np.arange(640)[mine])
            solver.run(steps=30)
            positions = solver.gather_positions()
            if solver.rank == 0:
                np.save("positions.npy", positions)
                print(len(solver.series["inflow"]), solver.series["inflow"][-1], solver.series["outflow"][-1])
        """
        self.run_well(2, ROOT / "tests/embed/fountain.toml", "--output", "run")
        with h5py.File(self.folder / "run/checkpoint_000030.h5") as file:
            expected = file["particles/position"][:]  # in the order of the ids
        for ranks, folder in ((1, ()), (2, ("by_hand",))):
            rows, inflow, outflow = map(float, self.run_fine(ranks, script, *folder).split())
            self.assertTrue((np.load(self.folder / "positions.npy") == expected).all())
            self.assertTrue(rows == 7 and inflow > 0 and outflow > 0)
            self.assertEqual((self.folder / "by_hand").exists(), bool(folder))
        with h5py.File(self.folder / "by_hand/checkpoint_000030.h5") as file:
            self.assertTrue((file["particles/position"][:] == expected).all())
        self.assertTrue((self.folder / "by_hand/frames_0/cells_000030.hdf").exists())
        with h5py.File(self.folder / "by_hand/frames_corner/particles_000030.hdf") as file:
            corner = file["VTKHDF/Points"][:]
        self.assertTrue(0 < len(corner) < 640 and (corner <= [0.8, 0.4, 0.4]).all())
        self.assertEqual(len((self.folder / "by_hand/series.csv").read_text().splitlines()), 8)

    def test_a_communicator_of_mpi4py_is_a_solver_of_its_own(self):
        script = """
            from mpi4py import MPI
            import numpy as np, sys, trevi
            own = MPI.COMM_WORLD.Split(MPI.COMM_WORLD.rank, 0)
            scene = trevi.read_scene(sys.argv[1], {"time.end": 0.1, "fountain.0.speed": 4 + MPI.COMM_WORLD.rank}, own)
            solver = trevi.make_solver(scene, comm=own)
            solver.run()
            assert solver.size == 1 and len(solver.ids) == 3072
            speeds = MPI.COMM_WORLD.gather(float(abs(solver.velocities).max()))
            if MPI.COMM_WORLD.rank == 0:
                print(*speeds)
        """
        slow, fast = map(float, self.run_fine(2, script, SCENE).split())
        self.assertGreater(fast, slow)


if __name__ == "__main__":
    main()

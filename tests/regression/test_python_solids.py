#!/usr/bin/python3
"""Bodies, paddles, damping zones and probes in Python: the numbers of the program; and that each setting has a name there."""

import re
import shutil
from pathlib import Path

import h5py
import numpy as np
from program import INPUTS, main
from python_module import ModuleTest
from scenes import tank

INCLUDE = Path(__file__).resolve().parents[2] / "include/trevi"
# Members that Python has by another name (`mesh`, `motion`) or that nobody fills.
OTHERWISE = {"ObstacleSettings": {"path", "scale", "knots", "extruded"}}
UNBOUND = {"SpeedProfile", "ObstacleKnot", "BodyState"}

BODIES = tank("1.6, 0.8, 1.2", ("0, 0, 0", "1.6, 0.8, 0.5"), end="0.25") + """
[[obstacle]]
type = "sphere"
center = [0.4, 0.4, 0.1]
radius = 0.2
[[body]]
type = "box"
center = [1.0, 0.4, 0.6]
size = [0.5, 0.4, 0.3]
rotate = [0, 8, 0]
density = 300
free = ["x", "z", "pitch"]
[[body]]
type = "mesh"
path = "duck.ply"
translate = [0.4, 0.4, 0.7]
scale = 0.7
mass = 8
mooring = { anchor = [0.4, 0.4, 0.1], stiffness = 300, damping = 5, length = 0.3, slack = true }
[output.series]
every_steps = 5
[output.checkpoint]
every = 9
"""
BODIES_BY_HAND = """
    import sys, numpy as np, trevi
    settings = trevi.Settings()
    settings.domain.max = [1.6, 0.8, 1.2]
    settings.dt = 0.016666666666666667
    settings.gravity = [0, 0, -9.8]
    ball = trevi.ObstacleSettings()
    ball.center, ball.radius = [0.4, 0.4, 0.1], 0.2
    settings.obstacles.append(ball)
    raft = trevi.BodySettings()
    raft.shape, raft.center, raft.size, raft.rotate = trevi.Shape.box, [1.0, 0.4, 0.6], [0.5, 0.4, 0.3], [0, 8, 0]
    raft.density, raft.free = 300, ["x", "z", "pitch"]
    assert raft.free == ["x", "z", "pitch"]
    duck = trevi.BodySettings()
    duck.shape, duck.center, duck.mesh = trevi.Shape.mesh, [0.4, 0.4, 0.7], trevi.read_mesh("duck.ply", 0.7)
    duck.mass = 8
    line = trevi.Mooring()
    line.anchor, line.stiffness, line.damping, line.length, line.slack = [0.4, 0.4, 0.1], 300, 5, 0.3, True
    duck.mooring = line
    settings.bodies.extend([raft, duck])
    with np.load("start.npz") as start:
        ids, positions = start["ids"], start["positions"]
    mine = slice(trevi.rank, None, trevi.size)
    solver = trevi.make_solver(settings, positions[mine], ids=ids[mine], rows=5)
    solver.run(steps=15)
    now = solver.bodies
    assert len(now) == 2 and len(solver.obstacles) == 1 and solver.obstacles[0]["force"][2] != 0
    for k, body in enumerate(now):
        assert all((body["position"][a] == solver.body_rows["xyz"[a] + f"_{k}"][-1]) for a in range(3))
        assert np.allclose(body["rotation"].T @ body["rotation"], np.eye(3)) and body["force"].shape == (3,)
        assert body["velocity"].shape == body["angular_velocity"].shape == (3,) and body["orientation"].shape == (4,)
    try:
        raft.free = ["x", "heave"]
    except trevi.InputError as error:
        assert "heave" in str(error)
    gathered = solver.gather_positions()
    if solver.rank == 0:
        np.savez("by_hand.npz", positions=gathered, forces=solver.forces["force_z_0"], **solver.body_rows)
"""
WAVES = tank("4.0, 0.4, 1.0", ("0, 0, 0", "4.0, 0.4, 0.6"), end="0.5") + """
[[wavemaker]]
type = "piston"
height = 0.1
period = 1.2
ramp = 0.3
position = 0.5
depth = 0.6
absorb = true
[[damping]]
min = [3.0, 0, 0]
max = [4.0, 0.4, 1.0]
rate = 4
[[gauge]]
type = "height"
center = [1.5, 0.2, 0]
radius = 0.2
[[gauge]]
type = "velocity"
center = [1.5, 0.2, 0.3]
radius = 0.2
[[gauge]]
type = "pressure"
center = [1.5, 0.2, 0.3]
[output.series]
every_steps = 10
[output.gauges]
every_steps = 2
[output.checkpoint]
every = 9
"""
WAVES_BY_HAND = """
    import sys, numpy as np, trevi
    settings = trevi.Settings()
    settings.domain.max = [4.0, 0.4, 1.0]
    settings.dt = 0.016666666666666667
    settings.gravity = [0, 0, -9.8]
    maker = trevi.WavemakerSettings()
    maker.height, maker.period, maker.ramp, maker.position, maker.depth, maker.absorb = 0.1, 1.2, 0.3, 0.5, 0.6, True
    settings.obstacles.append(trevi.paddle_of(maker, settings.domain))
    zone = trevi.DampingSettings()
    zone.min, zone.max, zone.rate = [3.0, 0, 0], [4.0, 0.4, 1.0], 4
    settings.dampings.append(zone)
    height, velocity, pressure = (trevi.GaugeSettings() for _ in range(3))
    height.kind, height.center, height.radius = trevi.GaugeKind.height, [1.5, 0.2, 0], 0.2
    velocity.kind, velocity.center, velocity.radius = trevi.GaugeKind.velocity, [1.5, 0.2, 0.3], 0.2
    pressure.kind, pressure.center = trevi.GaugeKind.pressure_in_water, [1.5, 0.2, 0.3]
    settings.gauges.extend([height, velocity, pressure])
    settings.output.directory = f"by_hand_{trevi.size}"
    settings.output.series = trevi.Schedule(every_steps=10)
    settings.output.gauges = trevi.Schedule(every_steps=2)
    with np.load("start.npz") as start:
        ids, positions = start["ids"], start["positions"]
    mine = slice(trevi.rank, None, trevi.size)
    solver = trevi.make_solver(settings, positions[mine], ids=ids[mine])
    solver.run(steps=30)
    gathered = solver.gather_positions()
    if solver.rank == 0:
        np.savez("by_hand.npz", positions=gathered)
"""


def members_of(header):
    """Of each struct of a header its data members."""
    text = re.sub(r"//.*", "", (INCLUDE / header).read_text())
    for name, body in re.findall(r"^struct (\w+)[^{;]*\{\n(.*?)^\};", text, re.MULTILINE | re.DOTALL):
        body = re.sub(r"=[^;]*", "", re.sub(r"\{[^{}]*\}", "", body))  # without functions and initial values
        members = set()
        for statement in body.split(";"):
            if "(" in statement or "operator" in statement or not statement.strip():
                continue
            *_, last = re.sub(r"<[^;]*>", "", statement).strip().split("\n")
            members |= {re.match(r"\w+", part.split()[-1])[0] for part in last.split(",") if part.split()}
        yield name, members


class Solids(ModuleTest):
    def the_start(self, run):
        """Particles of a run's start, for a script."""
        with h5py.File(self.folder / run / "checkpoint_000000.h5") as file:
            np.savez(self.folder / "start.npz", ids=file["particles/id"][:], positions=file["particles/position"][:])

    def test_bodies_have_the_numbers_of_the_program(self):
        shutil.copy(INPUTS / "gallery/duck.ply", self.folder)
        (self.folder / "bodies.toml").write_text(BODIES)
        self.run_well(2, "bodies.toml", "--output", "run")
        self.the_start("run")
        names, *rows = (self.folder / "run/bodies.csv").read_text().splitlines()
        table = dict(zip(names.split(","), np.array([row.split(",") for row in rows], float).T))
        self.assertNotEqual(table["z_0"][0], table["z_0"][-1])
        with h5py.File(self.folder / "run/checkpoint_000015.h5") as file:
            expected = file["particles/position"][:]
        for ranks in (1, 2):
            self.run_fine(ranks, BODIES_BY_HAND)
            with np.load(self.folder / "by_hand.npz") as found:
                self.assertTrue((found["positions"] == expected).all())
                self.assertEqual(set(found) - {"positions", "forces"}, set(table))
                for name, column in table.items():
                    self.assertTrue((found[name] == column).all(), name)

    def test_waves_have_the_numbers_of_the_program(self):
        (self.folder / "waves.toml").write_text(WAVES)
        self.run_well(1, "waves.toml", "--output", "run")
        self.the_start("run")
        with h5py.File(self.folder / "run/checkpoint_000030.h5") as file:
            expected = file["particles/position"][:]
        for ranks in (1, 2):
            self.run_fine(ranks, WAVES_BY_HAND)
            with np.load(self.folder / "by_hand.npz") as found:
                self.assertTrue((found["positions"] == expected).all())
            for name in ("gauges.csv", "obstacles.csv"):
                self.assertEqual((self.folder / f"by_hand_{ranks}" / name).read_text(), (self.folder / "run" / name).read_text())

    def test_the_columns_are_those_of_the_files(self):
        (self.folder / "waves.toml").write_text(WAVES)
        script = """
            import trevi
            solver = trevi.make_solver(trevi.read_scene("waves.toml", {"time.end": 0.1, "output.directory": "run"}))
            solver.run()
            for name, table in ("series", solver.series), ("obstacles", solver.forces), ("gauges", solver.gauges):
                print(name, *sorted(table))
        """
        told = self.run_fine(1, script)
        for line in told.splitlines():
            name, *columns = line.split()
            names = (self.folder / f"run/{name}.csv").read_text().splitlines()[0].split(",")
            self.assertEqual(columns, sorted(names), name)

    def test_every_setting_has_a_name(self):
        script = """
            import trevi
            for name in dir(trevi):
                print(name, *dir(getattr(trevi, name)))
        """
        bound = {name: set(attributes) for name, *attributes in map(str.split, self.run_fine(1, script).splitlines())}
        structs = [one for header in ("settings.hpp", "obstacle.hpp", "body.hpp", "wavemaker.hpp", "box.hpp")
                   for one in members_of(header)]
        self.assertGreater(len(structs), 20)
        self.assertIn("dampings", dict(structs)["Settings"])
        self.assertTrue({"level", "flow"} <= dict(structs)["DrainSettings"], "two members of one line")
        for name, members in structs:
            if name not in UNBOUND:
                self.assertEqual(members - OTHERWISE.get(name, set()) - bound[name.replace("Pump", "Fountain")], set(), name)


if __name__ == "__main__":
    main()

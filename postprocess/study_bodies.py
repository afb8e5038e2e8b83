#!/usr/bin/python3
"""Bodies that float, against what is known of them: heave of half a cylinder of water (Ito, 1977) and roll of a barge against linear
theory in the same tank, draughts of cylinders, logs that float on a side or on an edge, plates thinner than a cell, a duck, a ball of
the water's density, a light ball that is let go under water, balls that collide, moorings, free fall, the energy of what floats, and
the forces of each step on balls that are drawn through deep water or let go there.

One row for each case and quantity: what is expected, and what the run has. Theory of heave and roll is in known_floating.py.
"""

import csv
import math
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from known_floating import decay
from make_gallery import duck_distance
from study import GRAVITY, ROOT, columns_of, in_turn, largest_rise, launch, parser_of

RESULTS = Path(__file__).resolve().parent / "results"
SCENE = """
[domain]
min = [0.0, 0.0, 0.0]
max = {box}
[fluid]
spacing = {spacing}
[[particles]]
min = [0.0, 0.0, 0.0]
max = {water}
[time]
dt = {dt}
end = {end}
{gravity}
{bodies}
[output.series]
every_steps = {every}
"""


def run(trevi, *bodies, box, depth, spacing, dt, end, gravity="[gravity]", every=1, kind="body", solids=""):
    """Columns of series.csv and bodies.csv of a tank with water up to `depth` and bodies; a row every so many steps. Of the kind
    "obstacle" they stand, or go as they are told, and the columns are those of obstacles.csv. `solids`: further tables."""
    with tempfile.TemporaryDirectory() as folder:
        scene, output = Path(folder) / "scene.toml", Path(folder) / "run"
        lines = "\n".join(f"[[{kind}]]\n" + "\n".join(f"{key} = {value}" for key, value in body.items()) for body in bodies)
        scene.write_text(SCENE.format(box=list(map(float, box)), water=[*map(float, box[:2]), float(depth)], spacing=spacing, dt=dt,
                                      end=end, gravity=gravity, bodies=lines + solids, every=every), encoding="utf-8")
        code, message = launch(trevi, scene, output, (), 1800)
        if code != 0:
            raise SystemExit(f"study_bodies: {message}")
        series = columns_of(output / "series.csv")
        bodies = columns_of(output / ("bodies.csv" if kind == "body" else "obstacles.csv"))
        return {k: np.array(v) for k, v in series.items()}, {k: np.array(v) for k, v in bodies.items()}


# ---- cases: each gives rows of quantity, unit, expected, measured, and curves to draw

def heave(trevi, spacing):
    radius, depth, half = 1.0, 2.5, 10.0
    hull = [(radius * math.sin(a), -radius * math.cos(a)) for a in np.linspace(0, math.pi / 2, 31)]
    t, y, _ = decay(hull, half_length=half, depth=depth, about=None, inertia=math.pi / 2, stiffness=2 * GRAVITY, start=1 / 3,
                    seconds=4.2)
    body = {"type": '"cylinder"', "radius": radius, "height": 4 * spacing, "axis": [0.0, 1.0, 0.0],
            "center": [half, 2 * spacing, depth + radius / 3], "density": 500, "free": ["z"]}
    _, found = run(trevi, body, box=(2 * half, 4 * spacing, depth + 2), depth=depth, spacing=spacing, dt=0.01, end=4.2)
    here = (found["z_0"] - depth) * 3
    theory = np.interp(found["time"], t, y) * 3
    off = np.abs(here - theory)
    rows = [("largest difference of y from theory, of the start", "1", 0, off.max()),
            ("mean difference", "1", 0, off.mean())]
    for name, low, high, pick in (("first trough", 0.5, 1.8, np.argmin), ("first crest", 1.6, 3.0, np.argmax)):
        a, b = (t > low) & (t < high), (found["time"] > low) & (found["time"] < high)
        rows.append((name + " of y, of the start", "1", 3 * y[a][pick(y[a])], here[b][pick(here[b])]))
        rows.append(("time of it", "s", t[a][pick(y[a])], found["time"][b][pick(here[b])]))
    return rows, (found["time"] * math.sqrt(GRAVITY / radius), here, theory)


def crossings(t, y):
    at = np.flatnonzero(y[1:] * y[:-1] < 0)
    return t[at] + (t[at + 1] - t[at]) * y[at] / (y[at] - y[at + 1])


def roll(trevi, spacing):
    depth, half, angle = 2.0, 8.0, 5.0
    t, y, _ = decay([(0, -0.5), (1, -0.5), (1, 0)], half_length=half, depth=depth, about=0, inertia=5 / 12,
                    stiffness=GRAVITY * (8 / 12 - 0.25), start=angle, seconds=6)
    body = {"type": '"box"', "size": [2.0, 4 * spacing, 1.0], "center": [half, 2 * spacing, depth], "rotate": [0.0, angle, 0.0],
            "density": 500, "free": ["pitch"]}
    _, found = run(trevi, body, box=(2 * half, 4 * spacing, depth + 1.5), depth=depth, spacing=spacing, dt=0.01, end=6.0)
    turned = np.degrees(2 * np.arctan2(found["qy_0"], found["qw_0"]))
    expected, measured = crossings(t, y), crossings(found["time"], turned)
    period = lambda at: 2 * (at[4] - at[0]) / 4 if len(at) > 4 else math.nan
    a, b = (t > 1) & (t < 4), (found["time"] > 1) & (found["time"] < 4)
    return [("period, five crossings", "s", period(expected), period(measured)),
            ("angle at its second crest, of the start", "1", y[a].max() / angle, turned[b].max() / angle)
            ], (found["time"], turned, np.interp(found["time"], t, y))


def draught(trevi, density):
    radius, spacing, depth, length, width = 0.4, 0.05, 1.0, 4.0, 0.2
    body = {"type": '"cylinder"', "radius": radius, "height": width, "axis": [0.0, 1.0, 0.0], "density": density, "free": ["z"],
            "center": [length / 2, width / 2, depth + radius * (1 - 2 * density / 1000) + 0.05]}
    _, found = run(trevi, body, box=(length, width, 2.0), depth=depth, spacing=spacing, dt=1 / 60, end=15.0)
    wet = density / 1000 * math.pi * radius**2
    area = lambda d: radius**2 * math.acos(1 - d / radius) - (radius - d) * math.sqrt(2 * radius * d - d * d)
    low, high = 0.0, 2 * radius
    for _ in range(60):
        low, high = ((low + high) / 2, high) if area((low + high) / 2) < wet else (low, (low + high) / 2)
    # Particles under the body at the start have been left out: as much water as there is.
    start = body["center"][2]
    inside = max(0.0, min(2 * radius, depth - start + radius))
    level = depth + (wet - area(inside)) / length
    late = found["time"] > 10
    return [("draught less Archimedes'", "spacings", 0, (level - (found["z_0"][late].mean() - radius) - low) / spacing)], None


def neutral(trevi, spacing=0.05):
    rows = []
    for center in ([0.5, 0.5, 0.5], [0.51, 0.48, 0.52], [0.53, 0.53, 0.4]):
        body = {"type": '"sphere"', "radius": 3 * spacing, "center": center, "density": 1000}
        _, found = run(trevi, body, box=(1.0, 1.0, 1.3), depth=1.0, spacing=spacing, dt=1 / 60, end=20.0, every=5)
        off = np.sqrt(sum((found[f"{a}_0"] - x) ** 2 for a, x in zip("xyz", center)))
        rows += [(f"largest distance from {center} m in 20 s", "spacings", 0, off.max() / spacing),
                 ("fastest turn on the way", "rad/s", 0, np.linalg.norm(spin_of(found), axis=1).max())]
    return rows, None


def afloat(trevi, spacing=0.05, radius=0.15, density=500):
    """A ball that lies still at the surface."""
    body = {"type": '"sphere"', "radius": radius, "center": [0.51, 0.48, 1.0], "density": density}
    series, found = run(trevi, body, box=(1.0, 1.0, 1.3), depth=1.0, spacing=spacing, dt=1 / 60, end=30.0, every=5)
    mass = density * 4 / 3 * math.pi * radius**3
    return [("fastest turn in 30 s", "rad/s", 0, np.linalg.norm(spin_of(found), axis=1).max()),
            *rises(energy(series, found, mass, 0.4 * mass * radius**2), found["time"], 15)], None


def standing(trevi, spacing=0.05, radius=0.15):
    """The same ball where it does not float: what the water's own energy does."""
    ball = {"type": '"sphere"', "radius": radius, "center": [0.51, 0.48, 1.0]}
    series, _ = run(trevi, ball, box=(1.0, 1.0, 1.3), depth=1.0, spacing=spacing, dt=1 / 60, end=30.0, every=5, kind="obstacle")
    return rises(series["kinetic_energy"] + series["potential_energy"], series["time"], 15), None


def light(trevi, spacing=0.05):
    radius = 2.4 * spacing
    body = {"type": '"sphere"', "radius": radius, "center": [0.5, 0.5, 0.4], "density": 50}
    series, found = run(trevi, body, box=(1.0, 1.0, 2.5), depth=1.4, spacing=spacing, dt=1 / 60, end=6.0)
    rising = found["z_0"] < 1.4 - 2 * radius
    rising &= np.cumsum(~rising) == 0
    # A ball with the drag coefficient 0.5: g (1 - 0.05) 4/3 pi r^3 = 0.5/2 pi r^2 v^2.
    terminal = math.sqrt(GRAVITY * 0.95 * 16 / 3 * radius)
    return [("highest speed under water; terminal at a drag coefficient of 0.5", "m/s", terminal, found["vz_0"][rising].max()),
            ("jump of its centre above the surface", "m", math.nan, found["z_0"].max() - 1.4),
            ("fastest particle", "m/s", math.nan, max(series["speed_max"])),
            ("substeps a step", "1", 1, series["substeps"].max())], None


def fall(trevi):
    body = {"type": '"box"', "size": [0.3, 0.5, 0.2], "center": [0.6, 0.6, 4.0], "density": 500, "velocity": [0.3, 0.0, 0.0],
            "angular_velocity": [5.0, 0.5, 0.5]}
    _, found = run(trevi, body, box=(1.2, 1.2, 5.0), depth=0.1, spacing=0.1, dt=1 / 60, end=0.75)
    t = found["time"]
    off = np.hypot(found["x_0"] - 0.6 - 0.3 * t, found["z_0"] - 4 + GRAVITY / 2 * t * t)
    spin = 0.5 * 0.3 * 0.5 * 0.2 / 12 * 1000 * np.array([0.5**2 + 0.2**2, 0.3**2 + 0.2**2, 0.3**2 + 0.5**2])
    start = np.linalg.norm(spin * [5, 0.5, 0.5])
    moment = np.linalg.norm(in_frame(found, spin_of(found)) * spin, axis=1)
    return [("off the parabola", "m", 0, off.max()), ("change of angular momentum, of itself", "1", 0, np.abs(moment / start - 1).max())
            ], None


def spin_of(found):
    return np.stack([found[f"w{a}_0"] for a in "xyz"], axis=1)


def in_frame(found, vectors):
    """Vectors of the world, a row for each of the body's, in the frame of its shape."""
    q = np.stack([found[f"q{a}_0"] for a in "wxyz"], axis=1)
    u = q[:, 1:]
    return vectors - 2 * np.cross(u, q[:, :1] * vectors) + 2 * np.cross(u, np.cross(u, vectors))


def energy(series, found, mass, moments):
    """J, of the water and of the body."""
    speed = sum(found[f"v{a}_0"] ** 2 for a in "xyz")
    spin = np.sum(in_frame(found, spin_of(found)) ** 2 * moments, axis=1)
    return series["kinetic_energy"] + series["potential_energy"] + mass * (speed / 2 + GRAVITY * found["z_0"]) + spin / 2


def rises(total, time, rest):
    """Of an energy that should never rise: its largest rise above what it was before, and its trend from `rest` on, J/s."""
    late = time > rest
    return [("largest rise of the energy in all above its lowest so far", "J", 0, largest_rise(total)),
            (f"trend of the energy in all from {rest} s on", "J/s", 0, np.polyfit(time[late], total[late], 1)[0]),
            ("loss of it by then", "J", math.nan, total[0] - total[late][0])]


def drawn(trevi, speed, spacing=0.1, radius=0.5):
    """A ball of 5 spacings drawn through water 1 m under the surface, 1 m far."""
    weight = 1000 * GRAVITY * 4 / 3 * math.pi * radius**3
    _, found = run(trevi, {"type": '"sphere"', "radius": radius, "center": [1.0, 1.0, 1.0], "velocity": [float(speed), 0.0, 0.0]},
                   box=(3, 2, 3), depth=2, spacing=spacing, dt=1 / 60, end=1 / speed, kind="obstacle")
    along, up = (found[f"force_{a}_0"][4:] / weight for a in "xz")
    return [("force along its way, of the weight of its water, mean", "1", 0, along.mean()),
            ("scatter of that from step to step", "1", 0, along.std()),
            ("force upwards, mean", "1", 1, up.mean()), ("scatter of that", "1", 0, up.std())], None


def released(trevi, density, spacing=0.1, radius=0.5):
    """A ball let go 2 m under water; it is pushed by (rho - rho_b) g V, and moves with half of the water's mass besides."""
    _, found = run(trevi, {"type": '"sphere"', "radius": radius, "center": [2.0, 2.0, 2.0], "density": density, "free": '["z"]'},
                   box=(4, 4, 5), depth=4, spacing=spacing, dt=1 / 60, end=0.2)
    steps = np.diff(found["vz_0"]) * 60 / ((1000 - density) / (density + 500) * GRAVITY)
    return [("acceleration over that of an ideal fluid, mean of 0.1 s", "1", 1, steps[:6].mean()),
            ("least of a step, from the second to the twelfth", "1", 1, steps[1:12].min()),
            ("most of a step", "1", 1, steps[1:12].max())], None


BESIDE = [({"type": '"sphere"', "radius": 0.25}, 4 / 3 * math.pi * 0.25**3), ({"type": '"box"', "size": [0.5, 0.5, 0.5]}, 0.125),
          ({"type": '"cylinder"', "radius": 0.25, "height": 0.5, "axis": [1, 0, 0]}, math.pi * 0.25**2 * 0.5)]
FLOORS = {"the floor": 0.0, "an obstacle": 0.6, "an obstacle off the cells": 0.7, "a body": 0.6}


def beside(trevi, below):
    """Bodies of 5 spacings on something or near it: the force of the first step over that by Archimedes; the rise of light ones."""
    floor = FLOORS[below]
    lower = [{"type": '"box"', "size": [0.8, 0.8, 0.6], "center": [0.87, 0.8, 0.3], "density": 3000}] * (below == "a body")
    solid = f'\n[[obstacle]]\ntype = "box"\ncenter = [0.9, 0.8, {floor - 1}]\nsize = [2.2, 2.0, 2.0]\n' if "obstacle" in below else ""
    tank, on, near, rise = {"box": (1.8, 1.6, 2.6), "depth": floor + 1.0, "spacing": 0.1, "dt": 1 / 60, "solids": solid}, [], [], []
    for body, volume in BESIDE:
        for gap in (0.0, 0.05, 0.1, 0.15, 0.2, 0.3):
            shape = body | {"center": [0.87, 0.8, floor + gap + 0.25]}
            found = run(trevi, *lower, shape | {"density": 1000}, end=1 / 60, **tank)[1][f"force_z_{len(lower)}"]
            (near if gap > 0 else on).append(found[1] / (1000 * GRAVITY * volume))
        found = run(trevi, *lower, body | {"center": [0.87, 0.8, floor + 0.25], "density": 500}, end=1, **tank)[1][f"z_{len(lower)}"]
        rise.append((found[-1] - found[0]) / 0.1)
    return [("force upwards without a gap, least", "1", 1, min(on)), ("most without a gap", "1", 1, max(on)),
            ("with a gap of 0.5 to 3 spacings, least", "1", 1, min(near)), ("most with a gap", "1", 1, max(near)),
            ("rise of a light one in a second, least", "spacings", math.nan, min(rise))], None


def raft(trevi, layers, spacing=0.05):
    size, density, depth = np.array([0.4, 0.3, 0.15]), 500, layers * spacing
    body = {"type": '"box"', "size": list(map(float, size)), "center": [0.6, 0.4, depth + 0.09], "rotate": [0.0, 5.0, 0.0],
            "density": density}
    series, found = run(trevi, body, box=(1.2, 0.8, 2 * depth), depth=depth, spacing=spacing, dt=1 / 60, end=20.0)
    mass = density * size.prod()
    late = found["time"] > 10
    return [*rises(energy(series, found, mass, mass / 12 * (np.sum(size**2) - size**2)), found["time"], 10),
            ("kinetic energy of the water, mean from 10 s on", "J", 0, series["kinetic_energy"][late].mean())], None


def level_of(series, area, displaced, spacing):
    return (series["particles"][-1] * spacing**3 + displaced) / area


def tilt(found):
    """Of the axis z of the shape, degrees."""
    return np.degrees(np.arccos(np.clip(1 - 2 * (found["qx_0"] ** 2 + found["qy_0"] ** 2), -1, 1)))


def log(trevi, density, rest, spacing=0.04):
    """A square log, let go at 10°."""
    side, depth, width = 0.4, 0.8, 4 * spacing
    body = {"type": '"box"', "size": [side, width, side], "center": [1.5, width / 2, depth + side * (0.5 - density / 1000)],
            "rotate": [0.0, 10.0, 0.0], "density": density, "free": ["x", "z", "pitch"]}
    _, found = run(trevi, body, box=(3.0, width, 1.6), depth=depth, spacing=spacing, dt=1 / 60, end=25.0, every=5)
    late = found["time"] > 20
    turned = np.degrees(2 * np.arctan2(found["qy_0"], found["qw_0"]))[late].mean()
    return [("angle after 20 s", "°", rest, (turned - rest + 45) % 90 - 45 + rest)], None


def plate(trevi, density, spacing=0.05):
    size, area, depth = [0.6, 0.4, 0.03], 1.2 * 0.8, 0.5
    body = {"type": '"box"', "size": size, "center": [0.6, 0.4, depth + 0.05 if density < 1000 else 0.3], "density": density}
    series, found = run(trevi, body, box=(1.2, 0.8, 1.0), depth=depth, spacing=spacing, dt=1 / 60, end=20.0, every=5)
    late = found["time"] > 10
    lower = found["z_0"][late].mean() - size[2] / 2
    wet = size[2] * min(1, density / 1000)
    off = level_of(series, area, wet * 0.24, spacing) - lower - wet if density < 1000 else lower
    what = "draught less Archimedes'" if density < 1000 else "height above the floor"
    return [(what, "spacings", 0, off / spacing), ("largest tilt from 10 s on", "°", 0, tilt(found)[late].max())], None


def bath_duck(trevi, density=200, scale=0.8, spacing=0.05):
    step = 0.01
    places = np.stack(np.meshgrid(*(np.arange(low, high, step) for low, high in ((-0.55, 0.5), (-0.35, 0.35), (-0.25, 0.5))),
                                  indexing="ij"), axis=-1).reshape(-1, 3)
    inside = scale * places[duck_distance(places) < 0]
    body = {"type": '"mesh"', "path": f'"{ROOT / "inputs/gallery/duck.ply"}"', "scale": scale, "translate": [0.8, 0.6, 0.6],
            "density": density}
    series, found = run(trevi, body, box=(1.6, 1.2, 1.2), depth=0.5, spacing=spacing, dt=1 / 60, end=60.0, every=10)
    late = np.flatnonzero(found["time"] > 40)
    level = level_of(series, 1.6 * 1.2, density / 1000 * len(inside) * (scale * step) ** 3, spacing)
    off = []
    for n in late:  # where the level should be to bear it, seen from its centre of mass
        up = in_frame({key: values[n:n + 1] for key, values in found.items()}, np.array([[0.0, 0.0, 1.0]]))[0]
        off.append(level - found["z_0"][n] - np.quantile((inside - inside.mean(axis=0)) @ up, density / 1000))
    return [("draught less Archimedes', 40 to 60 s", "spacings", 0, np.mean(off) / spacing),
            ("largest tilt in 60 s", "°", math.nan, tilt(found).max()),
            ("fastest from 40 s on", "m/s", 0, np.sqrt(sum(found[f"v{a}_0"][late] ** 2 for a in "xyz")).max()),
            ("height from 40 s on, largest less least", "spacings", 0, np.ptp(found["z_0"][late]) / spacing)], None


NO_GRAVITY = {"box": (2.0, 1.0, 1.2), "depth": 0.1, "spacing": 0.1, "gravity": ""}


def collision(trevi, restitution=0.8):
    balls = [{"type": '"sphere"', "radius": radius, "center": [x, 0.5, 0.7], "density": density, "velocity": [v, 0.0, 0.0],
              "restitution": restitution} for radius, x, density, v in ((0.15, 0.4, 500, 1.0), (0.2, 1.0, 800, 0.0))]
    _, found = run(trevi, *balls, **NO_GRAVITY, dt=1 / 60, end=0.9)
    mass = [4 / 3 * math.pi * ball["radius"] ** 3 * ball["density"] for ball in balls]
    momentum = sum(m * found[f"vx_{k}"] for k, m in enumerate(mass))
    return [("speed apart, of the speed of approach", "1", restitution, found["vx_1"][-1] - found["vx_0"][-1]),
            ("change of momentum, of itself", "1", 0, np.abs(momentum / mass[0] - 1).max())], None


def spring(trevi, stiffness=100.0):
    """A ball in the air that swings along a spring."""
    radius, density = 0.15, 500
    body = {"type": '"sphere"', "radius": radius, "center": [1.1, 0.5, 0.7], "density": density,
            "mooring": f"{{ anchor = [0.4, 0.5, 0.7], stiffness = {stiffness}, length = 0.6 }}"}
    _, found = run(trevi, body, **NO_GRAVITY, dt=1 / 60, end=10.0)
    at = crossings(found["time"], found["x_0"] - 1.0)
    swing = np.abs(found["x_0"] - 1.0)
    half = len(swing) // 2
    return [("period", "s", 2 * math.pi * math.sqrt(4 / 3 * math.pi * radius**3 * density / stiffness),
             2 * (at[-1] - at[0]) / (len(at) - 1)),
            ("amplitude of the last 5 s over that of the first", "1", 1, swing[half:].max() / swing[:half].max())], None


def buoy(trevi, spacing=0.05, stiffness=2000.0):
    """A ball under water on a line to the floor."""
    radius, density = 0.15, 300
    body = {"type": '"sphere"', "radius": radius, "center": [0.5, 0.5, 0.4], "density": density,
            "mooring": f"{{ anchor = [0.5, 0.5, 0.0], stiffness = {stiffness}, damping = 20.0, length = 0.4, slack = true }}"}
    _, found = run(trevi, body, box=(1.0, 1.0, 1.4), depth=1.0, spacing=spacing, dt=1 / 60, end=20.0, every=5)
    late = found["time"] > 10
    length = np.sqrt((found["x_0"] - 0.5) ** 2 + (found["y_0"] - 0.5) ** 2 + found["z_0"] ** 2)
    pull = stiffness * (length[late].mean() - 0.4)
    return [("pull of the line, 10 to 20 s", "N", (1000 - density) * 4 / 3 * math.pi * radius**3 * GRAVITY, pull),
            ("farthest aside from 10 s on", "spacings", 0, np.hypot(found["x_0"] - 0.5, found["y_0"] - 0.5)[late].max() / spacing)
            ], None


def draw(curves, path):
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6))
    for axis, (title, unit, scale, named) in zip(axes, (("heave of half a cylinder", "t √(g/R)", "y / y0", "heave"),
                                                        ("roll of a barge", "t, s", "angle, °", "roll"))):
        for case, (t, here, _) in curves.items():
            if case.startswith(named):
                axis.plot(t, here, label=case.split(", ")[1])
        t, _, theory = [curve for case, curve in curves.items() if case.startswith(named)][-1]
        axis.plot(t, theory, "k--", lw=1, label="theory")
        axis.set(title=title, xlabel=unit, ylabel=scale)
        axis.grid(alpha=0.3)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=110)


CASES = {"free fall": fall, "light ball": light, "ball of the water's density": neutral, "ball afloat": afloat, "ball that stands there": standing,
         **{f"raft, {n} layers": (lambda trevi, n=n: raft(trevi, n)) for n in (9, 10)},
         **{f"log of {d} kg/m³": (lambda trevi, d=d, rest=rest: log(trevi, d, rest)) for d, rest in ((150, 0), (500, 45))},
         **{f"plate of {d} kg/m³, 0.6 spacings thick": (lambda trevi, d=d: plate(trevi, d)) for d in (500, 3000)},
         "duck": bath_duck, "two balls that collide": collision, "ball on a spring in the air": spring, "buoy on a line": buoy,
         **{f"ball drawn at {u:g} m/s": (lambda trevi, u=u: drawn(trevi, u)) for u in (0.25, 0.5, 1)},
         **{f"ball of {d} kg/m³ let go": (lambda trevi, d=d: released(trevi, d)) for d in (50, 500, 2000)},
         **{f"bodies on {below}": (lambda trevi, below=below: beside(trevi, below)) for below in FLOORS},
         **{f"cylinder of {d} kg/m³": (lambda trevi, d=d: draught(trevi, d)) for d in (300, 500, 700)},
         **{f"heave, {n} spacings a radius": (lambda trevi, n=n: heave(trevi, 1 / n)) for n in (10, 20)},
         **{f"roll, {n} spacings of draught": (lambda trevi, n=n: roll(trevi, 0.5 / n)) for n in (10,)}}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", help="cases whose name begins so")
    arguments = parser.parse_args()
    rows, curves = [], {}
    cases = [case for case in CASES if case.startswith(arguments.only or "")]
    for case, (found, curve) in zip(cases, in_turn(lambda case: CASES[case](arguments.trevi), cases)):
        rows += [(case, *row) for row in found]
        for row in rows[-len(found):]:
            print(*row, sep="; ", flush=True)
        if curve:
            curves[case] = curve
    with open(arguments.output, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["case", "quantity", "unit", "expected", "measured"])
        out.writerows([*row[:3], *(f"{x:.4g}" for x in row[3:])] for row in rows)
    if {case.split(",")[0] for case in curves} >= {"heave", "roll"}:
        draw(curves, arguments.output.with_suffix(".png"))


if __name__ == "__main__":
    main()

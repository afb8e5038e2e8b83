#!/usr/bin/python3
"""Bodies in two dimensions: heave of half a cylinder of water and roll of a barge against linear theory in the same tank
(known_floating.py), and tanks in which two to six bodies, drawn from a seed, fall into water, meet, and lie on each other.

One row for each case and quantity. The energy is that of water and bodies; of a tank it is told over what lifts its bodies
by a metre.
"""

import math
import random
import tempfile
from pathlib import Path

import numpy as np

from known_floating import decay
from study import GRAVITY, columns_of, energies, largest_rise, launch, parser_of, write_as_found

SEEDS = 200


def plain(numbers):
    return "[" + ", ".join(repr(float(x)) for x in numbers) + "]"


def body_text(body):
    return "[[body]]\n" + "".join(
        f"{key} = {value if isinstance(value, str) else plain(value) if isinstance(value, tuple) else repr(value)}\n"
        for key, value in body.items())


def run(trevi, bodies, box, depth, spacing, dt, end):
    """Columns of series.csv and of bodies.csv, and the exit code."""
    text = (f"[domain]\ndimensions = 2\nmin = [0.0, 0.0]\nmax = {plain(box)}\n[fluid]\nspacing = {spacing!r}\n[time]\n"
            f"dt = {dt!r}\nend = {end!r}\n[gravity]\n[[particles]]\nmin = [0.0, 0.0]\nmax = {plain((box[0], depth))}\n"
            + "".join(map(body_text, bodies)) + "[output.series]\n")
    with tempfile.TemporaryDirectory() as folder:
        scene, output = Path(folder) / "scene.toml", Path(folder) / "run"
        scene.write_text(text, encoding="utf-8")
        code, _ = launch(trevi, scene, output, (), 1800)
        return columns_of(output / "series.csv"), columns_of(output / "bodies.csv"), code


def half_periods(t, y):
    at = np.flatnonzero(y[1:] * y[:-1] < 0)
    return np.diff(t[at] + (t[at + 1] - t[at]) * y[at] / (y[at] - y[at + 1]))[:3]


def heave(trevi, per_radius):
    radius, depth, half = 1.0, 2.5, 10.0
    hull = [(radius * math.sin(a), -radius * math.cos(a)) for a in np.linspace(0, math.pi / 2, 31)]
    t, y, _ = decay(hull, half_length=half, depth=depth, about=None, inertia=math.pi / 2, stiffness=2 * GRAVITY, start=1 / 3,
                    seconds=4.2)
    body = {"type": '"cylinder"', "radius": radius, "center": (half, depth + radius / 3), "density": 500.0, "free": '["z"]'}
    _, found, _ = run(trevi, [body], (2 * half, depth + 2), depth, 1 / per_radius, 0.01, 4.2)
    time, here = np.array(found["time"]), (np.array(found["z_0"]) - depth) * 3
    off = np.abs(here - 3 * np.interp(time, t, y))
    trough = 3 * y[(t > 0.5) & (t < 1.8)].min()
    return [("largest difference from theory, of the start", 0, off.max()), ("mean difference", 0, off.mean()),
            ("first trough, of the start", trough, here[(time > 0.5) & (time < 1.8)].min())]


def roll(trevi, per_draught):
    depth, half, angle = 2.0, 8.0, 5.0
    t, y, _ = decay([(0, -0.5), (1, -0.5), (1, 0)], half_length=half, depth=depth, about=0, inertia=5 / 12,
                    stiffness=GRAVITY * (8 / 12 - 0.25), start=angle, seconds=6)
    body = {"type": '"box"', "size": (2.0, 1.0), "center": (half, depth), "rotate": (0.0, angle, 0.0), "density": 500.0,
            "free": '["pitch"]'}
    _, found, _ = run(trevi, [body], (2 * half, depth + 1.5), depth, 0.5 / per_draught, 0.01, 6.0)
    turned = 2 * np.degrees(np.arctan2(found["qy_0"], found["qw_0"]))
    ratio = half_periods(np.array(found["time"]), turned) / half_periods(t, y)
    return [("half a period over that of theory, least", 1, ratio.min()), ("half a period over that of theory, most", 1, ratio.max())]


def area_of(body):
    return math.pi * body["radius"]**2 if "radius" in body else math.prod(body["size"])


def drawn(seed):
    """Bodies in a tank, its length, depth and step."""
    draw = random.Random(seed)
    length, depth, dt = draw.choice((2.0, 3.0, 4.0)), draw.choice((0.6, 0.8, 1.0)), draw.choice((1 / 60, 1 / 60, 1 / 120, 1 / 240))
    count, bodies, places = draw.randint(2, 6), [], []
    for _ in range(200):
        if len(bodies) == count:
            break
        density, x, z = draw.choice((100, 300, 600, 900, 1000, 1300, 2500, 5000)), draw.uniform(0.4, length - 0.4), draw.uniform(0.35, 2.2)
        if draw.random() < 1 / 3:
            reach = draw.uniform(0.1, 0.25)
            shape = {"type": '"cylinder"', "radius": reach}
        else:
            shape = {"type": '"box"', "size": (draw.uniform(0.2, 0.6), draw.uniform(0.2, 0.45)),
                     "rotate": (0.0, draw.choice((0.0, draw.uniform(-60, 60))), 0.0)}
            reach = math.hypot(*shape["size"]) / 2
        if min(x, length - x, z) < reach + 0.01 or any(math.hypot(x - p, z - q) < reach + r + 0.03 for p, q, r in places):
            continue
        places.append((x, z, reach))
        bodies.append(shape | {"center": (x, z), "density": float(density)})
    return bodies, length, depth, dt


def energy_of(columns, found, bodies, spacing):
    total = np.array(energies(columns))
    for k, body in enumerate(bodies):
        squared = body["radius"]**2 / 2 if "radius" in body else sum(x * x for x in body["size"]) / 12
        of = {name: np.array(found[f"{name}_{k}"]) for name in ("z", "vx", "vz", "wy")}
        kinetic = (of["vx"]**2 + of["vz"]**2 + squared * of["wy"]**2) / 2
        total += body["density"] * area_of(body) * spacing * (GRAVITY * of["z"] + kinetic)
    return total


def tank(trevi, seed, spacing=0.05):
    """Largest rise of the energy in a step and above its lowest so far, and the fastest body, m/s."""
    bodies, length, depth, dt = drawn(seed)
    columns, found, code = run(trevi, bodies, (length, 3.0), depth, spacing, dt, 3.0)
    total = energy_of(columns, found, bodies, spacing)
    scale = sum(body["density"] * area_of(body) for body in bodies) * spacing * GRAVITY
    speed = max(np.hypot(found[f"vx_{k}"], found[f"vz_{k}"]).max() for k in range(len(bodies)))
    return np.diff(total).max() / scale, largest_rise(total) / scale, speed, code != 0


def tanks(trevi):
    step, rise, speed, ended = map(np.array, zip(*(tank(trevi, seed) for seed in range(SEEDS))))
    return [("runs that ended before their time", 0, ended.sum()), ("energy rises in a step by more than 0.02", 0, (step > 0.02).sum()),
            ("largest rise in a step", 0, step.max()), ("rise in a step, mean of the largest of each", 0, step.clip(0).mean()),
            ("largest rise above the lowest so far", 0, rise.max()), ("fastest body, m/s", math.nan, speed.max())]


CASES = {**{f"heave, {n} spacings a radius": (lambda trevi, n=n: heave(trevi, n)) for n in (10, 20, 40)},
         **{f"roll, {n} spacings of draught": (lambda trevi, n=n: roll(trevi, n)) for n in (10, 20)},
         f"{SEEDS} tanks": tanks}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", default="", help="cases whose name begins so")
    options = parser.parse_args()
    write_as_found(options.output, lambda case: [{"case": case, "quantity": name, "expected": expected, "measured": measured}
                                                 for name, expected, measured in CASES[case](options.trevi)],
                   [case for case in CASES if case.startswith(options.only)])


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Whether water that fills its vessel goes with it as one: each is carried along a circle of 0.3 m at 1 g, from rest within 1 s.

A vessel that only translates gives its water no circulation, so that all of it has the velocity of the vessel. One row for
each vessel, spacing and step: energy over that of a rigid body and mean compression, both from 1 s on, and how much the
velocities differ from the vessel's at the end, over its speed (root mean square). One vessel consists of six boxes that move
together. The last rows are of a box that a wall divides into a full and a half full tank, both at rest: kinetic energy per mass.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from study import GRAVITY, columns_of, launch, mean, parser_of, states_of, two_at_a_time, write_table

RADIUS, SECONDS = 0.3, 3  # m; s
RATE = math.sqrt(GRAVITY / RADIUS)  # rad/s
SIX = "six boxes"
VESSELS = {
    "box": 'type = "box"\nsize = [0.8, 0.8, 0.8]',
    "box off the lattice": 'type = "box"\nsize = [0.81, 0.81, 0.81]',
    "box, turned twice": 'type = "box"\nsize = [0.8, 0.8, 0.8]\nrotate = [15, 25, 35]',
    "sphere": 'type = "sphere"\nradius = 0.6',
    "cylinder, lying": 'type = "cylinder"\nradius = 0.5\nheight = 0.9\nrotate = [90, 0, 0]',
    "torus": 'type = "torus"\nradius = 0.6\ntube = 0.25',
    SIX: "",
}
SCENE = """
[domain]
min = {low}
max = {high}
[fluid]
spacing = {spacing}
{water}
[time]
dt = {step!r}
end = {seconds}
[gravity]
[[obstacle]]
{obstacle}
[output.series]
every = {step!r}
[output.checkpoint]
every = {seconds}
"""


def place(time):
    """Of the vessel's centre, m."""
    u = min(time, 1)
    radius = RADIUS * u * u * (3 - 2 * u)
    return radius * np.array([math.sin(RATE * time), 0.0, math.cos(RATE * time)])


def block(low, high):
    return f"[[particles]]\nmin = {low}\nmax = {high}"


def along_circle(center):
    knots = ",\n".join(str([k / 240, *(place(k / 240) + center).tolist()]) for k in range(SECONDS * 240 + 2))
    return f"center = {center}\nmotion = [{knots}]"


def carried(shape):
    parts = {"low": [-1.6, -1.0, -1.4], "high": [1.6, 1.0, 1.6], "water": block([-1.2, -0.9, -0.9], [1.2, 0.9, 0.9])}
    if shape:
        return parts | {"obstacle": f"{shape}\ninside = true\n" + along_circle([0, 0, 0])}
    low, high = -0.37, 0.43  # of the space between the boxes
    boxes = []
    for axis in range(3):  # those across later axes lie between those across earlier ones
        for upper in (False, True):
            ends = [[low - 0.5, high + 0.5] if other < axis else [low, high] for other in range(3)]
            ends[axis] = [high, high + 0.5] if upper else [low - 0.5, low]
            center, size = [(a + b) / 2 for a, b in ends], [b - a for a, b in ends]
            boxes.append(f'type = "box"\nsize = {size}\n' + along_circle(center))
    return parts | {"water": block([low] * 3, [high] * 3), "obstacle": "\n[[obstacle]]\n".join(boxes)}


def divided():
    return {"low": [0, 0, 0], "high": [3.2, 1.0, 1.0], "water": block([0, 0, 0], [1.5, 1, 1]) + "\n" + block([1.7, 0, 0], [3.2, 1, 0.5]),
            "obstacle": 'type = "box"\ncenter = [1.6, 0.5, 0.5]\nsize = [0.2, 1.2, 1.2]'}


def row_of(case, folder, trevi):
    step = 1 / case["steps_per_second"]
    parts = divided() if case["vessel"] not in VESSELS else carried(VESSELS[case["vessel"]])
    name = "_".join(str(value) for value in case.values()).replace(" ", "_")
    scene, output = folder / f"{name}.toml", folder / name
    scene.write_text(SCENE.format(**parts, spacing=case["spacing"], step=step, seconds=SECONDS), encoding="utf-8")
    code, message = launch(trevi, scene, output, [], 3600)
    if code != 0:
        raise SystemExit(f"study_full_vessels.py: {case}: {message}")
    columns = columns_of(output / "series.csv")
    late = slice(round(1 / step), None)
    mass = columns["particles"][0] * 1000 * case["spacing"]**3
    energy = mean(columns["kinetic_energy"][late]) / mass
    velocity = states_of(output)[-1][1]
    row = {**case, "particles": round(columns["particles"][0]), "energy_over_rigid": "", "velocity_off": "",
           "kinetic_per_mass": f"{energy:.2e}", "compression_mean": f"{mean(columns['compression_mean'][late]):.2e}"}
    if case["vessel"] not in VESSELS:
        return row
    speed, last = RATE * RADIUS, step / columns["substeps"][-1]
    own = (place(SECONDS) - place(SECONDS - last)) / last
    off = math.sqrt(((velocity - own)**2).sum(axis=1).mean()) / speed
    return row | {"energy_over_rigid": round(energy / (speed**2 / 2), 4), "velocity_off": round(off, 4)}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", default="", help="vessels with this in their names")
    options = parser.parse_args()
    cases = [{"vessel": vessel, "spacing": spacing, "steps_per_second": rate} for vessel in [*VESSELS, "full beside half full"]
             for spacing, rate in ((0.1, 60), (0.1, 240), (0.05, 60)) if options.only in vessel]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for row in two_at_a_time(lambda case: row_of(case, Path(folder), options.trevi), cases):
            print(*row.values(), sep=", ", flush=True)
            rows.append(row)
    write_table(options.output, rows)


if __name__ == "__main__":
    main()

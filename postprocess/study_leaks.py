#!/usr/bin/python3
"""Whether vessels keep their water: each is shaken along a circle at 10 m/s and 20 g for 10 s, and every particle is looked
for at each second; and water thrown at 100 m/s against a sheet one spacing thick that ends flush with the walls. One row for each
case; the exit code is 1 where a particle got out, or a run has not come to its end.

A ball and a torus hold water as shapes, a jug with its lid on as a mesh, a PLY file that is made for it.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from study import columns_of, in_turn, launch, parser_of, states_of, write_table

SPACING = 0.1  # m
SPEED, FRAMES, PERIOD = 10.0, 60, 19  # m/s; steps in a second; steps of a turn, which makes 20.2 g
JUG = [(0.0, -0.6), (0.5, -0.6), (0.7, -0.1), (0.5, 0.3), (0.5, 0.6), (0.0, 0.6)]  # (distance from the axis, z), m
SIDES = 64
SCENE = """
[domain]
min = [-2.0, -1.0, -2.0]
max = [2.0, 1.0, 2.0]
[fluid]
spacing = 0.1
[[particles]]
min = [-1.0, -0.9, -0.9]
max = [1.0, 0.9, 0.2]
[time]
dt = 0.016666666666666667
end = {end}
[gravity]
[[obstacle]]
{vessel}
[output.series]
every = 0.1
[output.checkpoint]
every = 1.0
keep = {keep}
"""
SHEET = """
[domain]
min = [0, 0, 0]
max = [4, 0.8, 2]
[fluid]
spacing = 0.1
[[particles]]
min = [0, 0, 0]
max = [1.6, 0.8, 1]
velocity = [100, 0, 0]
[time]
dt = 0.016666666666666667
end = 2
[gravity]
[[obstacle]]
type = "box"
center = [2, 0.4, 1]
size = [0.1, 0.8, 2]
[output.series]
every = 0.1
[output.checkpoint]
every = 0.1
keep = 30
"""


def place(step):
    """Of the vessel's centre, m: along a circle, as fast from the start on."""
    radius, angle = 1.03 * SPEED * PERIOD / (2 * np.pi * FRAMES), 2 * np.pi * step / PERIOD
    return radius * np.sin(angle), 0.0, radius * (1 - np.cos(angle)) - radius


def outside_ball(p):
    return np.linalg.norm(p, axis=1) - 0.6


def outside_torus(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.6, p[:, 2]) - 0.25


def outside_jug(p):
    """By the planes of its sides: the mesh has flat faces, SIDES of them around."""
    angle = np.arctan2(p[:, 1], p[:, 0])
    middle = (np.floor(angle * SIDES / (2 * np.pi)) + 0.5) * 2 * np.pi / SIDES
    flat = np.hypot(p[:, 0], p[:, 1]) * np.cos(angle - middle) / np.cos(np.pi / SIDES)
    r, z = np.array(JUG).T
    order = np.argsort(z[1:-1])
    return np.maximum(flat - np.interp(p[:, 2], z[1:-1][order], r[1:-1][order]), np.abs(p[:, 2]) - 0.6)


def write_jug(path):
    angle = np.arange(SIDES) * 2 * np.pi / SIDES
    points = [(0, 0, JUG[0][1])] + [(r * np.cos(a), r * np.sin(a), z) for r, z in JUG[1:-1] for a in angle]
    points.append((0, 0, JUG[-1][1]))
    rings, faces = len(JUG) - 2, []
    for k in range(SIDES):
        n = (k + 1) % SIDES
        faces += [(0, 1 + n, 1 + k), (len(points) - 1, 1 + (rings - 1) * SIDES + k, 1 + (rings - 1) * SIDES + n)]
        for ring in range(rings - 1):
            a, b = 1 + ring * SIDES, 1 + (ring + 1) * SIDES
            faces += [(a + k, a + n, b + k), (a + n, b + n, b + k)]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
                   f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines("{} {} {}\n".format(*point) for point in points)
        file.writelines("3 {} {} {}\n".format(*face) for face in faces)


def shaken(vessel, outside, seconds):
    """The scene of a vessel, and what tells how far particles are out of it at a step."""
    motion = ",\n".join(str([step / FRAMES, *place(step)]) for step in range(seconds * FRAMES + 1))
    text = SCENE.format(end=seconds, keep=seconds + 1, vessel=f"{vessel}\ninside = true\nmotion = [{motion}]")
    return text, lambda p, step: outside(p - place(step))


def cases(folder, seconds):
    write_jug(folder / "jug.ply")
    c = list(place(0))
    yield "ball", *shaken(f'type = "sphere"\ncenter = {c}\nradius = 0.6', outside_ball, seconds)
    yield "torus", *shaken(f'type = "torus"\ncenter = {c}\nradius = 0.6\ntube = 0.25', outside_torus, seconds)
    yield "jug", *shaken(f'type = "mesh"\npath = "jug.ply"\ntranslate = {c}', outside_jug, seconds)
    yield "sheet", SHEET, lambda p, step: p[:, 0] - 1.95


def row_of(name, outside, output, code, steps):
    """What became of a run: particles at the start and at the end, and the farthest that any was out of its vessel."""
    counts = [int(count) for count in columns_of(output / "series.csv")["particles"]]
    states = states_of(output)
    out = [outside(position, step) for (position, _), step in zip(states, steps)]
    return {"vessel": name, "exit_code": "none" if code is None else code, "particles": counts[0], "lost": counts[0] - counts[-1],
            "outside": int(sum((d > 1e-6).sum() for d in out)), "farthest_m": f"{max(d.max() for d in out):.2e}",
            "looks": len(states)}


def shake(trevi, folder, name, text, outside):
    scene, output = folder / f"{name}.toml", folder / name
    scene.write_text(text, encoding="utf-8")
    code, message = launch(trevi, scene, output, [], 7200)
    steps = sorted(int(file.stem.split("_")[1]) for file in output.glob("checkpoint_*.h5"))
    if not steps:
        sys.exit(f"study_leaks.py: {name}: {message}")
    return row_of(name, outside, output, code, steps)


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--seconds", type=int, default=10, help="that each is shaken for (default %(default)s)")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for row in in_turn(lambda case: shake(options.trevi, folder, *case), cases(folder, options.seconds)):
            rows.append(row)
            print(row, flush=True)
    write_table(options.output, rows)
    return int(any(row["exit_code"] != 0 or row["lost"] or row["outside"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())

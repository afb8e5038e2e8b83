#!/usr/bin/python3
"""Bodies that touch each other or a wall: what water at rest does to each of them, and rafts of floats that stay where they are.

  postprocess/study_touching.py postprocess/results/touching.csv

Boxes of the water's density under water, with gaps of up to two spacings, on the cells and off them: the forces of the first step
over those by Archimedes, and those along the level and their moments, which are zero, over the weight of the water in the body's
place and that times its height. In rafts of flat floats at their draught nothing moves; the rows have what does, at most, in three
seconds.
"""

import itertools
import math

import numpy as np

from study import GRAVITY, parser_of, write_as_found
from study_bodies import run

GAPS, OFF = (0.0, 0.2, 0.5, 1, 2), (0.0, 0.4)  # spacings
# For two boxes: the size of each, m, and whether the other one is above the first or beside it.
PAIRS = {"on an equal box": ((0.4, 0.4), "above"), "small on large": ((0.4, 0.2), "above"), "large on small": ((0.2, 0.4), "above"),
         "beside an equal box": ((0.4, 0.4), "beside"), "small beside large": ((0.4, 0.2), "beside")}
# Size and centre of a box in a tank of 2.4 × 1.2 m, m.
PLACES = {"at a wall": ([0.4, 0.4, 0.4], [1.0, 0.2, 0.5]), "high, at a wall": ([0.4, 0.4, 0.8], [1.0, 0.2, 0.5]),
          "in a corner": ([0.4, 0.4, 0.4], [0.2, 0.2, 0.5]), "in a corner of the floor": ([0.4, 0.4, 0.4], [0.2, 0.2, 0.2])}
FLOATS = ((700, 0.4, 0.2), (300, 0.4, 0.2), (900, 0.3, 0.1))  # density, width and height, m
STEP = 1 / 60


def box(size, center, density=1000.0):
    return {"type": '"box"', "size": [float(x) for x in size], "center": [float(x) for x in center], "density": float(density)}


def forces_on(trevi, boxes, spacing):
    """Of each box in the first step: the force upwards, that along the level, and the moment, without dimension."""
    bodies = run(trevi, *boxes, box=(2.4, 1.2, 1.6), depth=1.2, spacing=spacing, dt=STEP, end=STEP)[1]
    found = []
    for k, one in enumerate(boxes):
        weight = 1000 * GRAVITY * math.prod(one["size"])
        force = np.array([bodies[f"force_{a}_{k}"][1] for a in "xyz"]) / weight
        moment = np.array([bodies[f"torque_{a}_{k}"][1] for a in "xyz"]) / (weight * one["size"][2])
        found.append((force[2], np.hypot(force[0], force[1]), np.linalg.norm(moment)))
    return found


def pair(trevi, sizes, where, spacing):
    """With a gap of 0 to 2 spacings, on the cells and off them: of both boxes."""
    found = []
    for gap, off in itertools.product(GAPS, OFF):
        (first, second), shift, between = sizes, off * spacing, gap * spacing
        if where == "above":
            boxes = [box([first] * 3, [1.0, 0.6, 0.1 + shift + first / 2]),
                     box([second] * 3, [1.0, 0.6, 0.1 + shift + first + between + second / 2])]
        else:
            boxes = [box([first] * 3, [1.0 + shift, 0.6, 0.5]),
                     box([second] * 3, [1.0 + shift + first / 2 + between + second / 2, 0.6, 0.5])]
        found += forces_on(trevi, boxes, spacing)
    return found


def raft(trevi, count, spacing):
    """Without gaps and with 0.04 to 0.2 spacings, on the cells and off them: the furthest move and the fastest turn."""
    moved, turned = 0.0, 0.0
    for (density, width, height), gap, off in itertools.product(FLOATS, (0.0, 0.002, 0.005, 0.01), (0.0, 0.013)):
        side = math.ceil(10 * (count * width + (count - 1) * gap + 1) - 1e-9) / 10
        place = [0.5 + off + width / 2 + n * (width + gap) for n in range(count)]
        boxes = [box([width, width, height], [x, y, 0.8 + (0.5 - density / 1000) * height], density) for x in place for y in place]
        bodies = run(trevi, *boxes, box=(side, side, 1.4), depth=0.8, spacing=spacing, dt=STEP, end=3)[1]
        for k in range(count**2):
            way = np.array([bodies[f"{a}_{k}"] - bodies[f"{a}_{k}"][0] for a in "xyz"])
            spin = np.array([bodies[f"w{a}_{k}"] for a in "xyz"])
            moved, turned = max(moved, np.linalg.norm(way, axis=0).max()), max(turned, np.linalg.norm(spin, axis=0).max())
    return moved / spacing, turned


def rows_of(case, trevi):
    name, spacing = case
    known = {"case": name, "spacing": spacing}
    if name.startswith("raft"):
        moved, turned = raft(trevi, int(name.split()[2]), spacing)
        return [known | {"quantity": "furthest way, spacings", "theory": 0, "measured": moved},
                known | {"quantity": "fastest turn, rad/s", "theory": 0, "measured": turned}]
    if name in PLACES:
        found = forces_on(trevi, [box(*PLACES[name])], spacing)
    else:
        found = pair(trevi, *PAIRS[name], spacing)
    lift, along, moment = zip(*found)
    return [known | {"quantity": "force upwards, least", "theory": 1, "measured": min(lift)},
            known | {"quantity": "force upwards, most", "theory": 1, "measured": max(lift)},
            known | {"quantity": "force along the level, most", "theory": 0, "measured": max(along)},
            known | {"quantity": "moment, most", "theory": 0, "measured": max(moment)}]


def main():
    options = parser_of(__doc__, "CSV").parse_args()
    cases = [(name, spacing) for name in (*PAIRS, *PLACES) for spacing in (0.05, 0.025)]
    cases += [(f"raft of {n} by {n}", 0.05) for n in (2, 3)]
    write_as_found(options.output, lambda case: rows_of(case, options.trevi), cases)


if __name__ == "__main__":
    main()

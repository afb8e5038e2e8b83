#!/usr/bin/python3
"""Bodies that touch each other or a wall: what water at rest does to each of them, and rafts of floats that stay where they are.

  postprocess/study_touching.py postprocess/results/touching.csv

Boxes of the water's density under water, with gaps of up to two spacings, on the cells and off them: the forces of the first step
over those by Archimedes, and those along the level and their moments, which are zero, over the weight of the water in the body's
place and that times its height. In rafts of flat floats at their draught nothing moves; the rows have what does, at most, in three
seconds. Light boxes rise to the top of a tank, heavy ones sink to its floor: the total energy never rises, and what it rises by in a
step is over the work of the water on the box on its way. A slab on two piers, and a box on two others, rest.
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
LID = '\n[[obstacle]]\ntype = "box"\ncenter = [1.2, 0.8, 1.2]\nsize = [8.0, 3.0, 0.4]\n'
PLATE = '\n[[obstacle]]\ntype = "box"\ncenter = [1.2, 0.8, 0.0]\nsize = [8.0, 3.0, 0.2]\n'
# Densities, height of the centre at the start, m, height of the tank, m, further solids. Water is 1 m deep, boxes are 0.2 m high.
LANDINGS = {"to a lid": ((50, 200, 500, 900), 0.7, 1.6, LID), "to the ceiling": ((50, 200, 500, 900), 0.7, 1.0, ""),
            "to the floor": ((1100, 1500, 3000, 8000), 0.3, 1.6, ""), "to a plate": ((1500, 3000), 0.4, 1.6, PLATE)}
RESTS = {"a slab on two piers": (([0.3, 0.4, 0.3], [0.6, 0.6, 0.15]), ([0.3, 0.4, 0.3], [1.4, 0.6, 0.15]),
                                 ([1.1, 0.4, 0.15], [1.0, 0.6, 0.375])),
         "a box on two others": (([0.4, 0.4, 0.3], [0.813, 0.607, 0.15]), ([0.4, 0.4, 0.3], [1.23, 0.607, 0.15]),
                                 ([0.4, 0.4, 0.3], [1.02, 0.607, 0.45])),
         "a tower of five": tuple(([0.4, 0.4, 0.2], [1.0, 0.6, 0.1 + 0.2 * k]) for k in range(5))}
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


def landing(trevi, name, spacing):
    """On the cells with steps of 1/60 and 1/240 s, and off them: the largest rise of the energy in a step, and in all."""
    densities, start, top, solids = LANDINGS[name]
    way = abs(start - {"to a lid": 0.9, "to the ceiling": 0.9, "to the floor": 0.1, "to a plate": 0.2}[name])
    in_step = in_all = 0.0
    for density, (off, dt) in itertools.product(densities, ((0.0, STEP), (0.013, STEP), (0.0, STEP / 4))):
        one = box([0.4, 0.4, 0.2], [1.2 + off, 0.8 + off / 2, start], density)
        series = run(trevi, one, box=(2.4, 1.6, top), depth=1.0, spacing=spacing, dt=dt, end=1.2, solids=solids)[0]
        energy = series["kinetic_energy"] + series["potential_energy"] - series["supplied_energy"]
        work = 1000 * GRAVITY * math.prod(one["size"]) * way
        in_step, in_all = max(in_step, np.diff(energy).max() / work), max(in_all, (energy.max() - energy[0]) / work)
    return in_step, in_all


def rest(trevi, name, spacing):
    """Of boxes of 1500 kg/m³ without friction: the force upwards and the furthest way in two seconds."""
    boxes = [box(size, center, 1500) for size, center in RESTS[name]]
    bodies = run(trevi, *boxes, box=(2.0, 1.2, 1.6), depth=1.3, spacing=spacing, dt=STEP, end=2)[1]
    lift = [bodies[f"force_z_{k}"][60:].mean() / (1000 * GRAVITY * math.prod(one["size"])) for k, one in enumerate(boxes)]
    way = [np.abs(bodies[f"{a}_{k}"] - bodies[f"{a}_{k}"][0]).max() for k in range(len(boxes)) for a in "xyz"]
    return lift, max(way) / spacing


def rows_of(case, trevi):
    name, spacing = case
    known = {"case": name, "spacing": spacing}
    if name.startswith("raft"):
        moved, turned = raft(trevi, int(name.split()[2]), spacing)
        return [known | {"quantity": "furthest way, spacings", "theory": 0, "measured": moved},
                known | {"quantity": "fastest turn, rad/s", "theory": 0, "measured": turned}]
    if name in LANDINGS:
        in_step, in_all = landing(trevi, name, spacing)
        return [known | {"quantity": "largest rise of the energy in a step", "theory": 0, "measured": in_step},
                known | {"quantity": "rise of the energy above its start", "theory": 0, "measured": in_all}]
    if name in RESTS:
        lift, way = rest(trevi, name, spacing)
        return [known | {"quantity": "force upwards, least", "theory": 1, "measured": min(lift)},
                known | {"quantity": "force upwards, most", "theory": 1, "measured": max(lift)},
                known | {"quantity": "furthest way, spacings", "theory": 0, "measured": way}]
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
    cases += [(f"raft of {n} by {n}", 0.05) for n in (2, 3)] + [(name, 0.05) for name in (*LANDINGS, *RESTS)]
    write_as_found(options.output, lambda case: rows_of(case, options.trevi), cases)


if __name__ == "__main__":
    main()

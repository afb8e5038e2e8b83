#!/usr/bin/python3
"""Blocks of few particles, one to ten along each axis, that are let go or thrown in a box of 24 spacings for 0.8 s: how far
their energy rises above the least before, over that at the start. Nothing gives them any. One row for each block and step,
and for each set the mean, how many rise by more than 0.05, and the largest:

box      60 blocks of 8 to 200 particles, in corners, on the floor and in the air
plane    40 blocks of 4 to 100 particles in two dimensions
solids   60 blocks over a ball, a box or a cylinder that lies or leans anyhow

Blocks are drawn from a seed; another one makes others.
"""

import random
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from study import energies, in_turn, largest_rise, parser_of, simulate, write_table

SPACING, SIDE, ABOVE = 0.1, 2.4, 1.3  # m; ABOVE all solids
SETS = {"box": 60, "plane": 40, "solids": 60}
RATES = 60, 240, 960
SCENE = """[domain]
{dimensions}min = {low}
max = {high}
[fluid]
spacing = 0.1
[time]
dt = {dt!r}
end = 0.8
[gravity]
[density]
precision = "single"
[[particles]]
min = {start}
max = {end}
velocity = {velocity}
{solid}[output.series]
"""


@dataclass(frozen=True)
class Block:
    counts: list  # of particles along each axis
    start: list  # its lower corner, m
    velocity: list  # m/s
    solid: str

    def scene(self, rate):
        axes = [axis for axis in range(3) if self.counts[axis] > 0]
        end = [round(low + count * SPACING + 1e-7, 7) for low, count in zip(self.start, self.counts)]
        of = {"low": [0, 0, 0], "high": [SIDE] * 3, "start": self.start, "end": end, "velocity": self.velocity}
        return SCENE.format(dimensions="" if len(axes) == 3 else "dimensions = 2\n", dt=1 / rate, solid=self.solid,
                            **{name: [numbers[axis] for axis in axes] for name, numbers in of.items()})


def counts_of(draw, plane):
    while True:
        counts = [draw.choice([1, 2, 3, 4, 6, 8, 10]) for _ in range(3)]
        if plane:
            counts[1] = 0
        if (4 if plane else 8) <= (counts[1] or 1) * counts[0] * counts[2] <= 200:
            return counts


def solid_of(draw):
    kind = draw.choice(["sphere", "box", "cylinder"])
    center = [round(draw.uniform(0.6, 1.8), 2), round(draw.uniform(0.6, 1.8), 2), round(draw.uniform(0.1, 0.6), 2)]
    lines = [f'type = "{kind}"', f"center = {center}"]
    if kind == "box":
        size = [round(draw.uniform(0.6, 1.2), 2), round(draw.uniform(0.6, 1.2), 2), round(draw.uniform(0.3, 0.6), 2)]
        lines += [f"size = {size}", f"rotate = [{draw.randint(0, 45)}, {draw.randint(0, 45)}, 0]"]
    else:
        lines += [f"radius = {draw.uniform(0.3, 0.6):.2f}"]
    if kind == "cylinder":
        lines += [f"height = {draw.uniform(0.6, 1.2):.2f}", f"rotate = [{draw.choice([0, 30, 60, 90])}, 0, 0]"]
    return "[[obstacle]]\n" + "\n".join(lines) + "\n"


def block_of(draw, kind):
    counts = counts_of(draw, kind == "plane")
    widest = [SIDE - SPACING * count for count in counts]
    if kind == "solids":
        start = [draw.uniform(0.6, 1.6 - SPACING * counts[axis] / 2) for axis in range(2)]
        start += [draw.choice([ABOVE, draw.uniform(ABOVE, ABOVE + SPACING)])]
    else:
        start = [draw.choice([0, draw.uniform(0, widest[axis])]) for axis in range(2)]
        start += [draw.choice([0, 0, draw.uniform(0, 1)])]
    velocity = [round(draw.choice([0, draw.uniform(-3, 3)]), 2) for _ in range(3)]
    return Block(counts, [round(number, 3) for number in start], velocity, solid_of(draw) if kind == "solids" else "")


def blocks_of(kind, seed):
    draw = random.Random(f"{kind} {seed}")
    return [block_of(draw, kind) for _ in range(SETS[kind])]


def rise_of(trevi, text):
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(text, encoding="utf-8")
        columns, code, message = simulate(trevi, scene, time_limit=600)
    if code != 0:
        sys.exit(f"{message}\n{text}")
    energy = energies(columns)
    return largest_rise(energy) / energy[0]


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", choices=SETS, action="append", help="this set (default: all)")
    parser.add_argument("--seed", type=int, default=1, help="of the blocks (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time (default: %(default)s)")
    arguments = parser.parse_args()
    cases = [(kind, rate, number, block) for kind in arguments.only or SETS
             for rate in RATES for number, block in enumerate(blocks_of(kind, arguments.seed))]

    def run(case):
        kind, rate, number, block = case
        rise = rise_of(arguments.trevi, block.scene(rate))
        return {"set": kind, "steps_per_second": rate, "block": number, "rise": float(f"{rise:.3g}"),
                "counts": " ".join(map(str, block.counts)), "start": " ".join(map(str, block.start)),
                "velocity": " ".join(map(str, block.velocity)), "solid": " ".join(block.solid.split())}

    rows = list(in_turn(run, cases, arguments.jobs))
    write_table(arguments.output, rows)
    for kind in arguments.only or SETS:
        for rate in RATES:
            rises = [row["rise"] for row in rows if (row["set"], row["steps_per_second"]) == (kind, rate)]
            print(f"{kind}, 1/{rate} s: mean {statistics.mean(rises):.4f}, above 0.05 {sum(r > 0.05 for r in rises)} of "
                  f"{len(rises)}, largest {max(rises):.3g}")


if __name__ == "__main__":
    main()

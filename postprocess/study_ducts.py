#!/usr/bin/python3
"""Ducts that water fills, from an inlet with a profile to a drain with its flow: a uniform flow, and one through a throat.

  postprocess/study_ducts.py postprocess/results/ducts.csv

Without viscosity a uniform flow stays uniform; the first rows have the root mean square by which velocities differ from its own at
the end, over its speed, less than 1.6 m from the inlet of a duct of 2.4 m. In a duct of half the height in its middle, in two
dimensions, the pressure falls by what the speed there is above that before it, and comes back behind it (Bernoulli): pressures of
gauges from 3 s on, less that of the water's weight, Pa.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from study import GRAVITY, columns_of, launch, mean, parser_of, states_of, write_as_found

SPEED, HEIGHT, SECONDS = 0.5, 0.8, 6  # m/s; m; s
SCENE = """
[domain]
{domain}
[fluid]
spacing = {spacing}
[[particles]]
{water}
velocity = {velocity}
[time]
dt = {step!r}
end = {seconds}
[gravity]
[[inlet]]
type = "rectangle"
{inlet}
{speed}
[[drain]]
{drain}
flow = {flow}
{more}
[output.series]
every = 0.05
[output.checkpoint]
every = {seconds}
"""
SOLID = '[[obstacle]]\ntype = "box"\ncenter = [1.2, 0.2, {middle}]\nsize = [2.8, 0.8, {height}]\n'
FLOORS = {"below the ceiling": 0.0, "below a lid": 0.0, "between solids off the cells": 0.03}  # m


def uniform(cover, spacing, step, profile=True):
    floor = FLOORS[cover]
    top = floor + 0.4
    solids = "" if cover == "below the ceiling" else SOLID.format(middle=top + 0.3, height=0.6)
    if floor > 0:
        solids += SOLID.format(middle=floor - 0.3, height=0.6)
    return SCENE.format(
        domain=f"min = [0, 0, 0]\nmax = [2.4, 0.4, {0.8 if solids else 0.4}]", spacing=spacing, step=step, seconds=SECONDS,
        water=f"min = [0, 0, {floor}]\nmax = [2.4, 0.4, {top}]", velocity=[SPEED, 0, 0],
        inlet=f"center = [{spacing / 2}, 0.2, {floor + 0.2}]\nsize = [0.4, 0.4]\ndirection = [1, 0, 0]",
        speed=f'profile = "{SPEED}"' if profile else f"speed = {SPEED}",
        drain=f"min = [1.4, 0, {floor}]\nmax = [2.4, 0.4, {top}]", flow=SPEED * 0.16, more=solids)


def throat(spacing, step):
    gauges = "".join(f'[[gauge]]\ntype = "{kind}"\ncenter = [{x}, {z}]\n'
                     for x, z in ((0.6, 0.4), (2, 0.6), (3.4, 0.4)) for kind in ("pressure", "velocity"))
    return SCENE.format(
        domain=f"dimensions = 2\nmin = [0, 0]\nmax = [4, {HEIGHT}]", spacing=spacing, step=step, seconds=SECONDS,
        water=f"min = [0, 0]\nmax = [4, {HEIGHT}]", velocity=[SPEED, 0],
        inlet=f"center = [{spacing / 2}, {HEIGHT / 2}]\nsize = [{spacing}, {HEIGHT}]\ndirection = [1, 0]",
        speed=f'profile = "{SPEED}"', drain=f"min = [3.2, 0]\nmax = [4, {HEIGHT}]", flow=SPEED * HEIGHT * spacing,
        more='[[obstacle]]\ntype = "cylinder"\naxis = [0, 1, 0]\ncenter = [2, -0.6]\nradius = 1\n' + gauges)


def run(name, text, folder, trevi):
    scene, output = folder / f"{name}.toml", folder / name
    scene.write_text(text, encoding="utf-8")
    code, message = launch(trevi, scene, output, [], 3600)
    if code != 0:
        raise SystemExit(f"study_ducts.py: {name}: {message}")
    return output


def rows_of(case, folder, trevi):
    cover, spacing, rate, profile = case
    name = "_".join(str(part) for part in case).replace(" ", "_")
    known = {"case": f"uniform, {cover}" + ("" if profile else ", no profile") if cover in FLOORS else cover, "spacing": spacing,
             "steps_per_second": rate}
    if cover in FLOORS:
        output = run(name, uniform(cover, spacing, 1 / rate, profile), folder, trevi)
        place, velocity = states_of(output)[-1][:2]
        off = math.sqrt(((velocity[place[:, 0] < 1.6] - [SPEED, 0, 0])**2).sum(axis=1).mean()) / SPEED
        late = columns_of(output / "series.csv")["compression_mean"][20:]
        return [known | {"quantity": "velocities off, over the speed", "theory": 0, "measured": off},
                known | {"quantity": "mean compression", "theory": 0, "measured": mean(late)}]
    output = run(name, throat(spacing, 1 / rate), folder, trevi)
    gauges = {key: np.array(column) for key, column in columns_of(output / "gauges.csv").items()}
    late = gauges["time"] > 3
    pressure = [gauges[f"pressure_{n}"][late].mean() for n in (0, 2, 4)]
    before, inside = gauges["u_1"][late].mean(), gauges["u_3"][late].mean()
    drop = pressure[0] - pressure[1] - 1000 * GRAVITY * 0.2
    return [known | {"quantity": "drop of pressure, Pa", "theory": 500 * (inside**2 - before**2), "measured": drop},
            known | {"quantity": "of it, missing behind the throat, Pa", "theory": 0, "measured": pressure[0] - pressure[2]}]


def main():
    options = parser_of(__doc__, "CSV").parse_args()
    cases = [(cover, spacing, rate, True) for cover in FLOORS for spacing, rate in ((0.1, 60), (0.05, 60), (0.05, 240))]
    cases += [("below the ceiling", 0.05, 60, False)]
    cases += [("throat", spacing, rate, True) for spacing, rate in ((0.05, 60), (0.05, 240), (0.025, 60), (0.025, 240))]
    with tempfile.TemporaryDirectory() as folder:
        write_as_found(options.output, lambda case: rows_of(case, Path(folder), options.trevi), cases)


if __name__ == "__main__":
    main()

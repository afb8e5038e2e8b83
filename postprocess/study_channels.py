#!/usr/bin/python3
"""Channels with open ends for 100 s: a uniform flow, and steady flows over a bump and over two weirs, beside Bernoulli's
equation.

  postprocess/study_channels.py postprocess/results/channels.csv

In two dimensions, and one in a thin channel of three (40 s). An inlet brings a flow, a drain holds the level. One row for
each quantity: discharges are means over the last three fifths of the time, of all that left and through a section upstream;
levels too, in the mean over gauges. Drift is the level in the mean over the second half of that less that over the first.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from study import GRAVITY, columns_of, launch, parser_of, two_at_a_time, write_table

END, LATE, LENGTH = 100, 0.4, 8  # s, share of it, m
SCENE = """
[domain]
{dimensions}
min = [0, 0, 0]
max = [{length}, {wide}, 1.2]
[fluid]
spacing = {spacing}
[[particles]]
min = [0, 0, 0]
max = [{length}, {wide}, 0.7]
surface = "{surface}"
velocity = ["{start}", "0", "0"]
[gravity]
[time]
dt = {dt}
end = {end}
{obstacle}
[[inlet]]
type = "rectangle"
center = [{front}, {middle}, {half}]
size = [{wide}, {opening}]
direction = [1, 0, 0]
profile = "{speed}"
[[drain]]
min = [{drain}, 0, 0]
max = [{length}, {wide}, 1.2]
level = {level}
[output.series]
every_steps = 20
"""
HEIGHT = '[[gauge]]\ntype = "height"\ncenter = [{x}, {y}, {z}]\nradius = {radius}\n'
FLOW = '[[gauge]]\ntype = "flow"\ncenter = [2, {y}, 0.6]\nsize = [{wide}, 1.2]\nnormal = [1, 0, 0]\n'
ROUND = '[[obstacle]]\ntype = "cylinder"\ncenter = [4, {y}, {z}]\naxis = [0, 1, 0]\nradius = 1.5\n'
SQUARE = '[[obstacle]]\ntype = "box"\ncenter = [4, {y}, 0.15]\nsize = [0.2, 10, 0.3]\n'
CASES = {
    "uniform": {"speed": 0.5, "opening": 0.5, "level": 0.5},
    "uniform, three dimensions": {"speed": 0.5, "opening": 0.5, "level": 0.5, "spacing": 0.05, "wide": 0.2, "end": 40},
    "bump": {"speed": 0.6, "opening": 0.5, "level": 0.5, "crest": 0.15, "round": True},
    "round weir": {"speed": 0.25, "opening": 0.4, "level": 0.3, "crest": 0.3, "round": True},
    "square weir": {"speed": 0.25, "opening": 0.4, "level": 0.3, "crest": 0.3, "round": False},
}


def scene_of(case):
    spacing, wide = case.get("spacing", 0.025), case.get("wide")
    y = wide / 2 if wide else 0
    is_weir = case["level"] <= case.get("crest", 0)
    crest = case.get("crest", 0)
    if crest == 0:
        obstacle = ""
    else:
        obstacle = ROUND.format(y=y, z=crest - 1.5) if case["round"] else SQUARE.format(y=y)
    text = SCENE.format(
        dimensions="" if wide else "dimensions = 2", length=LENGTH, wide=wide or spacing, spacing=spacing, middle=y,
        dt=spacing / 3, end=case.get("end", END), obstacle=obstacle, front=spacing / 2, half=case["opening"] / 2,
        opening=case["opening"], speed=f"{case['speed']} * min(1, t/4)" if is_weir else case["speed"], level=case["level"],
        drain=LENGTH - 24 * spacing, surface=f"x < 4 ? {crest + 0.15} : {case['level']}" if is_weir else case["level"],
        start=0 if is_weir else case["speed"])
    places = [(x, 0, 0.1) for x in (1.5, 2, 2.5, 5.5, 6, 6.5)] + [(4, crest, 0.1)]
    gauges = "".join(HEIGHT.format(x=x, y=y, z=z, radius=radius) for x, z, radius in places)
    return text + gauges + FLOW.format(y=y, wide=2 * (wide or spacing))


def depth_of(head, discharge):
    """Of subcritical flow with that energy, m, above the floor; of critical flow where there is less."""
    critical = (discharge**2 / GRAVITY)**(1 / 3)
    low, high = critical, head
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if middle + discharge**2 / (2 * GRAVITY * middle**2) > head else (middle, high)
    return low


def upstream(case):
    """Level upstream and over the crest by Bernoulli, m."""
    discharge, level, crest = case["speed"] * case["opening"], case["level"], case.get("crest", 0)
    if level > crest:
        head = level + discharge**2 / (2 * GRAVITY * level**2)
        return level, crest + depth_of(head - crest, discharge) if crest else level
    if case["round"]:
        head = 1.5 * (discharge**2 / GRAVITY)**(1 / 3)  # the flow over the crest is critical
    else:
        low, high = 0.01, 1.0  # a crest 0.2 m long with sharp edges: Hager & Schwalt 1994
        for _ in range(60):
            head = (low + high) / 2
            ratio = (head / 0.2)**4
            runs = 0.326 * (1 + 9 / 7 * ratio) / (1 + ratio) * math.sqrt(2 * GRAVITY) * head**1.5
            low, high = (head, high) if runs < discharge else (low, head)
    return depth_of(crest + head, discharge), None


def measure(name, case, folder, trevi):
    scene, output = folder / f"{name.replace(' ', '_')}.toml", folder / name.replace(" ", "_")
    scene.write_text(scene_of(case), encoding="utf-8")
    code, message = launch(trevi, scene, output, [], 14400)
    if code != 0:
        raise SystemExit(f"study_channels.py: {name}: {message}")
    gauges = {key: np.array(column) for key, column in columns_of(output / "gauges.csv").items()}
    series = {key: np.array(column) for key, column in columns_of(output / "series.csv").items()}
    time, spacing, wide = gauges["time"], case.get("spacing", 0.025), case.get("wide")
    late, discharge = time > LATE * time[-1], case["speed"] * case["opening"]
    gone = (series["outflow"][-1] - series["outflow"][late][0]) * spacing**3 / (wide or spacing) / (time[-1] - time[late][0])
    section = gauges["flow_7"][late].mean() / (wide or spacing)
    before = np.mean([gauges[f"height_{k}"] for k in range(3)], axis=0)
    behind = np.mean([gauges[f"height_{k}"] for k in range(3, 6)], axis=0)
    over = case.get("crest", 0) + gauges["height_6"]
    level, top = upstream(case)
    half = (1 - LATE) / 2 * time[-1]
    drift = before[time > time[-1] - half].mean() - before[late & (time <= time[-1] - half)].mean()
    yield "discharge, all that leaves, m²/s", discharge, gone
    yield "discharge upstream, m²/s", discharge, section
    yield "level upstream, m", level, before[late].mean()
    if top is not None and case.get("crest"):
        yield "level over the crest, m", top, over[late].mean()
    yield "level downstream, m", case["level"], behind[late].mean()
    yield "drift of the level upstream, m", 0, drift


def main():
    args = parser_of(__doc__, "csv").parse_args()
    with tempfile.TemporaryDirectory() as folder:

        def work(case):
            return [{"case": case, "spacing": CASES[case].get("spacing", 0.025), "quantity": quantity, "theory": theory,
                     "measured": measured} for quantity, theory, measured in measure(case, CASES[case], Path(folder), args.trevi)]

        rows = []
        for some in two_at_a_time(work, CASES):
            rows += some
            for row in some:
                print(*row.values(), flush=True)
    write_table(args.output, rows)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""How high jets rise, against v²/2g above the nozzle (the top of the pump's cylinder): a sparse jet, whose faucet holds
all the water; a jet from a basin that ends at the nozzle; and one through a pool with 0.2 m of water above the nozzle.

Of each launched particle (one that is pumped: faster upwards than 0.8 v) the greatest height counts. Prints the
median and the 99th percentile of (height - nozzle) / (v²/2g), and draws them.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from study import GRAVITY, STRESS, in_turn, launch, parser_of  # noqa: E402
from trevi_run import Run  # noqa: E402

SPEEDS = (6, 8, 10, 12, 14)  # m/s
BASIN = ["particles.0.min=[0.0,0.0,0.0]", "density.precision='single'", "time.end=6.0"]
KINDS = {  # settings, and height of the nozzle, m
    "sparse": ([], 0.4),
    "basin": (["particles.0.max=[2.4,1.6,0.4]", *BASIN], 0.4),
    "pool": (["particles.0.max=[2.4,1.6,0.8]", "fountain.0.height=0.6", *BASIN], 0.6),
}


def greatest_heights(run, speed):
    """Height (m) that each launched particle reaches, by the frames of a run."""
    top, launched = None, None
    for frame in Run(run).vtkhdf:
        height, rise = frame.position[:, 2], frame.velocity[:, 2]
        if top is None:
            top, launched = height, np.zeros(len(height), bool)
        top, launched = np.maximum(top, height), launched | (rise > 0.8 * speed)
    return top[launched]


def ratios(trevi, kind, speed):
    """(height - nozzle) / (v²/2g) of each launched particle."""
    settings, nozzle = KINDS[kind]
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "run"
        code, message = launch(trevi, STRESS / "jet.toml", output, [f"fountain.0.speed={speed:.1f}", *settings], 200)
        if code != 0:
            sys.exit(f"{kind}, {speed} m/s: {message}")
        return (greatest_heights(output, speed) - nozzle) / (speed**2 / (2 * GRAVITY))


def draw(table, output):
    figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
    axes.axhline(1, color="0.35", linestyle="--", linewidth=1)
    for (kind, rows), colour in zip(table.items(), ("#0072B2", "#009E73", "#D55E00")):
        axes.plot(SPEEDS, [row[1] for row in rows], "o-", color=colour, label=f"{kind}, 99th percentile")
        axes.plot(SPEEDS, [row[0] for row in rows], "o:", color=colour, label=f"{kind}, median", markerfacecolor="none")
    axes.set(xlabel="pump speed v (m/s)", ylabel="rise / (v²/2g)")
    axes.legend(frameon=False, fontsize=8)
    axes.grid(color="0.9", linewidth=0.6)
    figure.savefig(output, dpi=110)


def main():
    arguments = parser_of(__doc__, "PNG").parse_args()
    table = {kind: [] for kind in KINDS}
    cases = [(kind, speed) for kind in KINDS for speed in SPEEDS]
    for (kind, speed), rise in zip(cases, in_turn(lambda case: ratios(arguments.trevi, *case), cases)):
        table[kind].append((np.median(rise), np.percentile(rise, 99)))
        print("{:6}  {:4} m/s  {:5} launched  median {:.3f}  99 % {:.3f}".format(kind, speed, len(rise), *table[kind][-1]))
    draw(table, arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

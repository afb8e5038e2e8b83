#!/usr/bin/python3
"""Waves on a current: in water that moves as a whole they neither grow nor die by that (Galilean invariance).

Waves 1 m long and 5 cm high go for 6 s through 4 m of a channel that repeats, 0.5 m deep, in two dimensions, with a spacing of
0.025 m: in still water, with a current and against one. The growth, 1/s, is that of a fit to the logarithm of the amplitude, which
is told by the first moments of the columns. The rows go to a CSV file.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

import trevi_run
from study import GRAVITY, in_turn, launch, parser_of, write_table

LENGTH, DEPTH, AMPLITUDE, SPACING = 1.0, 0.5, 0.025, 0.025  # m
RATES, CURRENTS = (60, 120, 240), (0.0, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0, 4.0, -4.0)  # steps a second; m/s


def scene_of(rate, current):
    k = 2 * math.pi / LENGTH
    speed = AMPLITUDE * math.sqrt(GRAVITY * k * math.tanh(k * DEPTH)) / math.sinh(k * DEPTH)
    return (f'[domain]\ndimensions = 2\nmin = [0, 0]\nmax = [4, 1]\nperiodic = ["x"]\n[fluid]\nspacing = {SPACING}\n'
            f'[[particles]]\nmin = [0, 0]\nmax = [4, 0.9]\nsurface = "{DEPTH} + {AMPLITUDE}*cos({k}*x)"\n'
            f'velocity = ["{current} + {speed}*cosh({k}*z)*cos({k}*x)", "0", "{speed}*sinh({k}*z)*sin({k}*x)"]\n'
            f"[time]\ndt = {1 / rate!r}\nend = 6.0\n[gravity]\n[output.series]\n[output.checkpoint]\nevery = 0.1\nkeep = 100\n")


def measure(trevi, rate, current):
    with tempfile.TemporaryDirectory() as folder:
        scene, output = Path(folder) / "scene.toml", Path(folder) / "run"
        scene.write_text(scene_of(rate, current), encoding="utf-8")
        code, message = launch(trevi, scene, output, [], time_limit=600)
        if code != 0:
            raise SystemExit(message)
        states = trevi_run.Run(output).checkpoints
        times = np.array(states.times)
        # The first moment of a column is half the square of its level.
        mode = np.array([abs((state.position[:, 2] * np.exp(2j * math.pi * state.position[:, 0] / LENGTH)).sum()) for state in states])
    late = times > 0.5  # what the lattice at the start is not has gone
    growth = np.polyfit(times[late], np.log(mode[late]), 1)[0]
    return {"steps_per_second": rate, "current": current, "cells_per_step": round(abs(current) / rate / (2 * SPACING), 3),
            "growth": round(float(growth), 3)}


def main():
    arguments = parser_of(__doc__, "CSV").parse_args()
    rows = []
    for row in in_turn(lambda case: measure(arguments.trevi, *case), [(rate, current) for rate in RATES for current in CURRENTS]):
        rows.append(row)
        print(row, flush=True)
    write_table(arguments.output, rows)


if __name__ == "__main__":
    main()

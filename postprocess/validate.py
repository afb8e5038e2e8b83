#!/usr/bin/python3
"""Compares runs with what is known: free fall, height of a column, momentum, and the front of the breaking dam.

The front (front, and its 99th percentile front_q99) stands against the experiments in results/dam_break.csv: RMS of the
relative error raw, and after one shift |dT| <= 0.3 of the time axis, which stands for the release of the gate, without
and with friction of the floor. The order of convergence comes from three spacings, and from time steps against an eighth
of the longest with 32 iterations. Figures go to standard output, the drawing to the PNG.
"""

import csv
import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from study import GRAVITY, ROOT, STRESS, energies, parser_of, simulate  # noqa: E402

SPACINGS = {0.1: 1 / 75, 0.05: 1 / 150, 0.025: 1 / 300}  # m, with their dt, s
FRICTIONS = (0, 0.02, 0.04)  # walls.floor_friction
LONGEST_STEP = 1 / 40  # s, at spacing 0.05
TIME_SCALE = math.sqrt(2 * GRAVITY)  # T = t sqrt(2 g / a), a = 1 m


def experiments():
    with open(ROOT / "postprocess/results/dam_break.csv", newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return {name: np.array([[float(row["T"]), float(row["Z"])] for row in rows if row["series"] == name])
            for name in dict.fromkeys(row["series"] for row in rows)}


def relative_rms(data, time, front, shift=0.0):
    """Of the points that the run reaches before the far wall."""
    points = data[(data[:, 1] < 4.6) & (data[:, 0] + shift <= time[-1]) & (data[:, 0] + shift >= 0)]
    return float(np.sqrt(np.mean((np.interp(points[:, 0] + shift, time, front) / points[:, 1] - 1) ** 2)))


def best_shift(data, time, front):
    return min(np.linspace(-0.3, 0.3, 121), key=lambda shift: relative_rms(data, time, front, shift))


def dam_break(trevi, spacing, dt, *settings):
    keys = [f"fluid.spacing={spacing}", f"time.dt={dt!r}", "domain.max=[5.0,0.2,3.0]", "time.end=0.96", *settings]
    columns, code, message = simulate(trevi, STRESS / "dam_break.toml", keys, 400)
    if code != 0:
        sys.exit(f"dam break with {' '.join(keys)}: {message}")
    return columns


def dam_breaks(trevi, friction):
    return {spacing: dam_break(trevi, spacing, dt, f"walls.floor_friction={friction}")
            for spacing, dt in SPACINGS.items()}


def report_dam(runs, data, friction):
    print(f"floor friction {friction}")
    print("spacing  column     experiment           raw RMS  shift dT  RMS after")
    for spacing, columns in runs.items():
        time = np.array(columns["time"]) * TIME_SCALE
        for name in ("front", "front_q99"):
            # Particles are the middles of their cells.
            front = np.array(columns[name]) + spacing / 2
            for experiment, points in data.items():
                shift = best_shift(points, time, front)
                print(f"{spacing:<7}  {name:9}  {experiment:19}  {relative_rms(points, time, front):7.3f}  {shift:+8.3f}"
                      f"  {relative_rms(points, time, front, shift):9.3f}")


def report_convergence(runs):
    """Order from three spacings that halve, of the front over time up to T = 3.2."""
    time = np.linspace(0, 3.2 / TIME_SCALE, 65)
    for name in ("front", "front_q99"):
        coarse, middle, fine = (np.interp(time, run["time"], np.array(run[name]) + spacing / 2)
                                for spacing, run in runs.items())
        first, second = (float(np.sqrt(np.mean(d**2))) for d in (coarse - middle, middle - fine))
        print(f"{name}: RMS change {first:.4f} m, then {second:.4f} m: order {math.log2(first / second):.2f}")


def report_time_steps(trevi):
    """RMS over T up to 3.2 against an eighth of the longest step and 32 iterations."""
    time = np.linspace(LONGEST_STEP, 3.2 / TIME_SCALE, 28)
    reference = dam_break(trevi, 0.05, LONGEST_STEP / 8, "density.iterations=32")
    for iterations in (4, 32):
        for parts in (1, 2, 4):
            run = dam_break(trevi, 0.05, LONGEST_STEP / parts, f"density.iterations={iterations}")
            off = {name: math.sqrt(np.mean((np.interp(time, run["time"], run[name]) - np.interp(
                time, reference["time"], reference[name])) ** 2)) for name in ("front", "front_q99", "com_x", "com_z")}
            print(f"dt {1e3 * LONGEST_STEP / parts:.2f} ms, {iterations} iterations, against dt/8: " +
                  ", ".join(f"{name} {1e3 * value:.1f} mm" for name, value in off.items()))


def report_simple(trevi):
    fall, _, _ = simulate(trevi, STRESS / "few.toml", ["time.end=0.4"])
    exact = [fall["com_z"][0] - GRAVITY * t * t / 2 for t in fall["time"]]
    print(f"free fall: off the parabola by {max(abs(a - b) for a, b in zip(fall['com_z'], exact)):.1e} m")
    for keys in ([], ["viscosity.c=0.001"]):
        column, _, _ = simulate(trevi, STRESS / "column.toml", keys)
        energy = energies(column)
        sway = max(math.hypot(x, y) for x, y in zip(column["momentum_x"], column["momentum_y"])) / 16000
        print(f"column {' '.join(keys) or 'inviscid'}: height {2 * column['com_z'][-1]:.3f} m of 4, energy at the end "
              f"{100 * (energy[-1] / energy[0] - 1):+.2f} %, mean velocity sideways at most {sway:.1e} m/s")
    plain = ["density.coarse_grid=false"]
    for mode, less in (("double", []), ("single", []), ("double", plain), ("double", [*plain, "density.max_shift=0.0"])):
        # In the air nothing but gravity may change the momentum; two blocks collide there.
        clash = ["domain.max=[6.0,6.0,9.0]", "particles.0.min=[2.0,2.5,6.0]", "particles.0.max=[3.0,3.5,7.0]",
                 "particles.1.min=[3.1,2.5,6.0]", "particles.1.max=[4.1,3.5,7.0]", "particles.0.velocity=[5.0,0.0,0.0]",
                 f"density.precision={mode}", "time.end=0.5", *less]
        run, _, _ = simulate(trevi, STRESS / "overlap.toml", clash)
        drift = max(abs(p - run["momentum_x"][0]) for p in run["momentum_x"]) / run["momentum_x"][0]
        print(f"blocks colliding in the air, {' '.join([mode, *less])}: momentum along x changes by {drift:.1e} of "
              "itself")


def draw(runs, data, output):
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    for (spacing, run), shade in zip(runs.items(), ("0.7", "#56B4E9", "#0072B2")):
        time = np.array(run["time"]) * TIME_SCALE
        left.plot(time, np.array(run["front"]) + spacing / 2, ":", color=shade)
        left.plot(time, np.array(run["front_q99"]) + spacing / 2, color=shade, label=f"spacing {spacing} m")
        energy = np.array(energies(run))
        right.plot(run["time"], energy / energy[0], color=shade, label=f"spacing {spacing} m")
    for (name, points), mark in zip(data.items(), "os"):
        left.plot(points[:, 0], points[:, 1], mark, color="#D55E00", markersize=4, markerfacecolor="none",
                  label=name.replace("_", " "))
    left.set(xlabel="T = t √(2g/a)", ylabel="front / a (dotted: foremost particle)", xlim=(0, 4.3), ylim=(0.9, 5.2))
    right.set(xlabel="time (s)", ylabel="total energy / start")
    for panel in (left, right):
        panel.legend(frameon=False)
        panel.grid(color="0.9", linewidth=0.6)
    figure.savefig(output, dpi=110)


def main():
    arguments = parser_of(__doc__, "PNG").parse_args()
    report_simple(arguments.trevi)
    data = experiments()
    runs = {friction: dam_breaks(arguments.trevi, friction) for friction in FRICTIONS}
    for friction in FRICTIONS:
        report_dam(runs[friction], data, friction)
    report_convergence(runs[0])
    report_time_steps(arguments.trevi)
    draw(runs[0], data, arguments.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())

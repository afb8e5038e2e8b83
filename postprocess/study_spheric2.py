#!/usr/bin/python3
"""A dam that breaks and meets a box, against the experiment: inputs/dam_break_obstacle.toml at several spacings.

What the gauges of the scene show, in means over 0.02 s, goes to a CSV file, and beside it a picture with the points of the
experiment. Its heights and pressures are those that MARIN measured (Kleefsman et al. 2005, J. Comput. Phys. 206, 363-393), as
SPHERIC and ERCOFTAC give them away for their test case 2 (Issa & Violeau 2006, test_case_2_exp_data.xls); a few rows of it.
SPACING=FOLDER takes a run that is there already.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from study import ROOT, columns_of, in_turn, launch, parser_of, write_table  # noqa: E402

SCENE = ROOT / "inputs/dam_break_obstacle.toml"
WINDOW = 0.02  # s
DT = 1 / 300 / 0.025  # s per m of spacing
HEIGHTS = {"H1": 0, "H2": 1, "H3": 2, "H4": 3}  # numbers of the gauges
PRESSURES = {f"P{k}": k + 3 for k in range(1, 9)}
# s, and m; the columns of the file, whose first is the gauge nearest to the column of water, are put in this order.
MEASURED_HEIGHTS = {
    "H1": ((0.44, 0.001), (1.0, 0.151), (2.0, 0.288), (3.0, 0.229), (4.0, 0.162), (5.01, 0.172)),
    "H2": ((0.40, 0.046), (0.44, 0.075), (1.0, 0.179), (2.0, 0.287), (3.0, 0.203), (4.0, 0.136), (5.01, 0.250)),
    "H3": ((0.194, 0.010), (0.22, 0.024), (0.25, 0.050), (0.40, 0.099), (0.44, 0.100), (1.0, 0.155), (2.0, 0.142),
           (3.0, 0.238), (4.0, 0.174), (5.01, 0.204)),
    "H4": ((0.10, 0.534), (0.20, 0.511), (0.25, 0.500), (0.40, 0.459), (0.44, 0.447), (1.0, 0.279), (2.0, 0.130),
           (3.0, 0.202), (4.0, 0.331), (5.01, 0.232)),
}
# s, and Pa.
MEASURED_PRESSURES = {
    "P1": ((0.390, 0), (0.396, 5200), (0.408, 10820), (0.415, 11240), (0.425, 9200), (0.440, 8620), (0.450, 8060),
           (0.460, 7830), (0.470, 7390)),
    "P2": ((0.405, 0), (0.411, 2000), (0.420, 5620), (0.426, 8130), (0.435, 7490), (0.450, 7400), (0.460, 7320),
           (0.470, 6850)),
    "P3": ((0.420, 0), (0.428, 4410), (0.440, 5460), (0.450, 6180), (0.459, 6560), (0.470, 6160)),
    "P4": ((0.427, 0), (0.434, 1860), (0.445, 3820), (0.450, 6780), (0.455, 7200), (0.463, 7140), (0.470, 6250)),
}


def gauges_of(trevi, name):
    """Columns of gauges.csv of a run at that spacing."""
    spacing = float(name)
    radius = max(0.04, spacing)  # m, of a gauge of pressure: a spacing at least
    settings = [f"fluid.spacing={spacing!r}", f"time.dt={DT * spacing!r}", "output.vtu.every=10",
                *(f"gauge.{k}.radius={radius!r}" for k in PRESSURES.values())]
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "run"
        code, message = launch(trevi, SCENE, output, settings, time_limit=36000)
        if code != 0:
            raise SystemExit(message)
        return columns_of(output / "gauges.csv")


def column(columns, gauge):
    name = f"height_{HEIGHTS[gauge]}" if gauge in HEIGHTS else f"pressure_{PRESSURES[gauge]}"
    return np.array(columns[name])


def in_windows(columns):
    """Middles of the windows, s, and the mean of each gauge in them."""
    time = np.array(columns["time"])
    window = (time[1:] / WINDOW - 1e-9).astype(int)
    counts = np.bincount(window)
    means = {gauge: np.bincount(window, column(columns, gauge)[1:]) / counts for gauge in [*HEIGHTS, *PRESSURES]}
    return (np.arange(len(counts)) + 0.5) * WINDOW, means


def first_above(columns, gauge, threshold):
    above = np.flatnonzero(column(columns, gauge) > threshold)
    return columns["time"][above[0]] if len(above) else float("nan")


def tell(name, columns):
    time = np.array(columns["time"])
    print(f"spacing {name} m: H3 over 0.01 m at {first_above(columns, 'H3', 0.01):.3f} s, "
          f"P1 over 1 kPa at {first_above(columns, 'P1', 1000):.3f} s")
    for gauge, points in MEASURED_HEIGHTS.items():
        ours = np.interp([t for t, _ in points], time, column(columns, gauge))
        print(f"  {gauge}", ", ".join(f"{t:g} s {value:.3f} ({there:.3f})" for value, (t, there) in zip(ours, points)))
    middle, means = in_windows(columns)
    early = time < 1
    for gauge in PRESSURES:
        p = column(columns, gauge)
        print(f"  {gauge} largest before 1 s {p[early].max():.0f} Pa, of the windows {means[gauge][middle < 1].max():.0f}; "
              f"mean from 0.45 to 0.55 s {p[(time > 0.45) & (time < 0.55)].mean():.0f}, "
              f"from 1 to 3 s {p[(time > 1) & (time < 3)].mean():.0f}")


def draw(runs, path):
    figure, axes = plt.subplots(2, 6, figsize=(20, 7), constrained_layout=True)
    places = dict(zip([*HEIGHTS, *PRESSURES], axes.T.ravel()))
    for gauge, axis in places.items():
        is_height = gauge in HEIGHTS
        for name, columns in runs.items():
            time, means = in_windows(columns)
            axis.plot(time, means[gauge] / (1 if is_height else 1000), linewidth=1, label=f"Trevi, {name} m")
        points = MEASURED_HEIGHTS.get(gauge) or MEASURED_PRESSURES.get(gauge)
        if points:
            axis.plot([t for t, _ in points], [v / (1 if is_height else 1000) for _, v in points], "k.", label="experiment")
        if not is_height:
            axis.set_xlim(0.3, 1.5)
            axis.set_ylim(-0.5, 13)
        axis.set_title(gauge)
        axis.set_xlabel("s")
        axis.set_ylabel("m" if is_height else "kPa")
    axes[0, 0].legend(fontsize=8)
    figure.savefig(path, dpi=70)


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("cases", nargs="*", default=["0.05", "0.025"], help="spacings, m, or spacing=folder of a run")
    arguments = parser.parse_args()
    runs = {}

    def columns_of_case(case):
        name, _, folder = case.partition("=")
        return name, columns_of(Path(folder) / "gauges.csv") if folder else gauges_of(arguments.trevi, name)

    for name, columns in in_turn(columns_of_case, arguments.cases):
        runs[name] = columns
        tell(name, columns)
        sys.stdout.flush()
    rows = []
    for name, columns in runs.items():
        time, means = in_windows(columns)
        rows += [{"spacing": name, "time": round(t, 3), **{g: round(v[k], 4 if g in HEIGHTS else 0) for g, v in means.items()}}
                 for k, t in enumerate(time)]
    write_table(arguments.output, rows)
    draw(runs, arguments.output.with_suffix(".png"))


if __name__ == "__main__":
    main()

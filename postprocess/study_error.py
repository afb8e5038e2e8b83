#!/usr/bin/python3
"""Errors and run time of the density methods over seven scenes; rows go to a CSV file for work_precision.py.

cube, column, dam_break, fountain   compression: the time mean of compression_mean, row 0 left out
wave   10 layers in 4 m, 10 s: half-period against linear theory, loss, tilt left standing, energy
pool   10 disturbed layers, 10 s: motion and centre of mass in the last 5 s, energy
jets   two that collide without gravity: linear and angular momentum

Methods x iterations, then one factor at a time around the default: dt, substeps, precision, walls, viscosity. Run times
are medians: all runs take turns, so that a slow minute of the machine meets them all, and only ratios within one file
mean anything. cpu_seconds is the least that a turn took of the processor, start and output included: steadier than wall
time where others are at work.

--kernels compares smoothing kernels instead, at several radii: Spiky (the default) and Wendland's C2.
"""

import resource
import statistics
import sys

from known_water import STATES, Tank, figures_of, jets, pool, wave
from study import (PLAIN_JACOBI, REPORT, STRESS, energies, energy_gain, in_turn, mass_of, mean, parser_of, simulate_states,
                   write_table)

METHODS = {
    "report's Jacobi": REPORT,
    "plain Jacobi": PLAIN_JACOBI,
    "Jacobi 0.5, walls": ["density.method=jacobi", "density.relaxation=0.5"],
    "Chebyshev alone": ["density.coarse_grid=false"],
    "Anderson": ["density.method=anderson"],
    "default": [],
    "default, Poly6": ["fluid.density_kernel=poly6"],
    "default, Wendland": ["fluid.density_kernel=wendland_c2"],
}
KERNELS = {"Spiky": [], "Wendland": ["fluid.density_kernel=wendland_c2"]}
RATIOS = (2, 2.5)  # kernel radius over spacing
SCENES = ("cube", "column", "dam_break", "fountain", "wave", "pool", "jets")
KNOWN = {"wave": wave(Tank(10, 4.0, 0.6, seconds=10.0), 0.5), "pool": pool(Tank(10, seconds=10.0), 0.05), "jets": jets()}
FIGURES = ("period_ratio", "loss_per_half", "wave_left", "tilt_left", "rest_kinetic_per_mass", "rest_com_error",
           "later_gain", "momentum_error", "angular_error")
CLAIMED = ("report's Jacobi", "plain Jacobi", "default", "default, Poly6")
SPACING = {"dam_break": 0.05}
# Exact height of the centre of mass at the end where there is one, m: the lattice's own for the column at rest.
EXACT = {"column": 2.0}


def settings_of(scene, all_iterations):
    """(name, iterations, keys) of the runs of a scene."""
    runs = [(name, n, [*keys, f"density.iterations={n}"]) for n in all_iterations for name, keys in METHODS.items()
            if name != "Anderson" or n <= 8]
    dt = 1 / 150 if scene == "dam_break" else 1 / 60
    runs += [("default, 2 dt", 3, [f"time.dt={2 * dt!r}"]), ("default, dt/2", 3, [f"time.dt={dt / 2!r}"]),
             ("default, cfl 0.2", 3, ["time.cfl=0.2"]), ("default, double", 3, ["density.precision=double"]),
             ("default, no walls", 3, ["walls.density=none"]), ("default, nu 0.002", 3, ["viscosity.nu=0.002"])]
    return runs


def settings_of_kernels(scene, all_iterations):
    """The same, of each kernel at each radius."""
    spacing = SPACING.get(scene, 0.1)
    return [(f"{name}, h = {ratio}", n, [*keys, f"fluid.kernel_radius={ratio * spacing:g}", f"density.iterations={n}"])
            for n in all_iterations for ratio in RATIOS for name, keys in KERNELS.items()]


def known_figures(scene, columns, states):
    """Those of FIGURES that the scene has; empty text for the others."""
    figures = figures_of(columns, states, KNOWN[scene]) if scene in KNOWN else {}
    if scene == "pool":
        figures |= {f"rest_{name}": figures[name] for name in ("kinetic_per_mass", "com_error")}
    return {name: figures.get(name, "") for name in FIGURES}


def row_of(scene, name, iterations, columns, code):
    spacing = SPACING.get(scene, 0.1)
    half = len(columns["step"]) // 2
    mass = mass_of(columns, spacing)
    return {"scene": scene, "method": name, "iterations": iterations, "exit": code,
            "compression_mean": mean(columns["compression_mean"][1:]), "compression_peak": max(columns["compression_mean"]),
            "compression_max": max(columns["compression_max"]), "compression_start": columns["compression_max"][0],
            "compression_ten_steps": max(columns["compression_max"][:11]),
            "com_z": columns["com_z"][-1], "com_error": columns["com_z"][-1] / EXACT[scene] - 1 if scene in EXACT else "",
            "kinetic_per_mass": max(columns["kinetic_energy"][half:]) / mass, "energy_gain": energy_gain(columns, spacing),
            "energy_end": energies(columns)[-1] / energies(columns)[0],
            "substeps": mean(columns["substeps"][1:]), "wall_seconds": columns["wall_seconds"][-1]}


def cpu_seconds():
    """Of all runs so far."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(trevi, scene, keys):
    if scene not in KNOWN:
        return simulate_states(trevi, STRESS / f"{scene}.toml", keys)
    water = KNOWN[scene]
    states = [] if water.layers else STATES
    return simulate_states(trevi, water.path, [*water.settings, *states, *keys], cloud=water.cloud)


def measure(arguments, scene):
    """Rows of a scene; those with 3, 4 or 8 iterations of the methods of the claims are timed `rounds` times, those of
    kernels all."""
    trevi, rows, times, processor = arguments.trevi, {}, {}, {}
    settings = settings_of_kernels if arguments.kernels else settings_of

    def timed(case):
        before = cpu_seconds()
        found = run(trevi, scene, case[2])
        return cpu_seconds() - before, *found

    for turn in range(arguments.rounds):
        cases = [(name, iterations, keys) for name, iterations, keys in settings(scene, arguments.iterations)
                 if turn == 0 or arguments.kernels or (name in CLAIMED and iterations in (3, 4, 8))]
        for (name, iterations, _), (spent, columns, states, code, message) in zip(cases, in_turn(timed, cases)):
            if len(columns.get("step", ())) < 2:
                print(f"{scene}, {name}, {iterations}: {message}", file=sys.stderr)
                continue
            rows[name, iterations] = row_of(scene, name, iterations, columns, code) | known_figures(scene, columns, states)
            times.setdefault((name, iterations), []).append(columns["wall_seconds"][-1])
            processor[name, iterations] = min(spent, processor.get((name, iterations), spent))
    for key, row in rows.items():
        row["wall_seconds"] = round(statistics.median(times[key]), 3)
        row["cpu_seconds"] = round(processor[key], 3)
        known = [f"{figure} {row[figure]:.3g}" for figure in FIGURES if row[figure] != ""]
        print(scene, *key, f"{row['compression_mean']:.3e}", row["wall_seconds"], row["cpu_seconds"], *known, sep="  ", flush=True)
    return list(rows.values())


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--scene", action="append", choices=SCENES, help="default: all")
    parser.add_argument("--iterations", type=int, nargs="+", default=[2, 3, 4, 8, 16], metavar="N")
    parser.add_argument("--rounds", type=int, default=3, help="timings of the runs compared in the page")
    parser.add_argument("--kernels", action="store_true", help="smoothing kernels instead of methods")
    arguments = parser.parse_args()
    rows = [row for scene in arguments.scene or SCENES for row in measure(arguments, scene)]
    write_table(arguments.output, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())

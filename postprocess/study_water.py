#!/usr/bin/python3
"""Does the water behave as water? Waves, still pools, wells, momentum and viscosity, each against a mark it must meet.

waves      closed tanks, first mode (and both together in a square one), started with linear theory's velocities
pools      at rest for 20 s: layers, time steps, kernel radii, lattices and disturbed lattices
wells      narrow and deep
momentum   jets that collide and a ball that turns, without gravity
viscosity  what [viscosity] nu does to a disturbed pool and to a wave; names the least that calms without damping

Marks: waves: first half-periods within 2 % of omega² = g k tanh(k d) in the mean; at most 10 % lost in each from 10
layers, 5 % from 40; the tilt about which it swings in the last two periods below 2 % of the first swing. Pools: kinetic
energy per mass of the last 5 s at most 1e-3 m²/s², and at 1/480 s at most 1.5 times that at 1/60 s (or 1e-4, if that is
more). Both: centre of mass within 0.5 % or 0.1 spacings, total energy never above its start by more than 0.1 % of
max(E0, m g h N). Wells: energy within 0.2 %, centre of mass within 1 %. A disturbed lattice starts compressed, which
its first steps turn into motion: its energy is judged against that at 1 s (later_gain), and energy_gain tells the rest.
Momentum within 1e-6 of sum |m v|, angular momentum of sum |m r||v|. Viscosity: 1e-5 m²/s², 15 % lost. A free wave of
little loss still sways at the end: wave_left is that, tilt_left what does not swing back.
The rows go to a CSV file; plot_water.py draws them.
"""

import math
import sys
from typing import NamedTuple

from known_water import STATES, Tank, Water, figures_of, jets, pool, turning_ball, wave
from study import parser_of, simulate_states, two_at_a_time, write_table

PARAMETERS = ("layers", "length", "ratio", "steps_per_second", "amplitude", "nu")
FIGURES = ("period_ratio", "loss_per_half", "wave_left", "tilt_left", "kinetic_per_mass", "kinetic_over_60",
           "com_error", "com_error_spacings", "energy_gain", "later_gain", "momentum_error", "angular_error",
           "compression_start", "compression_mean")
WAVE_MARKS = {"period": lambda f: abs(f["period_ratio"] - 1) <= 0.02, "tilt": lambda f: f["tilt_left"] < 0.02}
STILL_MARKS = {"com": lambda f: abs(f["com_error"]) <= 0.005 or abs(f["com_error_spacings"]) <= 0.1,
               "energy": lambda f: f["energy_gain"] <= 0.001}
POOL_MARKS = STILL_MARKS | {"motion": lambda f: f["kinetic_per_mass"] <= 1e-3}
WELL_MARKS = {"com": lambda f: abs(f["com_error"]) <= 0.01, "energy": lambda f: f["energy_gain"] <= 0.002}
AIR_MARKS = {"momentum": lambda f: f["momentum_error"] <= 1e-6, "angular": lambda f: f["angular_error"] <= 1e-6,
             "energy": lambda f: f["energy_gain"] <= 0.001}
NO_LATER_GAIN = {"energy": lambda f: f["later_gain"] <= 0.001}
CALM = {"motion": lambda f: f["kinetic_per_mass"] <= 1e-5}
LITTLE_LOST = {"loss": lambda f: f["loss_per_half"] <= 0.15}
STEADY = {"steady": lambda f: f["kinetic_over_60"] <= 1.5}
VISCOSITIES = (0.0, 3e-4, 1e-3, 2e-3, 4e-3, 8e-3, 1.6e-2)  # m²/s


class Case(NamedTuple):
    group: str
    name: str
    water: Water
    marks: dict
    parameters: dict  # what the drawing sorts by
    settings: tuple = ()


def wave_case(tank, amplitude, diagonal=False, group="waves"):
    max_lost = 0.05 if tank.layers >= 40 else 0.10 if tank.layers >= 10 else math.inf
    marks = WAVE_MARKS | STILL_MARKS | {"loss": lambda f: f["loss_per_half"] <= max_lost}
    name = (f"{'square, diagonal, ' if diagonal else ''}{tank.layers} layers, {tank.length:g} m, A {amplitude:g}, "
            f"h {tank.ratio:g}, 1/{tank.steps_per_second:g} s")
    return Case(group, name, wave(tank, amplitude, diagonal), marks, parameters_of(tank) | {"amplitude": amplitude})


def parameters_of(tank):
    return {"layers": tank.layers, "length": tank.length, "ratio": tank.ratio, "steps_per_second": tank.steps_per_second}


def waves():
    tank = Tank(10, 4, 0.6)
    for layers in (5, 10, 20, 40):
        for ratio in (2, 2.5, 3):
            for amplitude in (1, 0.5, 0.25):
                yield wave_case(tank._replace(layers=layers, ratio=ratio), amplitude)
    for ratio, amplitudes in ((2, (1, 0.5, 0.25)), (2.5, (0.5,)), (3, (0.5,))):
        for amplitude in amplitudes:
            yield wave_case(tank._replace(layers=40, length=8, ratio=ratio), amplitude)
    for rate in (30, 120, 240):
        yield wave_case(tank._replace(steps_per_second=rate), 0.5)
    for ratio in (2, 2.5, 3):
        yield wave_case(Tank(10, 2, 2, ratio=ratio), 0.5, diagonal=True)


def pool_case(tank, jitter=0.0, marks=POOL_MARKS, group="pools", name=""):
    text = f"{tank.layers} layers, {tank.length:g} m, h {tank.ratio:g}, 1/{tank.steps_per_second:g} s"
    if jitter:
        group = f"{group}, disturbed"
        marks = marks | NO_LATER_GAIN if "energy" in marks else marks
    return Case(group, name or text, pool(tank, jitter), marks, parameters_of(tank))


def pools():
    for layers in (3, 4, 5, 7, 9, 10, 15, 20, 40, 80, 200):
        yield pool_case(Tank(layers, *(0.6, 0.6) if layers >= 40 else (1.0, 1.0)))
    for jitter in (0, 0.05):
        for layers in (5, 9, 10):
            for rate in (30, 60, 120, 240, 480):
                if jitter or (rate != 60 and layers != 9):
                    yield pool_case(Tank(layers, steps_per_second=rate), jitter)
    for jitter in (0, 0.05):
        for ratio in (1.5, 2.5, 3, 4):
            for layers in (5, 10, 15):
                yield pool_case(Tank(layers, 1.2, 1.2, ratio=ratio), jitter)
    for layers in (3, 4, 7, 15, 20, 40):
        yield pool_case(Tank(layers, *(0.6, 0.6) if layers >= 40 else (1.0, 1.0)), 0.05)
    for side in (0.9, 1.1):
        for layers in (5, 10):
            yield pool_case(Tank(layers, side, side), 0.05)


def wells():
    for width in (2, 4, 10):
        for layers in (40, 100, 250):
            for jitter in (0, 0.05):
                name = f"{width} spacings wide, {layers} layers"
                yield pool_case(Tank(layers, width / 10, width / 10), jitter, WELL_MARKS, "wells", name)


def in_the_air():
    for make, name in ((jets, "two jets"), (turning_ball, "turning ball")):
        for ratio, rate in ((2, 60), (2, 240), (2, 960), (2.5, 60), (3, 60)):
            parameters = {"layers": 0, "ratio": ratio, "steps_per_second": rate}
            yield Case("momentum", f"{name}, h {ratio}, 1/{rate} s", make(ratio, rate), AIR_MARKS, parameters, tuple(STATES))


def viscous():
    for nu in VISCOSITIES:
        keys = (f"viscosity.nu={nu!r}",) if nu else ()
        for rate in (60, 240):
            tank = Tank(10, steps_per_second=rate)
            case = pool_case(tank, 0.05, CALM, name=f"pool of 10 layers, 1/{rate} s, nu {nu:g}")
            yield case._replace(group="viscosity", settings=keys, parameters=case.parameters | {"nu": nu})
        case = wave_case(Tank(10, 4, 0.6), 0.5, group="viscosity")
        yield case._replace(name=f"wave of 10 layers, nu {nu:g}", marks=LITTLE_LOST, settings=keys,
                            parameters=case.parameters | {"nu": nu})


def all_cases():
    return [*waves(), *pools(), *wells(), *in_the_air(), *viscous()]


def row_of(case, columns, states, code, message):
    row = {"group": case.group, "name": case.name, "verdict": "fail", "failed": "run"}
    row |= {name: case.parameters.get(name, "") for name in PARAMETERS}
    row |= dict.fromkeys(FIGURES, "")
    row |= {"settings": " ".join([*case.water.settings, *case.settings]), "wall_seconds": "",
            "message": message.splitlines()[-1][:200] if code != 0 and message else ""}
    if code == 0 and len(columns.get("step", ())) > 1:
        figures = figures_of(columns, states, case.water)
        row |= figures | judged(case.marks, figures) | {"wall_seconds": columns["wall_seconds"][-1]}
    return row


def judged(marks, figures):
    failed = [name for name, holds in marks.items() if not holds(figures)]
    return {"verdict": "fail" if failed else "pass", "failed": " ".join(failed)}


def steadiness(rows):
    """Judges the pools at 1/480 s by those at 1/60 s, which only the whole table has. Motion of a tenth of its mark is rest,
    whatever the ratio."""
    pools_of = {(row["group"], row["layers"], row["length"], row["ratio"], row["steps_per_second"]): row for row in rows
                if row["group"].startswith("pools") and row["kinetic_per_mass"] != ""}
    for (*kind, rate), row in pools_of.items():
        slow = pools_of.get((*kind, 60))
        if rate != 480 or slow is None:
            continue
        row["kinetic_over_60"] = row["kinetic_per_mass"] / max(slow["kinetic_per_mass"], 1e-4)
        row["failed"] = " ".join(filter(None, [row["failed"], judged(STEADY, row)["failed"]]))
        row["verdict"] = "fail" if row["failed"] else "pass"


def min_viscosity(rows, rates):
    """The least nu of which all rows at these steps per second pass, m²/s; none: there is no such nu."""
    rows = [row for row in rows if row["group"] == "viscosity" and row["steps_per_second"] in rates]
    calm = [nu for nu in VISCOSITIES if all(row["verdict"] == "pass" for row in rows if row["nu"] == nu)]
    return calm[0] if calm else "none"


def rounded(row):
    return {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in row.items()}


def tell(row):
    shown = rounded(row)
    figures = "  ".join(f"{name} {shown[name]}" for name in FIGURES if shown[name] != "")
    print(row["group"], row["name"], row["verdict"], row["failed"] or row["message"], figures, sep="  ", flush=True)


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose group and name hold TEXT")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="in all runs, to try a remedy")
    parser.add_argument("--time-limit", type=float, default=400, metavar="S", help="of one run (default: %(default)s)")
    arguments = parser.parse_args()

    def run(case):
        settings = [*case.water.settings, *case.settings, *arguments.set]
        return row_of(case, *simulate_states(arguments.trevi, case.water.path, settings, arguments.time_limit,
                                             case.water.cloud))

    rows = []
    for row in two_at_a_time(run, [case for case in all_cases() if arguments.only in f"{case.group}: {case.name}"]):
        rows.append(row)
        tell(row)
    if not rows:
        parser.error(f"no case holds {arguments.only!r}")
    steadiness(rows)
    failed = sum(row["verdict"] == "fail" for row in rows)
    print(f"{len(rows) - failed} pass, {failed} fail")
    if any(row["group"] == "viscosity" for row in rows):
        print(f"least viscosity (m²/s) that calms without damping: {min_viscosity(rows, (60,))} at 1/60 s, "
              f"{min_viscosity(rows, (60, 240))} at 1/240 s, too")
    write_table(arguments.output, [rounded(row) for row in rows])
    return 0


if __name__ == "__main__":
    sys.exit(main())

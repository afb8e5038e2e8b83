#!/usr/bin/python3
"""Does water that moves as a whole go where it should? Cases whose right answer is known (known_motion.py says from
where), one row of a CSV file for each: group, name, parameters, figures, targets and verdict.

flight            blocks thrown through the air: the same velocity for all to 1e-3 m/s, momentum to 1e-9
ball              turning in free fall: angular momentum to 1e-4 after one turn
meeting           blocks that meet in the air, above a pool: momentum to 1e-9
drop              that is stretched without gravity: energy to 1 %, its length to 1 %
jet               level, 4 m/s: as wide after 2.4 m as at the start, to 15 %
plate             a plane jet on a plate: 0.95 of the speed of its total head, its force to 3 %
slope             a block let go on a smooth one: 0.95 of the momentum with 16 layers; little water: energy to 0.2
rotation          in an upright cylinder: 0.98 of the angular momentum after one turn, the paraboloid to 5 %; closed and
                  without gravity 0.99
rotation, long    the same for ten turns: 0.9
tank              sloshing in a tank made by an obstacle, turned: swings to 3 % as in the plain box, periods to 1 %
shear             at several angles to the lattice, free and as a pool: 0.98 of the energy after one turn, 0.95 after 3
taylor_green      Re 100 to 3 %; with 40 across Re 1000 to 10 %, and without viscosity 0.95 of the energy after 1 s
waves             high ones and low ones: 1/480 s loses at most 1.05 times what 1/60 s does; energy never above its
                  start by more than 2 % of the wave's own
rest              pools: 1e-4 m²/s², centre of mass to 0.3 % of the depth or 0.1 spacings; closed by a lid: 1e-6 m²/s²;
                  under gravity that leans, without a target
count             compression by count: 0.2 % in the mean, 1 % in an impact
sphere            pulled through water: drag coefficient below 0.5 with s = 0.05 m
A case whose targets are those of another resolution has none, and the verdict "-". Cases that are judged by another one
(the plain box, the run at 1/60 s) bring it along. The file is written anew after each case.
"""

import math
import sys
from functools import partial
from typing import Callable, NamedTuple

import numpy as np

import counted_water
import known_drop
import known_motion as known
import known_plate
import known_slope
from known_motion import Motion, of_water, run_motion
from known_water import Tank, pool, wave
from study import STRESS, in_turn, parser_of, write_table

RATES = (30, 60, 120, 240, 480)  # steps per second


class Mark(NamedTuple):
    figure: str
    least: float = -math.inf
    most: float = math.inf

    def holds(self, figures):
        return self.least <= figures.get(self.figure, math.nan) <= self.most

    def text(self):
        least = f"{self.least:g} <= " if self.least > -math.inf else ""
        return f"{least}{self.figure}" + (f" <= {self.most:g}" if self.most < math.inf else "")


class Case(NamedTuple):
    group: str
    name: str
    motion: Motion
    marks: tuple = ()
    parameters: dict = {}
    beside: str = ""  # title of the case that it is compared with, which comes before it
    compare: Callable | None = None  # figures of both -> further figures
    large: bool = False

    @property
    def title(self):
        return f"{self.group}: {self.name}"


def at(rate):
    return f"1/{rate:g} s"


def flights(spacings=(0.1, 0.05), rates=RATES, offsets=((0, 0, 0), (0.037, 0.021, 0.013))):
    marks = (Mark("spread", most=1e-3), Mark("momentum_error", most=1e-9))
    for spacing in spacings:
        for offset in offsets:
            for rate in rates:
                yield Case("flight", f"s {spacing:g}, {'off the lattice, ' if any(offset) else ''}{at(rate)}",
                           known.flight(spacing, rate, offset), marks,
                           {"spacing": spacing, "steps_per_second": rate, "offset": float(any(offset))})
    for rate in rates:  # a speed at which layers pass faces of cells slowly, so that some lie right before one
        yield Case("flight", f"s {spacings[0]:g}, askew, {at(rate)}",
                   known.flight(spacings[0], rate, velocity=(3.7, 0.3, 2.2)), marks,
                   {"spacing": spacings[0], "steps_per_second": rate, "offset": 0.0})


def balls(rates=(60, 240), closings=(0, 2)):
    for closing in closings:
        for rate in rates:
            yield Case("ball", f"{f'closing in at {closing:g}/s, ' if closing else ''}{at(rate)}",
                       known.ball(rate, closing=closing), (Mark("angular_error", most=1e-4),),
                       {"spacing": 0.05, "steps_per_second": rate, "closing": closing})


def meetings(rates=(60, 240), offsets=(0.0, 0.07)):
    for offset in offsets:
        for rate in rates:
            yield Case("meeting", f"{'off the lattice, ' if offset else ''}{at(rate)}", known.meeting(rate, offset),
                       (Mark("momentum_error", most=1e-9),),
                       {"spacing": 0.05, "steps_per_second": rate, "offset": offset})


def jets(spacings=(0.05, 0.025), rates=(60, 240)):
    for spacing in spacings:
        for rate in rates:
            yield Case("jet", f"s {spacing:g}, {at(rate)}", known.jet(rate, spacing), (Mark("half_width", 0.85, 1.15),),
                       {"spacing": spacing, "steps_per_second": rate})


def plates(runs=((0.05, 0.2), (0.05, 0.4), (0.025, 0.2)), rates=(60, 120, 240)):
    """runs: spacings, and how wide the jet is, m."""
    marks = Mark("speed_ratio", 0.95, 1.05), Mark("force_ratio", 0.97, 1.03)
    for spacing, wide in runs:
        for rate in rates:
            yield Case("plate", f"s {spacing:g}, {wide / spacing:g} spacings wide, {at(rate)}",
                       known_plate.plate(rate, spacing, wide), marks, {"spacing": spacing, "steps_per_second": rate})


def slopes(runs=((0.05, 60), (0.05, 240), (0.025, 120)), angles=(10, 20, 30)):
    """runs: spacings, m, and steps per second."""
    for angle in angles:
        for spacing, rate in runs:
            yield Case("slope", f"{angle} degrees, {0.4 / spacing:g} layers, {at(rate)}",
                       known_slope.slope(rate, angle, spacing),
                       (Mark("momentum_ratio", 0.95, 1.02),) if spacing <= 0.025 else (),
                       {"spacing": spacing, "steps_per_second": rate, "angle": angle})


def little_on_slopes(angles=(10, 20, 30, 45), rates=(60, 240, 960)):
    for angle in angles:
        for rate in rates:
            parameters = {"spacing": 0.05, "steps_per_second": rate, "angle": angle}
            mark = Mark("energy_rise", most=0.2)
            for layers in (1, 2):
                yield Case("slope", f"{angle} degrees, sheet of {layers}, {at(rate)}",
                           known_slope.slope(rate, angle, length=2.0, height=layers * 0.05, seconds=0.4), (mark,),
                           parameters)
            yield Case("slope", f"{angle} degrees, particle, {at(rate)}",
                       known_slope.slope(rate, angle, length=0.05, height=0.05, seconds=0.6), (mark,), parameters)


def rotations(spacings=(0.05, 0.025), rates=(60, 240, 480), starts=("lattice", "rings")):
    """The lattice fills the cylinder as a block does, raggedly at the wall; rings do so evenly."""
    marks = Mark("angular_1", 0.98), Mark("paraboloid", 0.95, 1.05)
    for spacing in spacings:
        for rate in rates:
            known_by = {"spacing": spacing, "steps_per_second": rate, "across": round(1 / spacing)}
            for start in starts:
                yield Case("rotation", f"{start}, R {0.5 / spacing:g} spacings, {at(rate)}",
                           known.rotation(rate, spacing, start=start), marks, known_by | {"start": start})
            yield Case("rotation", f"closed, R {0.5 / spacing:g} spacings, {at(rate)}",
                       known.rotation(rate, spacing, start="rings", closed=True), (Mark("angular_1", 0.99),),
                       known_by | {"start": "rings"})


def long_rotations(spacings=(0.05, 0.025), rates=(60, 240, 480), start="lattice"):
    marks = Mark("angular_1", 0.98), Mark("angular_10", 0.9), Mark("paraboloid", 0.95, 1.05)
    for spacing in spacings:
        for rate in rates:
            yield Case("rotation, long", f"{start}, R {0.5 / spacing:g} spacings, {at(rate)}",
                       known.rotation(rate, spacing, turns=10, start=start), marks,
                       {"spacing": spacing, "steps_per_second": rate, "across": round(1 / spacing), "start": start},
                       large=spacing < 0.05 and rate > 60)


def tanks(angles=(0, 20, 35, 45, 90), rates=(60, 240), floors=("vessel", "box")):
    """floor: the obstacle's own, or that of the box around it; the latter for two angles only."""
    marks = Mark("swing_off", most=0.03), Mark("period_off", most=0.01)
    for rate in rates:
        parameters = {"spacing": 0.1, "steps_per_second": rate, "angle": ""}
        yield Case("tank", f"plain box, {at(rate)}", known.tank(rate), (), parameters)
        for floor in floors:
            for angle in angles if floor == "vessel" else angles[:3:2]:
                yield Case("tank", f"turned by {angle:g} degrees, floor of the {floor}, {at(rate)}",
                           known.tank(rate, angle, floor), marks, parameters | {"angle": angle},
                           f"tank: plain box, {at(rate)}", known.against_plain_box)


def shears(across=(20, 40), steps=(0.005, 1 / 240), jitters=(0, 0.2), waves=((1, 0), (1, 1), (1, 2))):
    """40 across: the first of the steps for the box that repeats upwards, the last for the pool."""
    for n in across:
        for gravity in (False, True):
            for dt in steps if n < 40 else steps[-1:] if gravity else steps[:1]:
                for numbers in waves:
                    for jitter in jitters:
                        angle = math.degrees(math.atan2(numbers[1], numbers[0]))
                        name = (f"{'pool' if gravity else 'free'}, {angle:.0f} degrees, {n} across, "
                                f"{f'jitter {jitter:g}' if jitter else 'lattice'}, dt {dt:.4g} s")
                        marks = Mark("energy_1", 0.98), Mark("energy_3", 0.95)
                        yield Case("shear", name, known.shear(dt, n, numbers, jitter, gravity), marks,
                                   {"spacing": 1 / n, "steps_per_second": 1 / dt, "across": n, "angle": round(angle, 2),
                                    "jitter": jitter}, large=n > 20 and numbers == (1, 2))


def vortices(across=(20, 40, 80), reynolds=(10, 100, 1000, 0), dt=0.005):
    """Reynolds number 0: without viscosity."""
    for n in across:
        for number in reynolds:
            nu = 1 / number if number else 0.0
            for jitter in (0, 0.2) if number == 100 else (0,):
                marks = ()
                if number == 100:
                    marks = tuple(Mark(f"at_{name}", 0.97, 1.03) for name in ("three_quarters", "half", "quarter"))
                elif number == 1000 and n >= 40:
                    marks = Mark("at_three_quarters", 0.9, 1.1), Mark("after_3_s", 0.9, 1.1)
                elif number == 0 and n >= 40:
                    marks = (Mark("after_1_s", 0.95),)
                name = f"{f'Re {number}' if number else 'no viscosity'}, {n} across{', jitter 0.2' if jitter else ''}"
                yield Case("taylor_green", name, known.taylor_green(n, nu, jitter, dt), marks,
                           {"spacing": 1 / n, "steps_per_second": 1 / dt, "across": n, "nu": nu, "jitter": jitter},
                           large=n > 40)


def wave_case(spacing, amplitude, rate):
    """In a tank of 4 m and 1 m of water, six spacings wide; amplitude in spacings."""
    name = "s {:g}, A {:g} spacings, {}".format
    tank = Tank(round(1 / spacing), 4, 6 * spacing, spacing, steps_per_second=rate, seconds=10)
    marks = Mark("own_energy_gain", most=0.02), *((Mark("loss_over_60", most=1.05),) if rate == 480 else ())
    return Case("waves", name(spacing, amplitude, at(rate)),
                of_water(wave(tank, amplitude), known.wave_energy_figures), marks,
                {"spacing": spacing, "steps_per_second": rate, "amplitude": amplitude},
                f"waves: {name(spacing, amplitude, at(60))}" if rate != 60 else "", known.against_60,
                large=spacing < 0.05 and rate > 60)


def waves(high_rates=(60, 120, 240, 480), low_rates=(60, 30, 120, 240, 480), spacings=(0.1, 0.05, 0.025)):
    """The rate of 60 first, as the others are compared with it."""
    for spacing in spacings:
        for rate in high_rates:
            yield wave_case(spacing, round(0.3 / spacing), rate)
    for rate in low_rates:
        yield wave_case(0.1, 0.5, rate)


def rests(rates=(30, 60, 240, 480), jitters=(0, 0.05, 0.2), lids=(1.0, 1.02, 1.05, 1.08), seconds=10):
    """Pools of 10 layers, 1 m x 1 m; lids: m, heights of the box over the same water."""
    rise = Mark("rise_over_mark", most=1)
    for rate in rates:
        tank = Tank(10, steps_per_second=rate, seconds=seconds)
        parameters = {"spacing": tank.spacing, "steps_per_second": rate}
        for jitter in jitters:
            yield Case("rest", f"{f'jitter {jitter:g}' if jitter else 'lattice'}, {at(rate)}",
                       of_water(pool(tank, jitter), known.pool_figures), (Mark("kinetic_per_mass", most=1e-4), rise),
                       parameters | {"jitter": jitter})
        for lid in lids:
            yield Case("rest", f"{'full tank' if lid == 1 else f'lid at {lid:g} m'}, {at(rate)}",
                       of_water(pool(tank), known.pool_figures, [f"domain.max=[1.0,1.0,{lid!r}]"]),
                       (Mark("kinetic_per_mass", most=1e-6), rise), parameters | {"lid": lid})


def leaning(angles=(5, 10, 20, 30, 40), rate=120, spacing=0.025, length=2.0, depth=0.6, seconds=5.0):
    """Still water in a tank of two dimensions under gravity that leans, its surface at right angles to it."""
    for angle in angles:
        lean = math.radians(angle)
        place = known.lattice((round(length / spacing), 1, round((depth + length) / spacing)), spacing)
        columns = np.rint((depth + (place[:, 0] - length / 2) * math.tan(lean)) / spacing)
        place = place[place[:, 2] < columns * spacing] * (1, 0, 1)
        text = known.scene_of((0, 0, 0), (length, spacing, depth + length), spacing, 1 / rate, seconds, extra="")
        settings = ["domain.dimensions=2", f"gravity.acceleration={[9.8 * math.sin(lean), 0, -9.8 * math.cos(lean)]}"]
        yield Case("rest", f"gravity leans by {angle} degrees, {at(rate)}",
                   Motion(text, partial(known.still_figures, spacing), (place, 0 * place), settings), (),
                   {"spacing": spacing, "steps_per_second": rate, "angle": angle})


def counts(cube_rates=(60, 240), dam_rates=(150, 480), long_rates=(60, 240)):
    marks = Mark("count_mean", -0.002, 0.002), Mark("count_impact", most=0.01)
    scenes = (("falling cube", "cube", (4, 3, 6), 0.1, cube_rates, 2.0, 0.62, 0.05),
              ("dam break", "dam_break", (5, 0.2, 4), 0.05, dam_rates, 1.5, 0.0, 0.1))
    for name, scene, high, spacing, rates, end, *when in scenes:
        text = (STRESS / f"{scene}.toml").read_text(encoding="utf-8")
        for rate in rates:
            settings = f"time.dt={1 / rate!r}", f"time.end={end}"
            motion = counted_water.counted(text, (0, 0, 0), high, spacing, settings, *when)
            yield Case("count", f"{name}, {at(rate)}", motion, marks, {"spacing": spacing, "steps_per_second": rate})
    for rate in long_rates:
        yield Case("count", f"block of 6 x 4 x 4 m in a box of 12 x 4 x 8 m, {at(rate)}",
                   counted_water.falling_block((0, 0, 0), (12, 4, 8), (0, 0, 0), (6, 4, 4), 0.1, rate, 1.0), marks,
                   {"spacing": 0.1, "steps_per_second": rate}, large=True)


def drops(runs=((0.05, 100), (0.05, 400), (0.025, 200))):
    """runs: spacings, m, and steps per second."""
    marks = Mark("energy", 0.99, 1.01), Mark("long_axis", 0.99, 1.01)
    for spacing, rate in runs:
        yield Case("drop", f"radius {1 / spacing:g} spacings, {at(rate)}", known_drop.drop(rate, spacing), marks,
                   {"spacing": spacing, "steps_per_second": rate, "radius": 1.0})


def spheres(rates=(60,), runs=((0.1, 0.5), (0.05, 0.25), (0.05, 0.5))):
    """runs: spacings and radii, m."""
    for spacing, radius in runs:
        for rate in rates:
            yield Case("sphere", f"s {spacing:g}, radius {radius / spacing:g} spacings, {at(rate)}",
                       known.sphere(rate, spacing, radius), (Mark("drag", most=0.5),) if spacing <= 0.05 else (),
                       {"spacing": spacing, "steps_per_second": rate, "radius": radius}, large=spacing <= 0.05)


def all_cases():
    return [*flights(), *balls(), *meetings(), *drops(), *jets(), *plates(), *slopes(), *little_on_slopes(),
            *rotations(), *tanks(), *shears(), *vortices(), *waves(), *rests(), *leaning(), *counts(), *spheres(),
            *long_rotations()]


def chosen(cases, only, large):
    """Those that hold the text, and what they are compared with, in their order."""
    found = [case for case in cases if only in case.title and (large or not case.large)]
    wanted = {case.title for case in found} | {case.beside for case in found}
    return [case for case in cases if case.title in wanted]


class Row(NamedTuple):
    case: Case
    figures: dict
    message: str  # why there are no figures
    wall_seconds: float | str

    def failed(self):
        return ["run"] if self.message else [mark.figure for mark in self.case.marks if not mark.holds(self.figures)]

    def verdict(self):
        return "fail" if self.failed() else "pass" if self.case.marks else "-"

    def tell(self):
        figures = "  ".join(f"{name} {rounded(value)}" for name, value in self.figures.items())
        told = (self.case.title, self.verdict(), " ".join(self.failed()), self.message, figures,
                f"wall_seconds {rounded(self.wall_seconds)}")
        print("  ".join(filter(None, told)), flush=True)


def row_of(case, run, code, message):
    if code != 0 or len(run.columns.get("step", ())) < 2:
        return Row(case, {}, (message.splitlines() or ["no rows"])[-1][:200], "")
    try:
        figures = case.motion.figures(run)
    except (ValueError, IndexError, ZeroDivisionError, KeyError) as error:  # water that is not where it should be
        return Row(case, {}, f"no figures: {error!r}", run.columns["wall_seconds"][-1])
    return Row(case, figures, "", run.columns["wall_seconds"][-1])


def compared(row, rows):
    """With the figures that another case's give, should that have any."""
    other = next((other for other in rows if other.case.title == row.case.beside), None)
    if other is None or not other.figures or not row.figures:
        return row
    return row._replace(figures=row.figures | row.case.compare(row.figures, other.figures))


def rounded(value):
    return f"{float(value):.4g}" if hasattr(value, "__float__") else value


def table_of(rows, settings):
    """As dictionaries that all have the columns which any of them has."""
    parameters = dict.fromkeys(name for row in rows for name in row.case.parameters)
    figures = dict.fromkeys(name for row in rows for name in row.figures)
    return [{"group": row.case.group, "name": row.case.name,
             **{name: rounded(row.case.parameters.get(name, "")) for name in parameters},
             **{name: rounded(row.figures.get(name, "")) for name in figures},
             "target": "; ".join(mark.text() for mark in row.case.marks), "verdict": row.verdict(),
             "failed": " ".join(row.failed()), "wall_seconds": rounded(row.wall_seconds),
             "settings": " ".join(settings), "message": row.message} for row in rows]


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose 'group: name' holds TEXT")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="in all runs, to try a remedy")
    parser.add_argument("--large", action="store_true", help="also the cases that take minutes")
    parser.add_argument("--list", action="store_true", help="tell the cases, and run none")
    parser.add_argument("--time-limit", type=float, default=600, metavar="S", help="of one run (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="runs at a time (default: %(default)s)")
    arguments = parser.parse_args()
    cases = chosen(all_cases(), arguments.only, arguments.large)
    if not cases:
        parser.error(f"no case holds {arguments.only!r}")
    if arguments.list:
        print(*(case.title for case in cases), sep="\n")
        return 0

    def run(case):
        return row_of(case, *run_motion(arguments.trevi, case.motion, arguments.set, arguments.time_limit))

    rows = []
    for row in in_turn(run, cases, arguments.jobs):
        rows.append(compared(row, rows))
        rows[-1].tell()
        write_table(arguments.output, table_of(rows, arguments.set))
    verdicts = [row.verdict() for row in rows]
    print(f"{verdicts.count('pass')} pass, {verdicts.count('fail')} fail, {verdicts.count('-')} without target")
    return 0


if __name__ == "__main__":
    sys.exit(main())

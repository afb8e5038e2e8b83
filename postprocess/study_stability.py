#!/usr/bin/python3
"""Runs the stress cases with the report's preset, the default, and the default with densities from Poly6, and says of
each how it ended. The default runs for 20 s of simulated time, unless its case says otherwise; the others, whose faults show
sooner, as long as the scene does (2 s in most).

stable       nothing of what follows
dissipative  the centre of mass ends more than 5 % below that of the same volume of water at rest on the floor; a sheet of
             one or two layers: it has lost more than half its height; single drops and water in the air have none
energy gain  passive scene that starts with C <= 0.01: total energy above its start by > 0.5 % of max(E0, m g h N)
blow-up      stopped by its own guards, or did not end, or a speed five times what the scene can give
refused      the program says beforehand what it cannot do
g is that of the case. A wave may run at any speed here and a pool may simmer: study_water.py has the marks for those.
The rows go to a CSV file; stability_matrix.py draws them. Runs go two at a time: nothing is timed.
"""

import math
import sys
from typing import NamedTuple

from known_water import Tank, jets, pool, turning_ball, wave
from study import GRAVITY, REPORT, STRESS, energy_gain, mean, parser_of, simulate, two_at_a_time, write_table

PRESETS = {"report": REPORT, "default": [], "poly6": ["fluid.density_kernel=poly6"]}
LONG = ("default",)


class Case(NamedTuple):
    group: str
    name: str
    scene: str
    settings: list
    floor: float  # m², to tell the depth of the water at rest
    spacing: float = 0.1
    passive: bool = True
    speed: float = 10.0  # m/s, what gravity or a pump can give
    gravity: float = GRAVITY
    kept: float | None = None  # share of its height that the water must keep; None: as the head of this file says
    cloud: tuple | None = None  # positions and velocities, in place of the scene's blocks
    seconds: float = 20  # simulated, of the presets that run long


def column(group, name, layers=40, spacing=0.1, settings=(), steps_per_second=60.0):
    side, depth = 10 * spacing, layers * spacing
    room = [f"domain.max=[{side:g},{side:g},{depth + 20 * spacing:g}]", f"particles.0.max=[{side:g},{side:g},{depth:g}]"]
    own = [f"fluid.spacing={spacing:g}", f"time.dt={1 / steps_per_second!r}", *room, *settings]
    return Case(group, name, "column", own, side * side, spacing, True, math.sqrt(2 * GRAVITY * depth))


def cube(group, name, height=2.0, settings=(), steps_per_second=60.0):
    end = math.sqrt(2 * height / GRAVITY) + 1.2
    own = [f"particles.0.min=[1.0,0.5,{height:g}]", f"particles.0.max=[2.0,1.5,{height + 1:g}]",
           f"domain.max=[3.0,2.0,{height + 3:g}]", f"time.end={end!r}", f"time.dt={1 / steps_per_second!r}"]
    return Case(group, name, "cube", [*own, *settings], 6.0, 0.1, True, math.sqrt(2 * GRAVITY * (height + 1)))


def dam(group, name, settings=()):
    return Case(group, name, "dam_break", list(settings), 1.0, 0.05, True, math.sqrt(2 * GRAVITY * 2))


def tank(length):
    own = [f"domain.max=[{length},0.2,2.0]", "particles.0.max=[0.4,0.2,0.8]"]
    return Case("tank length", f"{length} m", "dam_break", own, 0.2 * length, 0.05, True, 4.0)


def pump(speed):
    jet = [f"fountain.0.speed={speed}", "fountain.0.jitter=0.0", "time.end=1.0"]
    return Case("pump", f"{speed} m/s", "fountain", jet, 3.84, 0.1, False, speed + 5)


def overlap(name, shift):
    place = [f"particles.1.min=[{1 + shift},{1 + shift},{shift}]", f"particles.1.max=[{2 + shift},{2 + shift},{1 + shift}]"]
    return Case("overlap", name, "overlap", place, 9.0, 0.1, False, 10.0)


def few(name, low, high, settings=()):
    return Case("few", name, "few", [f"particles.0.min={low}", f"particles.0.max={high}", *settings], 1.0, 0.1, True, 5.0)


def time_steps():
    for rate in (240, 120, 60, 30, 20, 10):
        yield column("dt, column", f"1/{rate} s", steps_per_second=rate)
    for rate in (240, 120, 60, 30, 20, 10):
        yield cube("dt, cube", f"1/{rate} s", steps_per_second=rate)
    for rate in (240, 120, 60, 30, 20, 10):
        yield dam("dt, dam break", f"1/{rate} s", [f"time.dt={1 / rate!r}"])


def known(group, name, water, floor=1.0, kept=None):
    """A case of known_water.py."""
    speed = math.sqrt(2 * GRAVITY * water.depth) if water.layers else 5.0
    return Case(group, name, water.scene, water.settings, floor, water.spacing, True, speed, kept=kept, cloud=water.cloud)


def still(group, name, tank, jitter=0.0, kept=None):
    return known(group, name, pool(tank._replace(seconds=2.0), jitter), tank.length * tank.width, kept)


def shallow():
    for layers in (5, 10):
        for rate in (960, 480, 240, 120, 60, 30):
            yield column(f"dt, {layers} layers", f"1/{rate} s", layers, steps_per_second=rate)
    for layers in (3, 4, 5, 9, 10, 20):
        yield column("1/240 s, layers", f"{layers}", layers, steps_per_second=240)
    for layers in (5, 9, 10, 20, 40):  # so little that C stays below 0.01
        yield still("disturbed, layers", f"{layers}", Tank(layers), 0.008)
    for layers in (1, 2):
        for rate in (60, 240):
            name = f"{layers}, 1/{rate} s"
            yield still("sheet, layers", name, Tank(layers, 2.0, 2.0, steps_per_second=rate), kept=0.5)
    for ratio in (1.5, 1.8, 2.5, 3.0, 4.0):
        yield column("h/s, 10 layers", f"{ratio}", 10, settings=[f"fluid.kernel_radius={ratio * 0.1:g}"])


def sizes():
    for layers in (3, 4, 5, 7, 9):
        yield column("few layers", f"{layers}", layers)
    for layers in (10, 15, 20, 40, 80, 200):
        yield column("layers", f"{layers}", layers)
    for width in (2, 4, 10):
        for layers in (40, 100, 250):
            yield still(f"well, {width} wide", f"{layers} deep", Tank(layers, width / 10, width / 10))
    for height in (0.5, 2.0, 5.0, 10.0, 20.0):
        yield cube("drop", f"{height:g} m", height)
    for spacing in (0.2, 0.1, 0.05, 0.025, 0.0125):
        yield column("spacing", f"{spacing} m", 20, spacing)
    for length in (0.84, 3.6, 4.0):
        yield tank(length)


def numbers():
    for iterations in (1, 2, 4, 8, 16, 32, 64):
        yield column("iterations, column", f"{iterations}", settings=[f"density.iterations={iterations}"])
    for iterations in (1, 2, 4, 8, 16, 32, 64):
        yield cube("iterations, cube", f"{iterations}", settings=[f"density.iterations={iterations}"])
    for iterations in (1, 2, 3, 8):
        yield column("iterations, pool", f"{iterations}", 10, settings=[f"density.iterations={iterations}"])
    yield column("epsilon 0", "column", settings=["density.epsilon=0.0"])
    yield cube("epsilon 0", "cube", settings=["density.epsilon=0.0"])
    yield few("one", "[0.4,0.4,1.0]", "[0.5,0.5,1.1]", ["density.epsilon=0.0"])._replace(group="epsilon 0")
    for ratio in (1.5, 1.8, 2.0, 2.5, 3.0):
        yield column("h/s", f"{ratio}", settings=[f"fluid.kernel_radius={ratio * 0.1:g}"])


def gravities():
    for layers in (10, 40):
        for gravity in (1.6, 9.8, 100.0):
            keys = [f"gravity.acceleration=[0.0,0.0,{-gravity}]"]
            case = column(f"g, {layers} layers", f"{gravity:g} m/s²", layers, settings=keys)
            yield case._replace(gravity=gravity, speed=math.sqrt(2 * gravity * layers * 0.1))


def waves():
    for amplitude in (1, 0.5, 0.25):
        for layers in (5, 10, 20, 40):
            water = wave(Tank(layers, 4.0, 0.6, seconds=2.0), amplitude)
            yield known(f"slosh, A {amplitude:g}, layers", f"{layers}", water, 4.0 * 0.6)
    for amplitude in (1, 0.5, 0.25):
        water = wave(Tank(10, 2.0, 2.0, seconds=2.0), amplitude, diagonal=True)
        yield known("diagonal mode", f"A {amplitude:g}", water, 4.0)


def methods():
    keys = {name: [f"density.method={name}"] for name in ("jacobi", "chebyshev", "anderson")}
    keys["equality"] = ["density.constraint=equality"]
    for name, settings in keys.items():
        yield column("named, column", name, settings=settings)
        yield column("named, pool", name, 10, settings=settings)
        yield cube("named, cube", name, settings=settings)


def in_the_air():
    for ratio in (2, 2.5, 3):
        yield known("jets, no gravity", f"h {ratio:g}", jets(ratio), kept=0)
        yield known("ball, no gravity", f"h {ratio:g}", turning_ball(ratio), kept=0)


def oddities():
    for speed in (5.0, 10.0, 20.0, 50.0, 100.0):
        yield pump(speed)
    yield overlap("tenth of s", 0.01)
    yield overlap("half of s", 0.05)
    yield overlap("coincident", 0.0)
    yield few("one", "[0.4,0.4,1.0]", "[0.5,0.5,1.1]")
    yield few("two", "[0.4,0.4,1.0]", "[0.6,0.5,1.1]")
    yield few("in a corner", "[0.0,0.0,0.0]", "[0.1,0.1,0.1]")


def all_cases():
    return [*time_steps(), *shallow(), *sizes(), *gravities(), *waves(), *numbers(), *methods(), *in_the_air(), *oddities()]


def verdict(case, columns, code):
    """The word for a run, as this file's head defines it."""
    if code == 2:
        return "refused"
    if code != 0 or not columns or not all(map(math.isfinite, columns["kinetic_energy"])):
        return "blow-up"
    if max(columns["speed_max"][1:]) > 5 * case.speed:
        return "blow-up"
    at_rest_start = case.passive and columns["compression_max"][0] <= 0.01
    if at_rest_start and energy_gain(columns, case.spacing, case.gravity) > 0.005:
        return "energy gain"
    volume = columns["particles"][0] * case.spacing**3
    depth = volume / case.floor
    # Other water shallower than two layers, a single particle for one, has no depth to lose.
    kept = (0.95 if depth > 2 * case.spacing else 0) if case.kept is None else case.kept
    return "dissipative" if columns["com_z"][-1] < kept * depth / 2 else "stable"


def row_of(case, preset, columns, code, message):
    row = {"group": case.group, "case": case.name, "preset": preset, "verdict": verdict(case, columns, code)}
    steps = len(columns.get("step", ()))
    whole = steps > 1
    row["steps"] = steps - 1
    row["compression_mean"] = f"{mean(columns['compression_mean'][1:]):.3e}" if whole else ""
    row["compression_max"] = f"{max(columns['compression_max']):.3e}" if whole else ""
    row["seconds"] = f"{columns['time'][-1]:.4g}" if whole else ""
    row["energy_gain"] = f"{energy_gain(columns, case.spacing, case.gravity):.2e}" if whole else ""
    row["com_z"] = f"{columns['com_z'][-1]:.5g}" if whole else ""
    row["speed_max"] = f"{max(columns['speed_max']):.3g}" if whole else ""
    row["substeps"] = f"{mean(columns['substeps'][1:]):.2f}" if whole else ""
    row["message"] = message.splitlines()[-1][:200] if code != 0 and message else ""
    return row


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", default="", metavar="TEXT", help="cases whose group holds TEXT")
    parser.add_argument("--preset", choices=PRESETS, action="append", help="default: all")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="in all runs, to try a remedy")
    parser.add_argument("--time-limit", type=float, default=90, metavar="S", help="of one run (default: %(default)s)")
    arguments = parser.parse_args()

    def run(work):
        case, preset = work
        settings = [*case.settings, *PRESETS[preset], *arguments.set]
        if preset in LONG:
            settings.append(f"time.end={float(case.seconds)!r}")
        return row_of(case, preset, *simulate(arguments.trevi, STRESS / f"{case.scene}.toml", settings,
                                              arguments.time_limit, case.cloud))

    rows = []
    for row in two_at_a_time(run, [(case, preset) for case in all_cases() if arguments.only in case.group
                                   for preset in arguments.preset or PRESETS]):
        rows.append(row)
        print(*row.values(), sep="  ", flush=True)
    if not rows:
        parser.error(f"no group holds {arguments.only!r}")
    write_table(arguments.output, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())

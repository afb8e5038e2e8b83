#!/usr/bin/python3
"""Two dimensions ([domain] dimensions = 2) beside a thin slab in three: the same flows, their figures and user CPU
seconds per simulated second. One row for each run:

dam           front of the dam break against Martin & Moyce, relative RMS raw and after one shift of time; energy left
wave          standing wave of the first mode in 4 m x 1 m: period over linear theory's, share lost in a half-period, and
              how far the energy rises over the wave's own
still, pool   water at rest, from the lattice and disturbed: motion in the last 2 s, height of the centre of mass
pressure      at the foot of a wall in still water, over rho g times the depth below the surface
cube          a falling square, in three dimensions a cube that is as wide: mean and largest compression
vortices      Taylor & Green in a box that repeats, with and without viscosity: energy over the exact one
shear         u = sin along x, no viscosity: energy left after one and three turns
momentum      two squares that collide in the air without gravity: change of momentum over that of one of them
"""

import math
import os
import resource
import sys
import tempfile
import time as clock
from pathlib import Path

import numpy as np

from known_motion import plain
from known_water import rest_figures, wave_figures
from study import GRAVITY, columns_of, energies, energy_gain, in_turn, launch, mean, parser_of, start_of, write_table
from validate import TIME_SCALE, best_shift, experiments, relative_rms

SINGLE = '[density]\nprecision = "single"\n'


def scene(low, high, spacing, dt, end, width=0, gravity=True, periodic="", extra=""):
    """low, high: [x, z]; width: spacings along y, 0 for two dimensions."""
    axes = f"periodic = {[axis for axis in periodic if width or axis != 'y']}\n" if periodic else ""
    corner = [low, high] if width == 0 else [(low[0], 0, low[1]), (high[0], width * spacing, high[1])]
    dimensions = "dimensions = 2\n" if width == 0 else ""
    return (f"[domain]\n{dimensions}min = {plain(corner[0])}\nmax = {plain(corner[1])}\n{axes}"
            f"[fluid]\nspacing = {spacing!r}\n[time]\ndt = {dt!r}\nend = {end!r}\n{'[gravity]' if gravity else ''}\n"
            f"{SINGLE}{extra}\n[output.series]\n")


def block(low, high, spacing, width, velocity=(0, 0)):
    if width == 0:
        return f"[[particles]]\nmin = {plain(low)}\nmax = {plain(high)}\nvelocity = {plain(velocity)}\n"
    return (f"[[particles]]\nmin = {plain((low[0], 0, low[1]))}\nmax = {plain((high[0], width * spacing, high[1]))}\n"
            f"velocity = {plain((velocity[0], 0, velocity[1]))}\n")


def lattice(length, height, spacing, width):
    """Places in [0, length] x [0, height]: of a layer at y = 0, or of `width` layers."""
    x, z = ((np.arange(round(size / spacing)) + 0.5) * spacing for size in (length, height))
    y = (np.arange(width) + 0.5) * spacing if width else np.zeros(1)
    return np.stack(np.meshgrid(x, y, z, indexing="ij"), -1).reshape(-1, 3)


def jittered(place, spacing, jitter, width, seed=1):
    off = np.random.default_rng(seed).uniform(-jitter, jitter, place.shape) * spacing
    return place + (off if width else off * (1, 0, 1))


def run(trevi, text, cloud=None, settings=()):
    """Columns of series.csv, those of gauges.csv, and user CPU seconds."""
    with tempfile.TemporaryDirectory() as folder:
        path, output = Path(folder) / "scene.toml", Path(folder) / "run"
        path.write_text(text, encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        code, message = launch(trevi, path, output, [*start_of(cloud, folder), *settings], 1800)
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        if code != 0:
            sys.exit(f"{message}\n{text}")
        return columns_of(output / "series.csv"), columns_of(output / "gauges.csv"), seconds


def dam(trevi, spacing, width):
    text = scene((0, 0), (5, 3), spacing, spacing / 7.5, 1.5, width, extra=block((0, 0), (1, 2), spacing, width))
    columns, _, seconds = run(trevi, text)
    time = np.array(columns["time"]) * TIME_SCALE
    points = next(iter(experiments().values()))  # Martin & Moyce
    front = np.array(columns["front"]) + spacing / 2
    shift = best_shift(points, time, front)
    energy = np.array(energies(columns))
    left = np.interp([0.8, 1.5], columns["time"], energy / energy[0])
    return columns, seconds, {"front_raw": relative_rms(points, time, front), "shift": shift,
                              "front_shifted": relative_rms(points, time, front, shift), "energy_0.8_s": left[0],
                              "energy_1.5_s": left[1], "compression_mean": mean(columns["compression_mean"][1:])}


class Tank:
    def __init__(self, spacing, length=4.0, depth=1.0):
        self.spacing, self.length, self.depth, self.diagonal = spacing, length, depth, False
        k = math.pi / length
        self.omega = math.sqrt(GRAVITY * k * math.tanh(k * depth))
        self.half_period = math.pi / self.omega


def wave(trevi, spacing, width, rate, amplitude=0.1, seconds=12.0):
    tank = Tank(spacing)
    k, place = math.pi / tank.length, lattice(tank.length, tank.depth, spacing, width)
    speed = amplitude * tank.omega / math.sinh(k * tank.depth)
    velocity = np.zeros_like(place)
    velocity[:, 0] = speed * np.cosh(k * place[:, 2]) * np.sin(k * place[:, 0])
    velocity[:, 2] = -speed * np.sinh(k * place[:, 2]) * np.cos(k * place[:, 0])
    text = scene((0, 0), (tank.length, 2.0), spacing, 1 / rate, seconds, width)
    columns, _, cpu = run(trevi, text, (place, velocity))
    kinetic = columns["kinetic_energy"]
    energy = (np.array(energies(columns)) - energies(columns)[0]) / kinetic[0]
    figures = wave_figures(columns, tank)
    return columns, cpu, {"period": figures["period_ratio"], "loss_per_half": figures["loss_per_half"],
                          "own_energy_gain": energy.max(), "compression_mean": mean(columns["compression_mean"][1:])}


def pool(trevi, spacing, width, rate, jitter=0.0, depth=1.0, seconds=10.0):
    tank = Tank(spacing, 2.0, depth)
    place = jittered(lattice(tank.length, depth, spacing, width), spacing, jitter, width)
    text = scene((0, 0), (tank.length, depth + 0.5), spacing, 1 / rate, seconds, width)
    columns, _, cpu = run(trevi, text, (place, np.zeros_like(place)))
    found = rest_figures(columns, tank, 2)
    return columns, cpu, {"motion": found["kinetic_per_mass"], "com_error": found["com_error"],
                          "energy_gain": energy_gain(columns, spacing)}


def pressure(trevi, spacing, width, rate=60):
    """Before the wall x = 0, a quarter up; an obstacle far from the water makes the walls count."""
    solid = '[[obstacle]]\ntype = "box"\ncenter = {0}\nsize = {1}\n'
    at = plain((1.0, 1.6)) if width == 0 else plain((1.0, width * spacing / 2, 1.6))
    size = plain((0.2, 0.2)) if width == 0 else plain((0.2, 4 * width * spacing, 0.2))
    center = plain((0, 0.25)) if width == 0 else plain((0, width * spacing / 2, 0.25))
    normal = "[1, 0]" if width == 0 else "[1, 0, 0]"
    gauge = f'[[gauge]]\ntype = "pressure"\ncenter = {center}\nnormal = {normal}\nradius = {2 * spacing!r}\n'
    text = scene((0, 0), (2, 2), spacing, 1 / rate, 2, width,
                 extra=block((0, 0), (2, 1), spacing, width) + solid.format(at, size) + gauge)
    columns, gauges, cpu = run(trevi, text)
    found = mean(gauges["pressure_0"][-20:])
    return columns, cpu, {"pressure": found / (1000 * GRAVITY * 0.75)}


def cube(trevi, spacing, width, rate=60):
    text = scene((0, 0), (4, 3), spacing, 1 / rate, 1.5, width, extra=block((1, 1), (3, 2), spacing, width))
    columns, _, cpu = run(trevi, text)
    return columns, cpu, {"compression_mean": mean(columns["compression_mean"][1:]),
                          "compression_peak": max(columns["compression_mean"]), "energy_gain": energy_gain(columns, spacing)}


def vortices(trevi, across, width, nu, kernel="", dt=0.005, jitter=0.0):
    spacing, rate = 1 / across, 16 * math.pi**2 * nu
    place = jittered(lattice(1, 1, spacing, width), spacing, jitter, width) % (1, max(width, 1) * spacing, 1)
    x, z = 2 * math.pi * place[:, 0], 2 * math.pi * place[:, 2]
    velocity = np.stack([np.sin(x) * np.cos(z), 0 * x, -np.cos(x) * np.sin(z)], axis=1)
    step = min(dt, 0.25 * spacing**2 / nu) if nu else dt
    end = math.log(2) / rate if nu else 1.0
    text = scene((0, 0), (1, 1), spacing, step, step * math.ceil(end / step), width, False, "xyz",
                 extra=f"[viscosity]\nnu = {nu!r}\n" if nu else "")
    text = text.replace("[time]", f"{kernel}[time]")
    columns, _, cpu = run(trevi, text, (place, velocity))
    when = np.array(columns["time"])
    energy = np.interp(end, when, columns["kinetic_energy"]) / columns["kinetic_energy"][0]
    figures = {"energy": energy * math.exp(rate * end), "compression_mean": columns["compression_mean"][-1]}
    if nu:
        figures["viscosity"] = -math.log(energy) / (rate * end)
    return columns, cpu, figures


def shear(trevi, across, width, dt=0.005, jitter=0.0):
    spacing = 1 / across
    place = jittered(lattice(1, 1, spacing, width), spacing, jitter, width) % (1, max(width, 1) * spacing, 1)
    velocity = np.sin(2 * math.pi * place[:, 2])[:, None] * np.array([1.0, 0, 0])
    text = scene((0, 0), (1, 1), spacing, dt, 3, width, False, "xyz")
    columns, _, cpu = run(trevi, text, (place, velocity))
    energy = np.array(columns["kinetic_energy"]) / columns["kinetic_energy"][0]
    one, three = np.interp([1, 3], columns["time"], energy)
    return columns, cpu, {"energy_1": one, "energy_3": three}


def momentum(trevi, spacing, width):
    text = scene((0, 0), (16, 12), spacing, 1 / 120, 0.5, width, False,
                 extra=block((6, 5.5), (7, 6.5), spacing, width, (5, 0)) + block((7.1, 5.6), (8.1, 6.6), spacing, width))
    columns, _, cpu = run(trevi, text)
    first = columns["momentum_x"][0]
    return columns, cpu, {"momentum": max(abs(p - first) for p in columns["momentum_x"]) / first}


def cases(quick):
    wide = 'kernel_radius = {0!r}\ndensity_kernel = "wendland_c2"\n'
    for width in (0, 4):
        yield "dam 0.05", dam, (0.05, width)
        yield "wave 0.05 1/60", wave, (0.05, width, 60)
        yield "still 0.05 1/60", pool, (0.05, width, 60)
        for rate in (60, 240):
            yield f"pool 0.05 jitter 0.2 1/{rate}", pool, (0.05, width, rate, 0.2)
        yield "pressure 0.05", pressure, (0.05, width)
        yield "cube 0.05", cube, (0.05, width)
        if width == 0:  # in a slab water is near a wall
            yield "momentum 0.05", momentum, (0.05, width)
        for across in (40,):
            yield f"vortices {across}", vortices, (across, 6 if width else 0, 0.0)
            yield f"vortices {across} nu 0.01", vortices, (across, 6 if width else 0, 0.01)
            yield f"vortices {across} nu 0.01 jitter 0.2", vortices, (across, 6 if width else 0, 0.01, "", 0.005, 0.2)
            yield f"vortices {across} nu 0.01 wendland_c2 h = 4 s", vortices, (
                across, 12 if width else 0, 0.01, wide.format(4 / across))
            yield f"shear {across}", shear, (across, 6 if width else 0)
            yield f"shear {across} jitter 0.2", shear, (across, 6 if width else 0, 0.005, 0.2)
    if quick:
        return
    for width in (0, 8):
        yield "dam 0.025", dam, (0.025, width)
        yield "wave 0.025 1/120", wave, (0.025, width // 2, 120)
    yield "wave 0.0125 1/240", wave, (0.0125, 0, 240)
    yield "dam 0.0125", dam, (0.0125, 0)


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--quick", action="store_true", help="spacings of 0.05 m only")
    parser.add_argument("--only", default="", help="cases whose name begins so")
    parser.add_argument("--plane", action="store_true", help="two dimensions only")
    arguments = parser.parse_args()
    rows, names = [], []
    chosen = [case for case in cases(arguments.quick)
              if case[0].startswith(arguments.only) and not (arguments.plane and case[2][1])]

    def timed(case):
        begin = clock.time()
        return *case[1](arguments.trevi, *case[2]), clock.time() - begin

    for (name, _, (_, width, *_)), (columns, seconds, figures, waited) in zip(chosen, in_turn(timed, chosen)):
        row = {"case": name, "dimensions": 3 if width else 2, "particles": int(columns["particles"][0]),
               "cpu_per_second": seconds / columns["time"][-1], **figures}
        rows.append(row)
        print("  ".join(f"{key} {value:.4g}" if isinstance(value, float) else f"{value}" for key, value in row.items()),
              f" ({waited:.0f} s)", flush=True)
        names += [key for key in row if key not in names]
    write_table(arguments.output, [{key: f"{value:.5g}" if isinstance(value := row.get(key, ""), float) else value
                                    for key in names} for row in rows])
    return 0


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())

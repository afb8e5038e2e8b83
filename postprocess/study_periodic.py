#!/usr/bin/python3
"""Taylor-Green vortices in a periodic box, against what Navier and Stokes say.

Four vortices in 1 m, in a box three kernel radii thin. Their energy is E0 exp(-4 nu k^2 t), k = 2 pi/1 m; the columns are the
ratio to it when it should have come to 3/4, 1/2 and 1/4. "wide" is wendland_c2 with h = 4 spacings, "default" the default kernel.
The Reynolds number is largest speed x 1 m/nu. The rows go to a CSV file.

With --tanks water under gravity instead: at rest in a tank that is periodic along x and y and in one with walls; waves that
run around a ring of length L, k = 2 pi/L, beside standing ones of the same k between walls L/2 apart (known_water.py). The
surface of a wave that runs is the sum of exp(-i k x) over all particles, which turns with omega.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from known_water import STATES, Tank, Water, pool, rest_figures, wave, wave_figures
from study import GRAVITY, parser_of, simulate, simulate_states, two_at_a_time, write_table

STEP = 0.005  # s
KERNELS = {"wide": (4, 'density_kernel = "wendland_c2"'), "default": (2, "")}
FLOWS = ((0.1, 0.05), (0.5, 0.05), (1.0, 0.01))  # m/s, m²/s


def vortex(trevi, kernel, across, speed, nu):
    radius, line = KERNELS[kernel]
    rate = 16 * math.pi**2 * nu
    end = STEP * (math.ceil(math.log(4) / rate / STEP) + 1)
    corners = f"min = [0.0, 0.0, 0.0]\nmax = [1.0, 1.0, {3 * radius / across!r}]\n"
    text = (f'[domain]\n{corners}periodic = ["x", "y", "z"]\n[fluid]\nspacing = {1 / across!r}\n'
            f"kernel_radius = {radius / across!r}\n{line}\n[[particles]]\n{corners}vortex = {speed}\n"
            f"[time]\ndt = {STEP}\nend = {end}\n[viscosity]\nnu = {nu}\n[output.series]\n")
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(text, encoding="utf-8")
        columns, code, message = simulate(trevi, scene, time_limit=7200)
    if code != 0:
        raise SystemExit(f"{text}\n{message}")
    energy, time = columns["kinetic_energy"], columns["time"]

    def ratio_when(share):
        row = round(-math.log(share) / rate / STEP)
        return round(energy[row] / energy[0] * math.exp(rate * time[row]), 4)

    return {"kernel": kernel, "across": across, "reynolds": round(speed / nu), "at_three_quarters": ratio_when(0.75),
            "at_half": ratio_when(0.5), "at_quarter": ratio_when(0.25),
            "compression_mean": float(f"{columns['compression_mean'][-1]:.2g}")}


def endless(water):
    return water._replace(settings=[*water.settings, 'domain.periodic=["x","y"]'])


def running_wave(tank, amplitude):
    """Linear theory's, amplitude in spacings: particles are displaced from the lattice as their velocities say."""
    k, depth = 2 * math.pi / tank.length, tank.layers * tank.spacing
    omega = math.sqrt(GRAVITY * k * math.tanh(k * depth))
    place = tank.lattice()
    height = amplitude * tank.spacing
    along = height * np.cosh(k * place[:, 2]) / math.sinh(k * depth)
    up = height * np.sinh(k * place[:, 2]) / math.sinh(k * depth)
    cosine, sine = np.cos(k * place[:, 0]), np.sin(k * place[:, 0])
    velocity = omega * np.stack([along * cosine, 0 * up, up * sine], axis=1)
    place = place + np.stack([-along * sine, 0 * up, up * cosine], axis=1)
    place[:, 0] %= tank.length
    settings = tank._replace(room=4 * height).settings()
    water = Water("column", settings, tank.layers, tank.length, tank.spacing, math.pi / omega, cloud=(place, velocity))
    return endless(water)


def running_figures(states, water, interval=0.1, halves=6):
    """As wave_figures(), of the first half-periods; `interval` between states, s."""
    mode = np.array([np.exp(-2j * math.pi / water.length * place[:, 0]).mean() for place, _ in states])
    time = interval * np.arange(len(mode))
    early = time < halves * water.half_period
    turn = np.polyfit(time[early], np.unwrap(np.angle(mode[early])), 1)[0]
    fade = np.polyfit(time[early] / water.half_period, np.log(np.abs(mode[early])), 1)[0]
    return {"period_ratio": math.pi / water.half_period / abs(turn), "loss_per_half": 1 - math.exp(fade)}


def tanks():
    """Rows' names and the water of each."""
    for layers in (10, 40):
        for jitter in (0, 0.2):
            water = pool(Tank(layers, seconds=15), jitter)
            name = {"layers": layers, "length": 1.0, "start": f"jitter {jitter} s" if jitter else "lattice"}
            yield {"water": "rest", "tank": "periodic", **name}, endless(water)
            yield {"water": "rest", "tank": "walls", **name}, water
    for layers, length in ((10, 4.0), (10, 8.0), (20, 4.0)):
        name = {"layers": layers, "length": length, "start": "amplitude 1 s"}
        yield {"water": "wave", "tank": "periodic", **name}, running_wave(Tank(layers, length, 0.6, seconds=10), 1)
        between = Tank(layers, length / 2, 0.6, seconds=10)
        yield {"water": "wave", "tank": "walls", **name}, wave(between, 1)


def tank_row(trevi, name, water):
    runs = name["water"] == "wave" and name["tank"] == "periodic"
    columns, states, code, message = simulate_states(trevi, water.path, [*water.settings, *(STATES if runs else [])],
                                                     time_limit=3600, cloud=water.cloud)
    if code != 0:
        raise SystemExit(f"{name}\n{message}")
    figures = dict.fromkeys(("kinetic_per_mass", "com_error_spacings", "period_ratio", "loss_per_half"), math.nan)
    found = (rest_figures(columns, water) if name["water"] == "rest" else
             running_figures(states, water) if runs else wave_figures(columns, water))
    figures |= {key: float(f"{value:.4g}") for key, value in found.items() if key in figures}
    return {**name, **figures}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--largest", type=int, default=40, help="particles across of the finest runs, 20, 40 or 80")
    parser.add_argument("--tanks", action="store_true", help="water under gravity instead of vortices")
    arguments = parser.parse_args()
    if arguments.tanks:
        rows = two_at_a_time(lambda case: tank_row(arguments.trevi, *case), list(tanks()))
        return write_table(arguments.output, list(rows))
    cases = [(kernel, across, *flow) for across in (20, 40, 80) if across <= arguments.largest
             for kernel in KERNELS for flow in FLOWS]
    rows = []
    for row in two_at_a_time(lambda case: vortex(arguments.trevi, *case), cases):
        print(row, flush=True)
        rows.append(row)
    write_table(arguments.output, rows)


if __name__ == "__main__":
    main()

"""Water that moves as a whole, of which the right answer is known: how each starts, and what its run is judged by. No
program of its own; study_motion.py runs it.

flight        Free fall: v = v0 + g t for each particle, as nothing presses water that falls.
ball          Free fall, and turning: angular momentum about the centre of mass stays what it was.
jet           Water in the air follows its parabola and keeps its speed across, so that the cut of the jet by an upright
              plane across its way stays the disc of the opening.
rotation      Solid-body rotation is steady without viscosity. Its surface is the paraboloid
              z = d + omega² (r² − R²/2)/(2 g) (Lamb, Hydrodynamics, 6th ed., §26).
tank          First mode of a tank (Lamb, §228, §257), whose swings do not depend on how the tank stands.
shear         u(y) along x is a steady flow without viscosity, of any profile.
taylor_green  Taylor & Green 1937 (Proc. R. Soc. A 158, 499): E0 exp(−4 nu k² t), k = 2 pi/1 m; constant for nu = 0.
waves         As tanks; a standing wave of amplitude A has the energy rho g A² L W/4 (Lamb, §174, §230), all of it
              kinetic where it starts.
rest          Nothing moves, and the centre of mass stays at half the depth.
count         Water is incompressible: the particles in what is all water are its volume over s³, without kernels.
sphere        A sphere through water at 1e5 < Re has drag coefficients of 0.4 to 0.5 (0 in d'Alembert's ideal flow).
"""

import math
import tempfile
from functools import partial
from pathlib import Path
from typing import Callable, NamedTuple

import numpy as np

import trevi_run
from known_water import last, rest_figures, wave_figures, zeros_of
from study import GRAVITY, columns_of, energies, launch, mass_of, mean, start_of, states_of

DOWN = np.array([0.0, 0.0, -GRAVITY])
NO_FIGURE = math.nan


class Run(NamedTuple):
    columns: dict  # of series.csv
    states: list  # positions and velocities, of each checkpoint
    times: np.ndarray  # s, of each checkpoint
    obstacles: dict  # columns of obstacles.csv


class Motion(NamedTuple):
    scene: str  # TOML
    figures: Callable  # of a Run, by name
    cloud: tuple | None = None  # positions and velocities at the start, where the scene's own particles do not do
    settings: tuple = ()


def run_motion(trevi, motion, settings=(), time_limit=600):
    """The Run, exit code and message."""
    with tempfile.TemporaryDirectory() as folder:
        scene, output = Path(folder) / "scene.toml", Path(folder) / "run"
        scene.write_text(motion.scene, encoding="utf-8")
        code, message = launch(trevi, scene, output, [*motion.settings, *start_of(motion.cloud, folder), *settings],
                               time_limit)
        return (Run(columns_of(output / "series.csv"), states_of(output), trevi_run.Run(output).checkpoints.times,
                    columns_of(output / "obstacles.csv")), code, message)


def plain(numbers):
    return [float(round(x, 12)) for x in numbers]


def scene_of(low, high, spacing, dt, end, gravity=True, periodic="", every=None, extra=""):
    """every: s between checkpoints; periodic: letters of axes."""
    axes = f"periodic = {list(periodic)}\n" if periodic else ""
    kept = f"[output.checkpoint]\nevery = {every!r}\nkeep = 1000\n" if every else ""
    return (f"[domain]\nmin = {plain(low)}\nmax = {plain(high)}\n{axes}[fluid]\nspacing = {spacing!r}\n"
            f"[time]\ndt = {dt!r}\nend = {end!r}\n{'[gravity]' if gravity else ''}\n{extra}\n[output.series]\n{kept}")


def lattice(counts, spacing, corner=(0, 0, 0)):
    axes = [(np.arange(n) + 0.5) * spacing + low for n, low in zip(counts, corner)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def jittered(place, spacing, jitter, seed=1):
    """jitter: spacings, the most that each coordinate is off, at random."""
    return place + np.random.default_rng(seed).uniform(-jitter, jitter, place.shape) * spacing if jitter else place


def of_water(water, figures, settings=()):
    """A Water of known_water.py, whose figures are those of its columns."""
    return Motion(water.path.read_text(encoding="utf-8"), lambda run: figures(run.columns, water), water.cloud,
                  (*water.settings, *settings))


# Flight.

def flight(spacing, rate, offset=(0, 0, 0), velocity=(4.0, 0.0, 2.0), seconds=0.4):
    """A block of 8 x 8 x 8 thrown at `velocity`, m/s; offset: spacings by which it is off the lattice of the box."""
    corner = 1 + np.array(offset) * spacing
    velocity = np.array(velocity)
    block = (f"[[particles]]\nmin = {plain(corner)}\nmax = {plain(corner + 8 * spacing)}\n"
             f"velocity = {plain(velocity)}")
    text = scene_of((0, 0, 0), (4.8, 3.0, 3.2), spacing, 1 / rate, seconds, every=seconds, extra=block)
    return Motion(text, partial(flight_figures, velocity))


def flight_figures(velocity, run):
    exact = velocity + DOWN * run.times[-1]
    off = run.states[-1][1] - exact
    return {"spread": np.abs(off).max(), "momentum_error": np.linalg.norm(off.mean(axis=0)) / np.linalg.norm(exact)}


def ball(rate, spacing=0.05, omega=12.0, closing=0.0):
    """A ball of radius 7 spacings turns about (1, 2, 3) for one turn, thrown up so that it comes back to where it was.
    It flies apart, and nothing presses, but for `closing`, 1/s, by which it draws together at the start."""
    turn = 2 * math.pi / omega
    place = lattice((16, 16, 16), spacing, 3 * [-8 * spacing])
    place = place[np.linalg.norm(place, axis=1) < 7 * spacing]
    velocity = np.cross(omega * np.array([1.0, 2.0, 3.0]) / math.sqrt(14), place) - closing * place - DOWN * turn / 2
    text = scene_of((0, 0, 0), (6, 6, 6), spacing, 1 / rate, turn, every=turn / 4)
    return Motion(text, ball_figures, (place + 3, velocity))


def angular_momentum(state):
    place, velocity = state
    return np.cross(place - place.mean(axis=0), velocity - velocity.mean(axis=0)).sum(axis=0)


def ball_figures(run):
    start, end = angular_momentum(run.states[0]), angular_momentum(run.states[-1])
    off = run.states[-1][1].mean(axis=0) - run.states[0][1].mean(axis=0) - DOWN * run.times[-1]
    return {"angular_error": np.linalg.norm(end - start) / np.linalg.norm(start),
            "momentum_error": np.linalg.norm(off) / np.linalg.norm(run.states[0][1], axis=1).mean()}


def meeting(rate, offset=0.0, spacing=0.05, seconds=0.4):
    """Two blocks of 8 x 8 x 8 meet in the air, at 3 and -1.5 m/s, above a pool of two layers, of which nothing reaches
    them; offset: m by which the second one is off the first across their way, and the lattice."""
    place = np.concatenate([lattice((8, 8, 8), spacing, (1.3, 1.8, 3.0)),
                            lattice((8, 8, 8), spacing, np.array([2.3, 1.8, 3.0]) + offset)])
    velocity = np.zeros_like(place)
    velocity[:, 0] = np.repeat([3.0, -1.5], len(place) // 2)
    velocity[:, 2] = 1
    pool = lattice((80, 80, 2), spacing)
    text = scene_of((0, 0, 0), (4, 4, 5), spacing, 1 / rate, seconds, every=seconds)
    return Motion(text, partial(meeting_figures, len(place)),
                  (np.concatenate([place, pool]), np.concatenate([velocity, 0 * pool])))


def meeting_figures(count, run):
    first, last = (state[1][:count] for state in (run.states[0], run.states[-1]))
    off = (last - first).mean(axis=0) - DOWN * run.times[-1]
    return {"momentum_error": np.linalg.norm(off) / np.linalg.norm(first, axis=1).mean()}


# A jet.

def jet(rate, spacing=0.05, speed=4.0, radius=0.15, way=2.4, high=3.0):
    """A level jet from an opening at x = 0.2 m, that a drain swallows 0.4 m beyond `way`, above the floor."""
    start, end = 0.2, way / speed + 0.8
    extra = (f'[[inlet]]\ncenter = [{start}, 0.0, {high}]\nradius = {radius}\ndirection = [1, 0, 0]\nspeed = {speed}\n'
             f'[[drain]]\ntype = "plane"\ncenter = [{start + way + 0.4}, 0, 0]\naxis = [1, 0, 0]\n')
    text = scene_of((0, -1, 0), (start + way + 0.8, 1, high + 1), spacing, 1 / rate, end, every=0.05, extra=extra)
    return Motion(text, partial(jet_figures, start + way, way / speed + 0.1, radius))


def jet_figures(x, since, radius, run):
    """The half-width over the radius: twice the standard deviation of y, as of a uniform disc, from 0.1 m before x to
    0.1 m behind it and from the time `since` on; at the start that of the inlet's lattice, which is some per cent off.
    Few drops far out count much; half_width_median is that of the disc of which half is as near to its middle plane."""
    seen = np.concatenate([place[np.abs(place[:, 0] - x) < 0.1] for (place, _), time in zip(run.states, run.times)
                           if time > since])
    fresh = np.concatenate([place[(place[:, 0] > 0.25) & (place[:, 0] < 0.45)] for place, _ in run.states])
    return {"half_width": 2 * seen[:, 1].std() / radius, "half_width_start": 2 * fresh[:, 1].std() / radius,
            "half_width_median": np.median(np.abs(seen[:, 1])) / 0.404 / radius, "seen": len(seen)}


# Rotation.

def disc(radius, spacing, start):
    """Places (x, y) in a disc: of a lattice, as a block leaves them in a vessel; or in rings, which fill it evenly."""
    n = round(radius / spacing)
    if start == "lattice":
        place = np.stack(np.meshgrid(*2 * [(np.arange(-n, n) + 0.5) * spacing], indexing="ij"), -1).reshape(-1, 2)
        return place[np.hypot(*place.T) < radius]
    rings = []
    for k in range(n):
        count = round(2 * math.pi * (k + 0.5))
        angle = 2 * math.pi * (np.arange(count) + 0.5 * (k % 2)) / count
        rings.append((k + 0.5) * spacing * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    return np.concatenate(rings)


def rotation(rate, spacing=0.05, radius=0.5, layers=10, omega=3.0, turns=1, start="lattice", closed=False):
    """In an upright cylinder that slips. closed: without gravity, filled whole between floor and ceiling. Whole layers
    alone would be a paraboloid of steps; so some columns go a particle higher, that their mean is the surface."""
    turn, depth = 2 * math.pi / omega, layers * spacing
    room = 0 if closed else 10 * spacing
    flat = disc(radius, spacing, start)
    rise = omega**2 / (2 * GRAVITY)
    high = layers if closed else layers + math.ceil(rise * radius**2 / 2 / spacing) + 1
    place = np.concatenate([np.column_stack([flat, np.full(len(flat), (k + 0.5) * spacing)]) for k in range(high)])
    if not closed:
        surface = depth + rise * ((place[:, :2]**2).sum(axis=1) - radius**2 / 2)
        column = np.arange(len(place)) % len(flat)
        place = place[place[:, 2] + spacing / 2 < surface + spacing * (column * (math.sqrt(5) - 1) / 2 % 1)]
    velocity = omega * np.column_stack([-place[:, 1], place[:, 0], np.zeros(len(place))])
    top = high * spacing + room
    wide = radius + 3 * spacing
    vessel = (f'[[obstacle]]\ntype = "cylinder"\ninside = true\ncenter = [0, 0, {top / 2!r}]\nradius = {radius!r}\n'
              f"height = {top + 20 * spacing!r}\n")
    every = turn / (20 if turns == 1 else 8)
    text = scene_of((-wide, -wide, 0), (wide, wide, top), spacing, 1 / rate, turns * turn, not closed, every=every,
                    extra=vessel)
    return Motion(text, partial(rotation_figures, turn, radius, None if closed else rise), (place, velocity))


def rotation_figures(turn, radius, rise, run):
    """Angular momentum about the axis over that of the start after 1, 5 and 10 turns, and how steep the paraboloid is,
    over the exact one (rise: 1/m, at the speed of the start; None: no surface), in the mean of the last 0.35 turns,
    about a period of the first round wave. Water from a lattice flows to the wall first, and turns more slowly then."""
    axial = np.array([(x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]).sum() for x, v in run.states])
    omega = axial / [(x[:, :2]**2).sum() for x, _ in run.states]
    figures = {f"angular_{k}": axial[np.abs(run.times - k * turn).argmin()] / axial[0] for k in (1, 5, 10)
               if run.times[-1] > (k - 0.1) * turn}
    if rise is not None:
        late = np.flatnonzero(run.times > run.times[-1] - 0.36 * turn)
        slower = ((omega[late] / omega[0])**2).mean()
        figures |= {"paraboloid": steepness([run.states[k][0] for k in late], radius) / rise / slower,
                    "paraboloid_start": steepness([run.states[0][0]], radius) / rise}
    figures["energy_left"] = run.columns["kinetic_energy"][-1] / run.columns["kinetic_energy"][0]
    return figures


def steepness(places, radius, rings=6):
    """Slope of the surface against r², 1/m: twice the height of the centre of mass is that of the surface, in rings of
    equal area."""
    place = np.concatenate(places)
    square = (place[:, :2]**2).sum(axis=1)
    ring = np.minimum((square / radius**2 * rings).astype(int), rings - 1)
    count = np.bincount(ring, minlength=rings)
    means = [np.bincount(ring, values, rings) / count for values in (square, 2 * place[:, 2])]
    return np.polyfit(*means, 1)[0]


# A tank that stands askew.

def tank(rate, angle=None, floor="vessel", spacing=0.1, length=2.0, width=1.0, layers=10, amplitude=0.05, seconds=6.0):
    """A plain box, or (angle, degrees about z) the same made by an obstacle, in a larger box; floor: "vessel", the
    obstacle's own, three spacings above the box's, or "box". Starts with linear theory's velocities; amplitude in m."""
    depth = layers * spacing
    size = np.array([length, width, depth + 10 * spacing])
    k = math.pi / length
    omega = math.sqrt(GRAVITY * k * math.tanh(k * depth))
    place = lattice(np.rint(np.array([length, width, depth]) / spacing).astype(int), spacing)
    speed = amplitude * omega / math.sinh(k * depth)
    velocity = np.zeros_like(place)
    velocity[:, 0] = speed * np.cosh(k * place[:, 2]) * np.sin(k * place[:, 0])
    velocity[:, 2] = -speed * np.sinh(k * place[:, 2]) * np.cos(k * place[:, 0])
    place -= size * (0.5, 0.5, 0)
    cos, sin = math.cos(math.radians(angle or 0)), math.sin(math.radians(angle or 0))
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1.0]])
    low, high, vessel = size * (-0.5, -0.5, 0), size * (0.5, 0.5, 1), ""
    if angle is not None:
        reach = np.abs(turn[:2, :2]) @ size[:2] / 2 + 3 * spacing
        below = 3 * spacing if floor == "vessel" else 0
        low, high = np.array([*-reach, -below]), np.array([*reach, size[2] + below])
        deep = size[2] if floor == "vessel" else 2 * size[2]  # the latter from below the floor on
        vessel = (f'[[obstacle]]\ntype = "box"\ninside = true\ncenter = [0, 0, {size[2] - deep / 2!r}]\n'
                  f"size = {plain([length, width, deep])}\nrotate = [0, 0, {float(angle)}]\n")
    text = scene_of(low, high, spacing, 1 / rate, seconds, extra=vessel)
    return Motion(text, partial(tank_figures, (cos, sin), math.pi / omega), (place @ turn.T, velocity @ turn.T))


def tank_figures(along, half_period, run, halves=6):
    """Swings of the centre of mass along the tank, m, and the mean of the first half-periods, s."""
    time = np.array(run.columns["time"])
    tilt = along[0] * np.array(run.columns["com_x"]) + along[1] * np.array(run.columns["com_y"])
    zeros = zeros_of(time, tilt, half_period)[:halves + 1]
    swings = [np.abs(tilt[(time >= a) & (time <= b)]).max() for a, b in zip(zeros, zeros[1:])]
    swings += [NO_FIGURE] * (halves - len(swings))
    return {f"swing_{k + 1}": swing for k, swing in enumerate(swings)} | {
        "half_period": zeros[-1] / (len(zeros) - 1) if len(zeros) > 1 else NO_FIGURE,
        "half_period_ratio": zeros[-1] / (len(zeros) - 1) / half_period if len(zeros) > 1 else NO_FIGURE}


def against_plain_box(figures, plain_box, halves=6):
    ratios = {f"swing_ratio_{k}": figures[f"swing_{k}"] / plain_box[f"swing_{k}"] for k in range(1, halves + 1)}
    return ratios | {"swing_off": np.abs(np.array(list(ratios.values())) - 1).max(),
                     "period_off": abs(figures["half_period"] / plain_box["half_period"] - 1)}


# Flows that repeat.

SIDES = {(1, 0): 1.0, (1, 1): 1.4, (1, 2): 2.2}  # m, of the box for a wave of some 1 m, by its numbers of waves


def shear(dt, across=20, waves=(1, 0), jitter=0.0, gravity=False, speed=1.0, turns=3):
    """u = U sin(2 pi n·x/L) across n, n the direction of `waves`, whose length L is 1 m, 0.99 m for (1, 1) and 0.98 m
    for (1, 2). With gravity a pool of 10 layers, else a box that repeats upwards, too. A turn is L/U. But for (1, 0)
    vortices may grow in it, being in a box longer than a wave; what they have the flow has lost, so the sum stays."""
    spacing, side = 1 / across, SIDES[waves]
    length = side / math.hypot(*waves)
    normal = np.array([*waves, 0]) / math.hypot(*waves)
    layers = 10 if gravity else 6
    place = jittered(lattice((round(side / spacing), round(side / spacing), layers), spacing), spacing, jitter)
    velocity = speed * np.sin(2 * math.pi * (place @ normal) / length)[:, None] * np.array([-normal[1], normal[0], 0])
    high = np.array([side, side, layers * spacing])
    place[:, :2] %= side
    if gravity:
        high[2] *= 2
    else:
        place[:, 2] %= high[2]
    text = scene_of((0, 0, 0), high, spacing, dt, turns * length / speed, gravity, "xy" if gravity else "xyz")
    return Motion(text, partial(shear_figures, length / speed), (place, velocity))


def energy_at(columns, time):
    """Kinetic energy over that of the start."""
    row = int(np.abs(np.array(columns["time"]) - time).argmin())
    return columns["kinetic_energy"][row] / columns["kinetic_energy"][0]


def shear_figures(turn, run):
    return {f"energy_{k}": energy_at(run.columns, k * turn) for k in (1, 3)} | {
        "compression_mean": run.columns["compression_mean"][-1]}


def taylor_green(across, nu, jitter=0.0, dt=0.005, speed=1.0):
    """Four vortices in 1 m, in a box three kernel radii thin."""
    spacing = 1 / across
    place = jittered(lattice((across, across, 6), spacing), spacing, jitter) % (1, 1, 6 * spacing)
    x, y = 2 * math.pi * place[:, 0], 2 * math.pi * place[:, 1]
    velocity = speed * np.stack([np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y), 0 * x], axis=1)
    rate = 16 * math.pi**2 * nu
    shares = {"at_three_quarters": 0.75, "at_half": 0.5, "at_quarter": 0.25}
    times = {name: -math.log(share) / rate for name, share in shares.items()} if nu else {}
    if nu == 0:
        times = {"after_0.25_s": 0.25, "after_0.5_s": 0.5, "after_1_s": 1.0}
    elif times["at_half"] > 3:
        times = {"at_three_quarters": times["at_three_quarters"], "after_3_s": 3.0}
    dt = min(dt, 0.25 * spacing**2 / nu) if nu else dt
    text = scene_of((0, 0, 0), (1, 1, 6 * spacing), spacing, dt, dt * math.ceil(max(times.values()) / dt), False, "xyz",
                    extra=f"[viscosity]\nnu = {nu!r}" if nu else "")
    return Motion(text, partial(decay_figures, times, rate), (place, velocity))


def decay_figures(times, rate, run):
    """Energy over the exact one, each at the row of the series that is nearest to the time."""
    time = np.array(run.columns["time"])
    return {name: energy_at(run.columns, when) * math.exp(rate * time[np.abs(time - when).argmin()])
            for name, when in times.items()} | {"compression_mean": run.columns["compression_mean"][-1]}


# Waves and pools, by known_water.py.

def wave_energy_figures(columns, water):
    """As wave_figures(), and how far the energy ever is above its start, and at the end, as shares of the wave's own.
    Velocities are those of half a step before the places, which alone makes a gain of omega dt/2 (1.9 % at 1/60 s) that
    comes and goes; the means over half-periods are free of it. A low wave's own energy is little: with A = 0.05 m in
    1 m it is that of all water raised by 0.6 mm. own_kinetic_gain does not see such a rise."""
    kinetic = columns["kinetic_energy"]
    energy = (np.array(energies(columns)) - energies(columns)[0]) / kinetic[0]
    rows = max(round(water.half_period / (columns["time"][1] - columns["time"][0])), 1)
    means = np.convolve(energy, np.full(rows, 1 / rows), "valid")
    return wave_figures(columns, water) | {"own_energy_gain": energy.max(), "own_energy_end": energy[-1],
                                           "own_energy_gain_means": means.max() if len(means) else NO_FIGURE,
                                           "own_kinetic_gain": max(kinetic) / kinetic[0] - 1}


def against_60(figures, slow):  # a wave that loses nothing is judged by its energy; 1e-4: scatter of the fit
    return {"loss_over_60": max(figures["loss_per_half"], 0.0) / max(slow["loss_per_half"], 1e-4)}


def pool_figures(columns, water):
    """The last 2 s; rise: of the centre of mass, once as a share of the depth; rise_over_mark: 1 is 0.3 % of the depth
    or 0.1 spacings, whichever is more."""
    found = rest_figures(columns, water, 2)
    spacings = found["com_error_spacings"]
    share = spacings * water.spacing / water.depth
    return {"kinetic_per_mass": found["kinetic_per_mass"], "rise_spacings": spacings, "rise_share": share,
            "rise_over_mark": min(abs(share) / 0.003, abs(spacings) / 0.1)}


def still_figures(spacing, run):
    """The last second."""
    return {"kinetic_per_mass": mean(last(run.columns, "kinetic_energy", 1)) / mass_of(run.columns, spacing)}


# Compression by count.

def sphere(rate, spacing=0.1, radius=0.5, speed=0.5):
    """Half-way up water of 4 x 2 x 2 m with a free surface, from x = 1 m to 3 m."""
    extra = ("[[particles]]\nmin = [0, 0, 0]\nmax = [4, 2, 2]\n"
             f'[[obstacle]]\ntype = "sphere"\ncenter = [1, 1, 1]\nradius = {radius!r}\nvelocity = [{speed!r}, 0, 0]\n')
    text = scene_of((0, 0, 0), (4, 2, 3), spacing, 1 / rate, 2 / speed, extra=extra)
    return Motion(text, partial(drag_figures, 0.5 / speed, 1.5 / speed, 500 * speed**2 * math.pi * radius**2))


def drag_figures(since, until, scale, run):
    time = np.array(run.obstacles["time"])
    force = -np.array(run.obstacles["force_x_0"])[(time > since) & (time < until)]
    half = len(force) // 2
    return {"drag": force.mean() / scale, "drag_first_half": force[:half].mean() / scale,
            "drag_second_half": force[half:].mean() / scale}

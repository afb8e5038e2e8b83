"""Water whose right answer is known: pools at rest, standing waves, colliding jets, a turning ball; how each starts and
what its run is judged by. No program of its own.

A standing wave of the first mode in a closed tank of length L and depth d: omega² = g k tanh(k d), k = pi/L; its
velocities when the surface passes through level, with amplitude A: u = A omega cosh(k z) sin(k x) / sinh(k d),
w = −A omega sinh(k z) cos(k x) / sinh(k d). (Lamb, Hydrodynamics, 6th ed., §228, §257.)
"""

import math
from typing import NamedTuple

import numpy as np

from study import GRAVITY, STRESS, energy_gain, mass_of, mean


STATES = ["output.checkpoint={every=0.1,keep=1000}"]  # the setting that keeps what momentum_figures() reads


class Water(NamedTuple):
    scene: str
    settings: list
    layers: int = 0  # 0: no layers, as it hangs in the air
    length: float = 1.0  # m, of the tank
    spacing: float = 0.1  # m
    half_period: float = math.nan  # s, of the wave by linear theory
    diagonal: bool = False
    cloud: tuple | None = None  # positions and velocities at the start, where the scene's own blocks do not do

    @property
    def path(self):
        return STRESS / f"{self.scene}.toml"

    @property
    def depth(self):
        return self.layers * self.spacing


class Tank(NamedTuple):
    layers: int
    length: float = 1.0  # m
    width: float = 1.0  # m
    spacing: float = 0.1  # m
    ratio: float = 2  # kernel radius over spacing
    steps_per_second: float = 60
    seconds: float = 20
    room: float = 0  # m of air that the water needs beyond what its kernel does

    def settings(self):
        height = (self.layers + max(10, 4 * self.ratio)) * self.spacing + self.room
        high = f"{self.length:g},{self.width:g}"
        return [f"fluid.spacing={self.spacing:g}", f"fluid.kernel_radius={self.ratio * self.spacing:g}",
                f"domain.max=[{high},{height:g}]", f"particles.0.max=[{high},{self.layers * self.spacing:g}]",
                f"time.dt={1 / self.steps_per_second!r}", f"time.end={self.seconds!r}"]

    def lattice(self):
        axes = [(np.arange(round(size / self.spacing)) + 0.5) * self.spacing
                for size in (self.length, self.width, self.layers * self.spacing)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def pool(tank, jitter=0.0, seed=1):
    """Water at rest; jitter: spacings, the most that each coordinate of the start lattice is off, at random."""
    cloud = None
    if jitter > 0:
        place = tank.lattice()
        place += np.random.default_rng(seed).uniform(-jitter, jitter, place.shape) * tank.spacing
        cloud = place, np.zeros_like(place)
    return Water("column", tank.settings(), tank.layers, tank.length, tank.spacing, cloud=cloud)


def wave(tank, amplitude, diagonal=False):
    """amplitude: spacings; diagonal: the modes along x and y of a square tank together, which tilt it along its diagonal."""
    k, depth = math.pi / tank.length, tank.layers * tank.spacing
    omega = math.sqrt(GRAVITY * k * math.tanh(k * depth))
    place = tank.lattice()
    velocity = np.zeros_like(place)
    speed = amplitude * tank.spacing * omega / math.sinh(k * depth) / (math.sqrt(2) if diagonal else 1)
    for axis in (0, 1) if diagonal else (0,):
        velocity[:, axis] = speed * np.cosh(k * place[:, 2]) * np.sin(k * place[:, axis])
        velocity[:, 2] -= speed * np.sinh(k * place[:, 2]) * np.cos(k * place[:, axis])
    settings = tank._replace(room=4 * amplitude * tank.spacing).settings()
    return Water("column", settings, tank.layers, tank.length, tank.spacing, math.pi / omega, diagonal, (place, velocity))


def in_the_air(ratio, steps_per_second):
    return [f"fluid.kernel_radius={ratio * 0.1:g}", f"time.dt={1 / steps_per_second!r}"]


def jets(ratio=2, steps_per_second=60):
    return Water("jets", in_the_air(ratio, steps_per_second))


def turning_ball(ratio=2, steps_per_second=60, radius=0.7, turn=2.0, closing=1.0):
    """A ball of lattice water that turns about an axis along no lattice direction, `turn` rad/s. It would fly apart, and
    nothing would press, if it did not start closing in, too: −closing r, 1/s."""
    middle = np.array([4.0, 3.0, 3.0])
    steps = (np.arange(-10, 10) + 0.5) * 0.1
    place = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    place = place[np.linalg.norm(place, axis=1) < radius]
    velocity = np.cross(turn * np.array([1.0, 2.0, 3.0]) / math.sqrt(14), place) - closing * place
    return Water("jets", in_the_air(ratio, steps_per_second), cloud=(middle + place, velocity))


def last(columns, name, seconds):
    """The column's values in the last seconds of the run."""
    end = columns["time"][-1]
    return [value for time, value in zip(columns["time"], columns[name]) if time > end - seconds]


def rest_figures(columns, water, seconds=5.0):
    """Motion (m²/s²) and centre of mass in the last seconds, the latter as a share of its height and in spacings."""
    level = water.depth / 2
    off = mean(last(columns, "com_z", seconds)) - level
    return {"kinetic_per_mass": mean(last(columns, "kinetic_energy", seconds)) / mass_of(columns, water.spacing),
            "com_error": off / level, "com_error_spacings": off / water.spacing}


def later_gain(columns, spacing=0.1, since=1.0):
    """As energy_gain(), above the total energy at the time `since`, s, instead of the start. A disturbed lattice is
    compressed here and there, which is energy that the sums do not know and that the first steps set free."""
    start = sum(time < since for time in columns["time"])
    later = {name: values[start:] for name, values in columns.items()}
    return energy_gain(later, spacing) if later["time"] else math.nan


def tilt_of(columns, water):
    """m, where the centre of mass is, against the tank's middle, along x or the diagonal."""
    x = np.array(columns["com_x"]) - water.length / 2
    return (x + np.array(columns["com_y"]) - water.length / 2) / math.sqrt(2) if water.diagonal else x


def zeros_of(time, tilt, half_period):
    """Times at which the wave passes through level, the start first. Ripples cross zero, too: none within 0.3
    half-periods of the one before."""
    zeros = [0.0]
    for k in np.flatnonzero(tilt[:-1] * tilt[1:] < 0):
        zero = time[k] + (time[k + 1] - time[k]) * tilt[k] / (tilt[k] - tilt[k + 1])
        if zero - zeros[-1] > 0.3 * half_period:
            zeros.append(zero)
    return zeros


def end_of(time, tilt, half_period):
    """Mean and amplitude of the last two periods, by least squares: a constant and a wave that grows or fades evenly.
    (The plain mean of a fading wave is not zero.)"""
    chosen = time > time[-1] - 4 * half_period
    since = time[chosen] - time[chosen].mean()
    cosine, sine = np.cos(math.pi * since / half_period), np.sin(math.pi * since / half_period)
    terms = np.stack([np.ones_like(since), cosine, sine, since * cosine, since * sine], axis=1)
    mean_tilt, a, b, *_ = np.linalg.lstsq(terms, tilt[chosen], rcond=None)[0]
    return mean_tilt, math.hypot(a, b)


def wave_figures(columns, water, halves=6):
    """Mean of the first half-periods over linear theory's, share lost in each of them, and as shares of the first swing
    what is left of the wave in the last two periods and about which tilt it swings there: what stands for good."""
    time, tilt = np.array(columns["time"]), tilt_of(columns, water)
    zeros = zeros_of(time, tilt, water.half_period)[:halves + 1]
    figures = dict.fromkeys(("period_ratio", "loss_per_half", "wave_left", "tilt_left"), math.nan)
    if len(zeros) < 3:
        return figures
    swings = [np.abs(tilt[(time >= a) & (time <= b)]).max() for a, b in zip(zeros, zeros[1:])]
    half_period = zeros[-1] / (len(zeros) - 1)
    standing, left = end_of(time, tilt, half_period)
    each = np.exp(np.polyfit(np.arange(len(swings)), np.log(swings), 1)[0])
    return {"period_ratio": half_period / water.half_period, "loss_per_half": 1 - each, "wave_left": left / swings[0],
            "tilt_left": abs(standing) / swings[0]}


def momentum_figures(states):
    """The most that linear and angular momentum (about the first centre of mass) ever differ from their start, against
    the sums of |v| and |r||v|."""
    if len(states) < 2:
        return {"momentum_error": math.nan, "angular_error": math.nan}
    centre = states[0][0].mean(axis=0)
    arm, velocity = states[0][0] - centre, states[0][1]
    speed = np.linalg.norm(velocity, axis=1)
    linear = [v.sum(axis=0) for _, v in states]
    angular = [np.cross(x - centre, v).sum(axis=0) for x, v in states]
    return {"momentum_error": max(np.linalg.norm(p - linear[0]) for p in linear) / speed.sum(),
            "angular_error": max(np.linalg.norm(p - angular[0]) for p in angular)
            / (np.linalg.norm(arm, axis=1) * speed).sum()}


def figures_of(columns, states, water):
    """All figures that the water's kind has, by name."""
    figures = {"energy_gain": energy_gain(columns, water.spacing), "compression_start": columns["compression_max"][0],
               "compression_mean": mean(columns["compression_mean"][1:])}
    if water.layers:
        figures["later_gain"] = later_gain(columns, water.spacing)
        figures |= rest_figures(columns, water)
    else:
        figures |= momentum_figures(states)
    if not math.isnan(water.half_period):
        figures |= wave_figures(columns, water)
    return figures

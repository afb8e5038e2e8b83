"""A drop in two dimensions without gravity that is stretched, of which the right answer is known: a circle with the motion
(-A x, A z) becomes an ellipse of half-axes a and b, a b = R², and keeps its energy, so that the speeds of both obey
a'² + b'² = 2 A² R² (Monaghan 1994, Simulating free surface flows with SPH, §5.1). No program of its own; study_motion.py
runs it.
"""

import math
from functools import partial

import numpy as np

from known_motion import Motion, lattice, scene_of


def drop(rate, spacing=0.05, radius=1.0, stretching=2.0, seconds=0.8):
    """A circle of that radius, m; stretching: A, 1/s."""
    cells = round(2.4 * radius / spacing)
    place = lattice((cells, 1, cells), spacing, 3 * [-cells * spacing / 2]) * (1, 0, 1)
    place = place[np.linalg.norm(place, axis=1) < radius]
    velocity = place * (-stretching, 0, stretching)
    middle = np.array([3.01, 0, 5.02])
    text = scene_of((0, 0, 0), (6, spacing, 10), spacing, 1 / rate, seconds, gravity=False, every=seconds, extra="")
    return Motion(text, partial(drop_figures, radius, stretching), (place + middle, velocity), ("domain.dimensions=2",))


def half_axes(radius, stretching, time, steps=10000):
    """By the midpoint rule."""
    def shrinking(a):
        return math.sqrt(2) * stretching * radius / math.sqrt(1 + (radius / a) ** 4)
    a, dt = radius, time / steps
    for _ in range(steps):
        a -= dt * shrinking(a - dt / 2 * shrinking(a))
    return a, radius**2 / a


def drop_figures(radius, stretching, run):
    """Half-axes by the moments of the particles' places, over the exact ones; energy over that of the start."""
    short, long = half_axes(radius, stretching, run.times[-1])
    place = run.states[-1][0] - run.states[-1][0].mean(axis=0)
    found = 2 * np.sqrt((place**2).mean(axis=0))
    energy = np.array(run.columns["kinetic_energy"])
    return {"short_axis": found[0] / short, "long_axis": found[2] / long, "energy": energy[-1] / energy[0],
            "energy_most": energy.max() / energy[0]}

"""A block of water, a sheet or a particle that is let go on a smooth slope, in two dimensions. No program of its own; study_motion.py runs it.

The slope pushes along its normal alone, wherever the water collapses and runs: what it gains of momentum down the
slope is its weight times the sine of the angle, times the time. No energy comes from anywhere.
"""

import math
from functools import partial

import numpy as np

import known_motion as known
from study import GRAVITY, energies, largest_rise, mass_of

SLOPE = "[[obstacle]]\ntype = \"box\"\ncenter = {center}\nsize = [9, 3]\nrotate = [0, {angle}, 0]\n"


def slope(rate, angle, spacing=0.05, length=1.0, height=0.4, seconds=0.8):
    """Down towards +x; `angle`, degrees; the lattice lies along it."""
    lean = math.radians(angle)
    down, normal = np.array([math.cos(lean), 0, -math.sin(lean)]), np.array([math.sin(lean), 0, math.cos(lean)])
    upper_end = np.array([1.5, 0, 4.0])  # of the block, on the slope
    place = known.lattice((round(length / spacing), 1, round(height / spacing)), spacing)
    place = upper_end + place[:, :1] * down + place[:, 2:] * normal
    middle = upper_end - 1.5 * normal + 3 * down
    text = known.scene_of((0, 0, 0), (9, spacing, 6), spacing, 1 / rate, seconds,
                          extra=SLOPE.format(center=known.plain(middle[[0, 2]]), angle=angle))
    return known.Motion(text, partial(slope_figures, down, lean, spacing), (place, 0 * place), ["domain.dimensions=2"])


def slope_figures(down, lean, spacing, run):
    """Momentum down the slope over that which gravity gives, in the mean of the second half and at the end; and the
    largest rise of the energy over the least before, over the kinetic energy of what slides alone at the end."""
    time = np.asarray(run.columns["time"])
    along = sum(down[axis] * np.asarray(run.columns[f"momentum_{'xyz'[axis]}"]) for axis in (0, 2))
    later = time > time[-1] / 2
    mass = mass_of(run.columns, spacing)
    exact = mass * GRAVITY * math.sin(lean) * time
    return {"momentum_ratio": np.mean(along[later] / exact[later]), "momentum_ratio_end": along[-1] / exact[-1],
            "energy_rise": largest_rise(energies(run.columns)) * 2 * mass / exact[-1]**2}

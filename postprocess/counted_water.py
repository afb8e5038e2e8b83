"""Compression by count: how many particles are in cubes of the interior, each as a cube of one spacing, against how many
full water has. Kernel sums tell 0.1 % where water is 1 % too thin. No program of its own."""

import itertools
from functools import partial

import numpy as np

from known_motion import NO_FIGURE, Motion, plain, scene_of
from study import GRAVITY, energies, mass_of, mean


def counted(text, low, high, spacing, settings=(), since=0.0, every=0.1):
    """A scene between walls, of which the particles in small cubes are counted each `every` s, after the time `since`:
    that of an impact, before which water has the count that it started with."""
    return Motion(text, partial(count_figures, np.array(low), np.array(high), spacing, since),
                  settings=(*settings, f"output.checkpoint={{every={every!r},keep=1000}}"))


def falling_block(low, high, block_low, block_high, spacing, rate, seconds):
    block = f"[[particles]]\nmin = {plain(block_low)}\nmax = {plain(block_high)}\n"
    text = scene_of(low, high, spacing, 1 / rate, seconds, extra=block)
    return counted(text, low, high, spacing)


def interior_counts(place, low, high, spacing):
    """Particles in the cubes of 4 spacings, two spacings apart, that are all water: each cube and what is 2 spacings
    around it is made of parts of 2 spacings, which hold 8 particles; none of them holds less than 5 (beyond walls, all
    do). A particle is a cube of one spacing, of which each part gets what lies in it, and the part at a wall what would
    be beyond. By their middles a lattice that flows, whose layers draw together upwards as their particles part
    sideways, has a quarter too much in all cubes at once wherever a fifth layer comes in; so that of a dam break has
    64 to 2e-3, and evenly stretched ones, by up to a quarter, to 2e-2 however they lie to the walls. Lattices turned
    anyhow, with a wavy surface, have a mean of 64 to 4e-4. Cubes overlap, so that what is at walls counts less than
    the rest: where water crowds there, the mean is below 64 in a box that is full."""
    parts = np.floor((np.array(high) - low) / (2 * spacing) + 1e-6).astype(int)
    first = (place - low) / (2 * spacing) - 0.25
    lower = np.floor(first).astype(int)
    beyond = np.clip(2 * (first - lower) - 1, 0, 1)  # share of the next part along each axis
    count = np.zeros(parts)
    for step in itertools.product((0, 1), repeat=3):
        shares = np.where(step, beyond, 1 - beyond).prod(axis=1)
        np.add.at(count, tuple(np.clip(lower + step, 0, parts - 1).T), shares)
    full = np.pad(count >= 5, 1, constant_values=True)

    def over(values, length, axis, join):
        size = values.shape[axis] - length + 1
        return join([np.take(values, range(k, k + size), axis) for k in range(length)], axis=0)

    cubes = count
    for axis in range(3):
        cubes, full = over(cubes, 2, axis, np.sum), over(full, 4, axis, np.all)
    return cubes[full]


def count_figures(low, high, spacing, since, run):
    """Compression by count in the mean over cubes and checkpoints, and the largest and the least mean of one checkpoint
    (of 8 cubes at least, and the time of the largest); that by the kernel; and the energy at 1 and 1.5 s, above that of
    all water at rest on the floor, as a share of what it was."""
    times = run.times[run.times > since]
    places = [place for (place, _), time in zip(run.states, run.times) if time > since]
    counts = [interior_counts(place, low, high, spacing) / 64 - 1 for place in places]
    means = np.array([cubes.mean() if len(cubes) >= 8 else NO_FIGURE for cubes in counts])
    whole = not np.isnan(means).all()  # water that is whole anywhere, not spray
    everything = np.concatenate(counts)
    columns = run.columns
    mass = columns["potential_energy"][0] / GRAVITY / (columns["com_z"][0] - low[2])  # calibrated
    depth = mass_of(columns, spacing) / 1000 / np.prod((high - low)[:2])
    energy = np.array(energies(columns)) - mass * GRAVITY * depth / 2
    time = np.array(columns["time"])
    figures = {"count_mean": everything.mean() if len(everything) else NO_FIGURE, "count_cubes": len(everything),
               "count_impact": np.nanmax(means) if whole else NO_FIGURE,
               "count_impact_time": times[np.nanargmax(means)] if whole else NO_FIGURE,
               "count_least": np.nanmin(means) if whole else NO_FIGURE,
               "compression_mean": mean(columns["compression_mean"][1:])}
    return figures | {f"energy_{when:g}_s": energy[np.abs(time - when).argmin()] / energy[0] for when in (1, 1.5)
                      if time[-1] > when - 0.01}

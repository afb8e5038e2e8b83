"""Where the water is between the particles, and where it is white, for surface.py. No program of its own.

The share of each place that is water is the sum of the particles' volumes, spread by kernels that are flat where the water
is: across a surface or a sheet they are short, along it long, as the covariance of the neighbours' places says. After
J. Yu and G. Turk, Reconstructing surfaces of particle-based fluids using anisotropic kernels, ACM Trans. Graph. 32 (2013),
but with centres that are not moved: their smoothing takes 6 % of a block of 20³ particles.

White is water that air is driven into, by M. Ihmsen et al., Unified spray, foam and air bubbles for particle-based fluids,
Vis. Comput. 28 (2012): fast, and with neighbours that come towards it or are few.
"""

from collections import namedtuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree

# Lengths are in spacings.
LEVELS = (0.3, 0.6)  # shares between which the surface is; at 0.4 drops, sheets and blocks keep their volume by themselves
CELLS = 2  # of the grid, in a spacing
REACH = 3.0  # of neighbours whose places tell the shape of the water
INSIDE = 1.15  # standard deviation of these places along any axis, inside of the water
FULL = 85  # neighbours that only particles inside have (113 in the mean)
CENTRED = 0.2  # and how far from the middle of its neighbours such a one is at most
RADIUS = 2.0  # of a kernel inside
STRETCH = 2.5  # longest axis of a kernel over its shortest
LONGEST = 0.7  # of RADIUS, that the longest axis has at least
FEW, MANY = 4, 16  # neighbours with which a particle counts as a drop of its own, and as a part of the water
DROP, DROP_WEIGHT = 1.25, 1.5  # radius and weight of a drop's kernel: its volume is right within 7 %
AT_A_TIME = 3_000_000  # values
TRAPPED, ENERGY = (5.0, 20.0), (1.0, 4.0)  # m/s: where white begins, and where it is full

Kernels = namedtuple("Kernels", "axes radii volume deep deepest")


def neighbourhood(position, reach):
    """Of each pair within reach, 1 - (distance / reach)³, as a sparse matrix; 1 of each particle with itself."""
    one, two = cKDTree(position).query_pairs(reach, output_type="ndarray").T
    weight = 1 - (np.linalg.norm(position[one] - position[two], axis=1) / reach) ** 3
    count = len(position)
    own = np.arange(count)
    rows, columns = np.concatenate([one, two, own]), np.concatenate([two, one, own])
    return coo_matrix((np.concatenate([weight, weight, np.ones(count)]), (rows, columns)), (count, count)).tocsr()


def kernels_of(position, spacing):
    """Axes (as columns), radii (m) and volume of each particle's kernel; which particles are deep inside, all neighbours
    being inside, and which are deepest, all neighbours being deep."""
    weight = neighbourhood(position, REACH * spacing)
    neighbours = np.diff(weight.indptr) - 1
    total = np.asarray(weight.sum(axis=1))
    mean = weight @ position / total
    first, second = [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]
    spread = weight @ (position[:, first] * position[:, second]) / total - mean[:, first] * mean[:, second]
    variance, axes = np.linalg.eigh(spread[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3))
    length = variance / (INSIDE * spacing) ** 2
    length *= np.maximum(1, LONGEST / np.maximum(length[:, 2:], 1e-9))
    length = np.clip(length, length[:, 2:] / STRETCH, 1.1)
    water = np.clip((neighbours - FEW) / (MANY - FEW), 0, 1)[:, None]
    inside = (neighbours > FULL) & (np.linalg.norm(mean - position, axis=1) < CENTRED * spacing)
    deep = weight @ (~inside).astype(float) == 0
    return Kernels(axes, spacing * (DROP + water * (RADIUS * length - DROP)),
                   spacing**3 * (DROP_WEIGHT + water[:, 0] * (1 - DROP_WEIGHT)),
                   deep, weight @ (~deep).astype(float) == 0)


def box_of(*ranges):
    """All offsets of cells within three ranges, one a row."""
    return np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, 3)


def share_of_water(position, spacing):
    """On a grid around all particles, x fastest: its lowest corner, cell (m), sizes, and the share of each node."""
    kernels = kernels_of(position, spacing)
    margin, cell = (1.1 * RADIUS + 0.5) * spacing, spacing / CELLS
    low = position.min(axis=0) - margin
    size = np.ceil((position.max(axis=0) + margin - low) / cell).astype(int) + 1
    stride = np.array([1, size[0], size[0] * size[1]])
    share = np.zeros(size.prod())
    base = np.floor((position - low) / cell).astype(np.int64)
    # What is deep inside cannot be near the surface, and need not be known better; kernels of the deepest reach no other.
    for offset in box_of(*[np.arange(1 - CELLS, CELLS + 1)] * 3):
        share[(base[kernels.deep] + offset) @ stride] = 1
    extent = np.sqrt(np.einsum("nik,nk->ni", kernels.axes**2, kernels.radii**2))
    cells = np.ceil(extent / cell).astype(int)
    found = Collected(share)
    # Particles with boxes of one size at a time.
    for box in np.unique(cells[~kernels.deepest], axis=0):
        offsets = box_of(*[np.arange(-k, k + 2) for k in box])
        members = np.flatnonzero(~kernels.deepest & (cells == box).all(axis=1))
        for part in np.array_split(members, -(-len(members) * len(offsets) // AT_A_TIME)):
            start = low + base[part] * cell - position[part]
            nodes, values = spread_out(start, offsets * cell, Kernels(*(field[part] for field in kernels)))
            number = (base[part] @ stride)[:, None] + (offsets @ stride)
            found.add(number[nodes], values)
    found.write()
    return low, cell, size, share


class Collected:
    """Values that are to be added to some elements of a long array, written many at a time, as each time costs its length."""

    def __init__(self, target):
        self.target, self.parts, self.count = target, [], 0

    def add(self, numbers, values):
        self.parts.append((numbers, values))
        self.count += len(numbers)
        if self.count > 2 * len(self.target):
            self.write()

    def write(self):
        if self.parts:
            numbers, values = (np.concatenate(column) for column in zip(*self.parts))
            self.target += np.bincount(numbers, values, len(self.target))
        self.parts, self.count = [], 0


def spread_out(start, offsets, kernels):
    """Which of start + offsets (a row for each kernel) are within the kernels, and the share that they get (cubic spline)."""
    inverse = kernels.axes / kernels.radii[:, None, :]
    way = np.einsum("ni,nik->nk", start, inverse)[:, None, :] + np.einsum("oi,nik->nok", offsets, inverse)
    square = np.einsum("nok,nok->no", way, way)
    within = square < 1
    q = np.sqrt(square[within])
    amplitude = kernels.volume * 8 / (np.pi * kernels.radii.prod(axis=1))
    amplitude = np.broadcast_to(amplitude[:, None], square.shape)[within]
    return within, amplitude * np.where(q < 0.5, 1 - 6 * q * q * (1 - q), 2 * (1 - q) ** 3)


def ramp(value, ends):
    return np.clip((value - ends[0]) / (ends[1] - ends[0]), 0, 1)


def white(position, velocity, spacing):
    """How white each particle is, 0 to 1, and which of them are spray: fewer than 6 neighbours within 2 spacings.

    Without velocities (all zero) all that has few neighbours is white.
    """
    reach = 2 * spacing
    one, two = cKDTree(position).query_pairs(reach, output_type="ndarray").T
    way, faster = position[one] - position[two], velocity[one] - velocity[two]
    distance, speed = np.linalg.norm(way, axis=1), np.linalg.norm(faster, axis=1)
    towards = speed - np.einsum("ij,ij->i", way, faster) / np.maximum(distance, 1e-9)
    both = np.concatenate([one, two])
    driven = np.bincount(both, np.tile(towards * (1 - distance / reach), 2), len(position))
    neighbours = np.bincount(both, minlength=len(position))
    energy = ramp(np.linalg.norm(velocity, axis=1), ENERGY) if velocity.any() else 1
    return energy * np.maximum(ramp(driven, TRAPPED), ramp(neighbours, (20, 6))), neighbours < 6

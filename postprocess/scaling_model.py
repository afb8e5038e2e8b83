"""The performance model of slabs: fitted to runs on one rank and to a network, it tells the time of a step.

No program of its own; scaling.py prints and draws it, results/scaling.md explains it. Water is a basin at rest, a block
of particles in lattice order, h = 2 spacings, so a cell plane is two layers thick. Seconds, bytes, particles.
"""

import math
from typing import NamedTuple

RECORD = 16  # bytes of a packed record in single precision
ITERATIONS = 4  # of the default, the first on the coarse grid
CYCLES = 3  # of the coarse grid's multigrid
SWEEPS = 4  # in a cycle on each level
GATHERED_CELLS = 4096  # at most, on the levels that all ranks have
WATER = 8 * (3 + 2 * 5) + 8  # bytes of a coarse cell before the multigrid: volumes and moments, fill
EXCHANGES = 1 + 1 + 2 * (ITERATIONS - 1)  # records, coarse move, lambda and place of each sweep over particles
REDUCTIONS = 4  # depth of the water, guard, two migrations
LOOK = 10  # steps between two looks at the balance


class Basin(NamedTuple):
    length: float  # layers of particles along the slab axis
    width: float
    depth: float
    air: float = 20  # layers of the box above the water

    def particles(self):
        return self.length * self.width * self.depth

    def planes(self):
        return math.ceil(self.length / 2)

    def cells(self):
        return self.particles() / 8

    def columns(self):
        """Cells above one another that the coarse grid looks at."""
        return min((self.depth + self.air) / 2, math.ceil(self.depth / 2) + 2)

    def levels(self):
        """Rows of cells on each level of the multigrid that is not gathered, and what an exchange of all that a step
        sends on it counts, in planes and per direction; what goes one way only counts half."""
        planes, rows, found = self.planes(), math.ceil(self.width / 2), []
        number = min(1 + math.ceil(self.depth / 2).bit_length(), 1 + (max(planes, rows) - 1).bit_length())
        for level in range(number):
            if level > 0 and planes * rows * self.columns() <= GATHERED_CELLS:
                break
            fields = 1 if level == 0 else 4  # known to one side: sinks, and links
            residuals = CYCLES if level + 1 < number else 0
            found.append((rows, 1 + CYCLES * SWEEPS + (fields + residuals) / 2))
            planes, rows = math.ceil(planes / 2), math.ceil(rows / 2)
        return found

    def sweeps(self):
        """Of all levels, in those of the finest."""
        return CYCLES * SWEEPS * 4 / 3


class Costs(NamedTuple):
    particle: float  # s for a particle and step, all but the coarse sweeps
    cell: float  # s for a cell of water and coarse sweep
    latency: float  # s of an exchange without bytes
    bandwidth: float  # bytes/s through a cut in one direction
    reduction: float  # s of a sum over two ranks


class Step(NamedTuple):
    particles: float  # s for the particles of the fullest rank
    coarse: float  # s for its cells
    latency: float
    transfer: float
    reductions: float

    def total(self):
        return sum(self)


def exchange_bytes(basin, filters=0):
    """Bytes through one cut in one direction and step: counts, records, coarse planes. The same formula as in
    tests/mpi/test_traffic.cpp, in the mean of both directions. `filters`: exchanges of the velocity filters."""
    coarse = WATER * (basin.width / 2 + 2) + sum(8 * planes * (rows + 2) for rows, planes in basin.levels())
    return rebuild_bytes(basin) + (EXCHANGES - 1 + filters) * plane_bytes(basin) + coarse * (basin.columns() + 2)


def rebuild_bytes(basin):
    """Of that, what the start of a run sends, too: the counts and the records once."""
    return 4 * basin.width / 2 * (basin.depth + basin.air) / 2 + plane_bytes(basin)


def plane_bytes(basin):
    return 2 * basin.width * basin.depth * RECORD


def messages(basin, filters=0):
    """Through one cut in one direction and step, in the mean of both; two of them at the start of a run."""
    return 1 + EXCHANGES + filters + 2 + sum(planes for _, planes in basin.levels())


def slabs(basin, ranks, costs):
    """The time of a step, None where there are more ranks than planes. Nothing is taken to be hidden."""
    planes = basin.planes()
    if ranks > planes:
        return None
    fullest = math.ceil(planes / ranks) / planes
    sides = min(ranks - 1, 2)  # neighbours, whose messages share the way out
    rounds = math.log2(ranks)
    look = (8 * planes / costs.bandwidth + rounds * costs.latency) / LOOK if ranks > 1 else 0
    return Step(fullest * basin.particles() * costs.particle, fullest * basin.cells() * basin.sweeps() * costs.cell,
                (messages(basin) * costs.latency) if sides else 0, sides * exchange_bytes(basin) / costs.bandwidth,
                REDUCTIONS * rounds * costs.reduction + look)


def pencils(basin, ranks, costs):
    """The same for a box that is cut along its length and its width, as square as the numbers allow: a guess at what a
    rewrite would give, with twice the messages in each exchange and bytes by the surface of a pencil."""
    along = min(basin.planes(), max(1, round(math.sqrt(ranks * basin.length / basin.width))))
    across = ranks / along
    if across > basin.width / 2:
        return None
    if across <= 1:
        return slabs(basin, ranks, costs)
    share = math.ceil(basin.planes() / along) / basin.planes() * math.ceil(basin.width / 2 / across) / (basin.width / 2)
    surface = exchange_bytes(basin) * (1 / across + basin.length / basin.width / along)
    return Step(share * basin.particles() * costs.particle, share * basin.cells() * basin.sweeps() * costs.cell,
                2 * messages(basin) * costs.latency, 2 * surface / costs.bandwidth,
                REDUCTIONS * math.log2(ranks) * costs.reduction)


def efficiency(basin, ranks, step, costs):
    return slabs(basin, 1, costs).total() / ranks / step.total()


def redundant_lambda(plane, lambda_cost, search_cost):
    """Seconds an iteration for lambda and neighbours of the two ghost planes of `plane` particles, which a wider ghost
    layer computes itself to save an exchange."""
    return 2 * plane * (lambda_cost + search_cost / (ITERATIONS - 1))

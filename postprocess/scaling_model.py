"""The performance model of slabs and threads: fitted to runs on one core and to a network, it tells the time of a step.

No program of its own; scaling.py prints and draws it, results/scaling.md explains it. Water is a basin at rest, a block
of particles in lattice order, h = 2 spacings, so a cell plane is two layers thick. Seconds, bytes, particles.
"""

import math
from typing import NamedTuple

PLACE, SCALAR = 12, 4  # bytes of a packed record in single precision, of which an exchange sends one or the other
FILTERS = {0: 0, 1: PLACE, 2: PLACE + SCALAR, 3: 2 * PLACE + SCALAR}  # bytes; exchanges of XSPH (1) and vorticity (2)
ITERATIONS = 4  # of the default, the first on the coarse grid
CYCLES = 3  # of the coarse grid's multigrid
SWEEPS = 4  # in a cycle on each level
GATHERED_CELLS = 4096  # at most, on the levels that all ranks have
MOMENTS, FIT = 10 + 12 + 1, 13  # numbers of a cell's particles, and of an affine fit
# Bytes of a cell of the projection beside the multigrid: volumes and moments, fit; noise and its fit; shifts, in the memory
# of moments, and theirs. And its fill.
FIELDS, FILL = 8 * (2 * (3 + MOMENTS) + 3 * FIT + 12), 8
WATER_EXCHANGES = 8  # heights of the water, and these
# Records, projected move, lambda and place of each sweep over particles, water in flight, filtered shifts.
EXCHANGES = 1 + 1 + 2 * (ITERATIONS - 1) + 2
REDUCTIONS = 4  # depth of the water, guard, two migrations
GATHERS = 2 + CYCLES  # of the multigrid: cuts, links, and a right-hand side in each cycle
LOOPS = 57  # of a step that threads share, without those of the levels of the multigrid
PARTICLE_BYTES, GHOST_BYTES = 300, 45  # of a ghost: record, and an eighth of a coarse cell
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

    def level_count(self):
        widest = max(self.planes(), math.ceil(self.width / 2))
        return min(1 + math.ceil(self.depth / 2).bit_length(), 1 + (widest - 1).bit_length())

    def levels(self):
        """Rows of cells on each level of the multigrid that is not gathered, and what an exchange of all that a step
        sends on it counts, in planes and per direction; what goes one way only counts half."""
        planes, rows, found = self.planes(), math.ceil(self.width / 2), []
        number = self.level_count()
        for level in range(number):
            if level > 0 and planes * rows * self.columns() <= GATHERED_CELLS:
                break
            fields = 1 if level == 0 else 4  # known to one side: sinks, and links
            residuals = CYCLES if level + 1 < number else 0
            found.append((rows, 1 + CYCLES * SWEEPS + (fields + residuals) / 2))
            planes, rows = math.ceil(planes / 2), math.ceil(rows / 2)
        return found


class Costs(NamedTuple):
    particle: float  # s for a particle and step on one thread, all but what follows
    cell: float  # s for a cell of water and coarse sweep
    latency: float  # s of an exchange without bytes
    bandwidth: float  # bytes/s out of a node, or between two ranks of it
    reduction: float  # s of a sum over two ranks
    by_planes: float = 0.0  # s for a particle and step in loops whose parts are planes
    serial: float = 0.0  # s for a particle and step on the first thread alone
    migration: float = 0.0  # the same, where there is more than one rank
    fork: float = 0.0  # s of a loop's start and end for each of its threads
    traffic: float = 0.0  # bytes for a particle and step from and to memory


class Node(NamedTuple):
    """What ranks of a node share."""
    ranks: int = 1
    memory: float = math.inf  # bytes/s
    between: float = math.inf  # bytes/s from rank to rank


class Step(NamedTuple):
    rows: float  # s in loops over particles and rows of cells, in the fullest rank
    planes: float  # s in loops over planes
    serial: float
    coarse: float  # s for its cells
    forks: float
    latency: float
    transfer: float
    reductions: float

    def total(self):
        return sum(self)


def exchange_bytes(basin, filters=0):
    """Bytes through one cut in one direction and step: counts, records, coarse planes. The same formula as in
    tests/domain/test_traffic.cpp, in the mean of both directions. `filters`: exchanges of the velocity filters."""
    rows = basin.width / 2 + 2
    fields = FIELDS * rows * math.ceil(basin.columns() / 8) * 8  # columns eight at a time
    coarse = FILL * rows + sum(8 * planes * (rows + 2) for rows, planes in basin.levels())
    heights = 4 * basin.width / 2
    records = (ITERATIONS + 1) * PLACE + ITERATIONS * SCALAR + FILTERS[filters]
    return rebuild_bytes(basin) + plane_particles(basin) * records + heights + fields + coarse * (basin.columns() + 2)


def rebuild_bytes(basin):
    """Of that, what the start of a run sends, too: the counts and the places once."""
    return 4 * basin.width / 2 * (basin.depth + basin.air) / 2 + plane_particles(basin) * PLACE


def plane_particles(basin):
    return 2 * basin.width * basin.depth


def messages(basin, filters=0):
    """Through one cut in one direction and step, in the mean of both; two of them at the start of a run."""
    return 1 + EXCHANGES + filters + WATER_EXCHANGES + sum(planes for _, planes in basin.levels())


def share(parts, threads):
    """Of a loop, what the thread with the most parts does."""
    return math.ceil(parts / threads) / parts


def slabs(basin, ranks, costs, threads=1, node=Node()):
    """The time of a step, None where there are more ranks than planes. Nothing is taken to be hidden."""
    planes, rows = basin.planes(), math.ceil(basin.width / 2)
    if ranks > planes:
        return None
    own = math.ceil(planes / ranks)  # planes of the fullest rank
    particles = own / planes * basin.particles()
    sides = min(ranks - 1, 2)  # neighbours, whose messages share the way out
    rounds = math.log2(ranks)
    coarse, forks = coarse_grid(basin, ranks, costs, threads)
    # Memory is busy while all threads are.
    busy = particles * costs.particle * share(own * rows, threads)
    memory = particles * costs.traffic * node.ranks / node.memory
    look = (8 * planes / costs.bandwidth + rounds * costs.latency) / LOOK if ranks > 1 else 0
    way_out = min(costs.bandwidth, node.between) if node.ranks > 1 else costs.bandwidth
    return Step(max(busy, memory - coarse), particles * costs.by_planes * share(own, threads),
                particles * (costs.serial + (costs.migration if sides else 0)), coarse,
                forks + (LOOPS * costs.fork * threads if threads > 1 else 0),
                (messages(basin) * costs.latency) if sides else 0, sides * exchange_bytes(basin) / way_out,
                (REDUCTIONS + GATHERS) * rounds * costs.reduction + look)


def coarse_grid(basin, ranks, costs, threads):
    """Seconds of the sweeps of all levels, and of the starts and ends of their loops."""
    planes, rows, columns = basin.planes(), math.ceil(basin.width / 2), basin.columns()
    rows_of_a_part = max(4096 // (columns + 2), 1)
    work = forks = 0
    for level in range(basin.level_count()):
        gathered = level > 0 and planes * rows * columns <= GATHERED_CELLS
        own = planes if gathered else math.ceil(planes / ranks)
        parts = math.ceil(own * rows / rows_of_a_part)
        work += CYCLES * SWEEPS * own * rows * basin.depth / 2 * costs.cell * share(parts, threads)
        ahead = 3 if ranks > 1 and own > 1 and not gathered else 1  # both ends and what is between them
        used = min(threads, parts)
        forks += (2 + CYCLES * (3 + SWEEPS * ahead)) * costs.fork * used if used > 1 else 0
        planes, rows = math.ceil(planes / 2), math.ceil(rows / 2)
    return work, forks


def node_bytes(basin, ranks, node):
    """Memory of a node."""
    planes = math.ceil(basin.planes() / ranks)
    return node.ranks * (planes * PARTICLE_BYTES + 2 * GHOST_BYTES) * 2 * basin.width * basin.depth


def efficiency(basin, ranks, step, costs, threads=1):
    return slabs(basin, 1, costs).total() / (ranks * threads) / step.total()


def redundant_lambda(plane, lambda_cost, search_cost):
    """Seconds an iteration for lambda and neighbours of the two ghost planes of `plane` particles, which a wider ghost
    layer computes itself to save an exchange."""
    return 2 * plane * (lambda_cost + search_cost / (ITERATIONS - 1))

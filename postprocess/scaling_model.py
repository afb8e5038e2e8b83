"""The performance model of slabs, cuts inside them and threads: fitted to one core and a network, it tells a step's time.

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
VOLUMES, MOMENTS, FIT, FLOW = 3, 23, 13, 12  # numbers of a cell: volumes, moments, an affine fit, filtered flow
FIELDS = 8 * (VOLUMES + 2 * (MOMENTS + FIT) + FLOW + FIT)  # bytes of a cell of the projection beside the multigrid
FIELD_EXCHANGES = 1 + 4 + 2  # heights of the water; moments, fits, noise and its fits; shifts and theirs
# Records, projected move, lambda and place of each sweep over particles, water in flight, filtered shifts.
EXCHANGES = 1 + 1 + 2 * (ITERATIONS - 1) + 2
REDUCTIONS = 5  # depth of the water, whether it touches anything, guard, two migrations
GATHERS = 1 + CYCLES  # of the multigrid, as reductions: four fields of the equation, and a right-hand side in each cycle
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

    def rows(self):
        return math.ceil(self.width / 2)

    def columns(self):
        """Cells above one another that the coarse grid looks at."""
        return 4 * math.ceil((math.ceil(self.depth / 2) + 2) / 4)

    def level_count(self):
        widest = max(self.planes(), self.rows())
        return 1 + min(math.ceil(self.depth / 2).bit_length(), (widest - 1).bit_length())

    def levels(self):
        """Of levels of the multigrid that are not gathered, the finest first: whether there is a coarser one."""
        planes, rows, found = self.planes(), self.rows(), []
        for level in range(self.level_count()):
            if level > 0 and planes * rows * self.columns() <= GATHERED_CELLS:
                break
            found.append(level + 1 < self.level_count())
            planes, rows = math.ceil(planes / 2), math.ceil(rows / 2)
        return found


class Block(NamedTuple):
    """Cells that one rank has, those of a node, or of all ranks, and what is sent from there."""
    slab_sides: float  # on which there is another rank
    part_sides: float  # the same within slabs
    planes: int
    rows: int
    slabs: int = 1  # ranks side by side along these sides
    parts: int = 1
    cut: bool = False  # whether slabs are cut inside


class Zones(NamedTuple):
    """Rows of planes that are sent, or messages: to slabs beside, within slabs, across corners."""
    beside: float
    within: float
    across: float

    def upper(self):
        return self.beside / 2 + self.within / 2 + self.across / 4

    def of_rows(self):
        return self.within + self.across


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


# Of the rule for [domain] ranks = "auto", which the program has, too: a node of a cluster as scaling.md assumes it.
CHOICE = (Costs(particle=465e-9, cell=0.0, latency=2e-6, bandwidth=12e9, reduction=0.0), Node(ranks=64, between=8.1e9))


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


def traffic(basin, block, filters=0):
    """Bytes and messages of a step, as solver/halo_traffic.cpp has them. `filters`: exchanges of the velocity filters."""
    def zones(planes, rows):
        return Zones(block.slab_sides * rows, block.part_sides * planes, block.slab_sides * block.part_sides)

    across = block.slab_sides * block.part_sides
    pieces = Zones(block.slab_sides * block.parts, block.part_sides * block.slabs, across)
    # Where rows are not cut, planes are sent with the ring around them.
    ring, cells = 0 if block.cut else 2, basin.columns() + 2
    particles = basin.particles() / basin.planes() / basin.rows()  # of a row
    records = (ITERATIONS + 2) * PLACE + ITERATIONS * SCALAR + FILTERS[filters]
    size = sum(zones(block.planes, block.rows)) * (4 * (basin.depth + basin.air) / 2 + particles * records)
    rows = zones(block.planes, block.rows + ring)
    wet, high = math.ceil(basin.depth / 2), math.ceil((basin.depth + basin.air) / 2)
    held = basin.columns() if block.cut else min(wet + 1, high)  # of planes that are not cut what is in and beside water
    size += sum(zones(block.planes, block.rows)) * FIELDS * math.ceil(held / 4) * 4
    size += sum(rows) * 4 + rows.beside * 8 * cells
    size += rows.of_rows() * (72 * basin.columns() + 33 * cells)
    messages = sum(pieces) * (1 + EXCHANGES + filters + FIELD_EXCHANGES) + pieces.beside + 6 * pieces.of_rows()
    planes, rows = block.planes, block.rows
    for level, coarser in enumerate(basin.levels()):
        first = level == 0 and block.cut
        both = 1 + CYCLES * SWEEPS + (1 if first else 0)
        upper = (4 if level > 0 or first else 1) + (CYCLES if coarser else 0)  # known to one side: sinks, links, residuals
        sent = zones(planes, rows + ring)
        size += 8 * cells * (both * sum(sent) + upper * sent.upper())
        messages += both * sum(pieces) + upper * pieces.upper()
        planes, rows = math.ceil(planes / 2), math.ceil(rows / 2)
    return size, messages


def exchange_bytes(basin, filters=0):
    """Bytes through one cut between slabs in one direction and step, in the mean of both directions."""
    return traffic(basin, Block(1, 0, basin.planes(), basin.rows()), filters)[0]


def rebuild_bytes(basin):
    """Of that, what the start of a run sends, too: the counts and the places once."""
    return 4 * basin.width / 2 * (basin.depth + basin.air) / 2 + plane_particles(basin) * PLACE


def plane_particles(basin):
    return 2 * basin.width * basin.depth


def messages(basin, filters=0):
    """Through one cut in one direction and step, in the mean of both; two of them at the start of a run."""
    return traffic(basin, Block(1, 0, basin.planes(), basin.rows()), filters)[1]


def share(parts, threads):
    """Of a loop, what the thread with the most parts does."""
    return math.ceil(parts / threads) / parts


def blocks(basin, shape, node_ranks):
    """What the rank with the most cells has, and a node. Ranks of a slab follow one another, and so do those of a node."""
    (slabs_in_all, parts), cut = shape, shape[1] > 1
    planes, rows = math.ceil(basin.planes() / slabs_in_all), math.ceil(basin.rows() / parts)
    node_parts = min(parts, node_ranks)
    node_slabs = min(slabs_in_all, max(node_ranks // parts, 1))
    return (Block(sides(slabs_in_all), sides(parts), planes, rows, cut=cut),
            Block(sides(math.ceil(slabs_in_all / node_slabs)), sides(math.ceil(parts / node_parts)),
                  min(planes * node_slabs, basin.planes()), min(rows * node_parts, basin.rows()), node_slabs, node_parts,
                  cut))


def sides(pieces):
    return min(pieces - 1, 2)


def windows(basin, shape, costs, threads=1, node=Node()):
    """The time of a step with `shape` slabs and parts of each, None where there are more than planes and rows. Nothing
    is taken to be hidden."""
    planes, ranks = basin.planes(), math.prod(shape)
    if shape[0] > planes or shape[1] > basin.rows():
        return None
    block, of_node = blocks(basin, shape, node.ranks)
    particles = block.planes * block.rows / planes / basin.rows() * basin.particles()
    rounds = math.log2(ranks)
    coarse, forks = coarse_grid(basin, shape, costs, threads)
    # Memory is busy while all threads are.
    busy = particles * costs.particle * share(block.planes * block.rows, threads)
    memory = particles * costs.traffic * node.ranks / node.memory
    gathered = 8 * GATHERED_CELLS * (4 + CYCLES) / costs.bandwidth * rounds  # at most
    look = (8 * planes / costs.bandwidth + rounds * costs.latency) / LOOK if ranks > 1 else 0
    (sent, count), (out, _) = traffic(basin, block), traffic(basin, of_node)
    return Step(max(busy, memory - coarse), particles * costs.by_planes * share(block.planes, threads),
                particles * (costs.serial + (costs.migration if ranks > 1 else 0)), coarse,
                forks + (LOOPS * costs.fork * threads if threads > 1 else 0), count * costs.latency,
                max(sent / node.between, out / costs.bandwidth),
                (REDUCTIONS + GATHERS) * rounds * costs.reduction + gathered + look)


def slabs(basin, ranks, costs, threads=1, node=Node()):
    return windows(basin, (ranks, 1), costs, threads, node)


def shapes(basin, ranks):
    """All (slabs, parts) of so many ranks that fit."""
    parts = (n for n in range(1, min(ranks, basin.rows()) + 1) if ranks % n == 0)
    return [(ranks // n, n) for n in parts if ranks // n <= basin.planes()]


def best_shape(basin, ranks):
    """What [domain] ranks = "auto" takes (solver/ranks_by_model.cpp): particles, messages and their bytes alone."""
    costs, node = CHOICE
    def seconds(shape):
        step = windows(basin, shape, costs, node=node)
        return step.rows + step.latency + step.transfer
    return min(shapes(basin, ranks), key=seconds, default=(ranks, 1))


def coarse_grid(basin, shape, costs, threads):
    """Seconds of the sweeps of all levels, and of the starts and ends of their loops."""
    planes, rows, columns, ranks = basin.planes(), basin.rows(), basin.columns(), math.prod(shape)
    rows_of_a_part = max(4096 // (columns + 2), 1)
    work = forks = 0
    for level in range(basin.level_count()):
        gathered = level > 0 and planes * rows * columns <= GATHERED_CELLS
        own, own_rows = (planes, rows) if gathered else (math.ceil(planes / shape[0]), math.ceil(rows / shape[1]))
        parts = math.ceil(own * own_rows / rows_of_a_part)
        work += CYCLES * SWEEPS * own * own_rows * basin.depth / 2 * costs.cell * share(parts, threads)
        ahead = 3 if ranks > 1 and own > 1 and not gathered else 1  # both ends and what is between them
        used = min(threads, parts)
        forks += (2 + CYCLES * (3 + SWEEPS * ahead)) * costs.fork * used if used > 1 else 0
        planes, rows = math.ceil(planes / 2), math.ceil(rows / 2)
    return work, forks


def node_bytes(basin, shape, node):
    """Memory of a node."""
    block, _ = blocks(basin, shape, 1)
    beside = 0 if shape[1] == 1 else 2  # ghost rows
    ghosts = (block.planes + 2) * (block.rows + beside) - block.planes * block.rows
    particles = basin.particles() / basin.planes() / basin.rows()
    return node.ranks * particles * (block.planes * block.rows * PARTICLE_BYTES + ghosts * GHOST_BYTES)


def efficiency(basin, ranks, step, costs, threads=1):
    return slabs(basin, 1, costs).total() / (ranks * threads) / step.total()


def redundant_lambda(plane, lambda_cost, search_cost):
    """Seconds an iteration for lambda and neighbours of the two ghost planes of `plane` particles, which a wider ghost
    layer computes itself to save an exchange."""
    return 2 * plane * (lambda_cost + search_cost / (ITERATIONS - 1))

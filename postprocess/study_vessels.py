#!/usr/bin/python3
"""How water rests in vessels (turned box, sphere, cylinders, cone, torus) and over a hill, beside the plain box.

All start alike: a lattice that lies anyhow to the vessel, of what is half a spacing from its surface, each particle moved by a
tenth of the spacing at most; the plain box also with the lattice on its walls ("box, lattice"). From 2 s before the end on, in
the mean: kinetic energy per mass, and how far the centre of mass is from that of as much still water in the exact shape. One row
for each vessel, spacing, depth and seed; a seed is a place of the vessel, of the lattice and of the surface, as water rests the
worse the less of a cell of the coarse grid its top layers fill. The plain box, to which others are compared, has twice the seeds.
"""

import math
import tempfile
import tomllib
from pathlib import Path

import numpy as np

from study import GRAVITY, columns_of, launch, mean, parser_of, start_of, two_at_a_time, write_table

HALF = 0.6  # m, of the vessels, in each direction
DEPTHS = {"deep": 0.75, "shallow": 0.4}  # how full at the start, as a share of the vessel's height
SIDES = 96  # of the cone
FINE = 0.012  # m, between the points by which volumes are counted
STEP = 1 / 60  # s
SCENE = """
[domain]
min = {low}
max = {high}
[fluid]
spacing = {spacing}
[time]
dt = 0.016666666666666667
end = {seconds}
[gravity]
[[particles]]
min = {low}
max = {high}
{obstacle}
[output.series]
every = 0.016666666666666667
"""


def turned(rotation):
    """The matrix of degrees about x, then y, then z."""
    matrix = np.eye(3)
    for axis, angle in enumerate(np.radians(rotation)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        one = np.eye(3)
        one[u, u] = one[v, v] = np.cos(angle)
        one[v, u], one[u, v] = np.sin(angle), -np.sin(angle)
        matrix = one @ matrix
    return matrix


# How far points of the vessel's frame are from its surface, m, negative outside; rows of (x, y, z).
def in_box(p):
    return (HALF - np.abs(p)).min(axis=1)


def in_sphere(p):
    return HALF - np.linalg.norm(p, axis=1)


def in_cylinder(p):
    return np.minimum(HALF - np.hypot(p[:, 0], p[:, 1]), HALF - np.abs(p[:, 2]))


def in_torus(p):
    return HALF / 2 - np.hypot(np.hypot(p[:, 0], p[:, 1]) - HALF, p[:, 2])


def in_cone(p):
    """Its point at the bottom, its sides at 45 degrees, by their planes."""
    angle = np.arctan2(p[:, 1], p[:, 0])
    middle = (np.floor(angle * SIDES / (2 * np.pi)) + 0.5) * 2 * np.pi / SIDES
    flat = np.hypot(p[:, 0], p[:, 1]) * np.cos(angle - middle) / np.cos(np.pi / SIDES)
    return np.minimum((p[:, 2] + HALF - flat) / math.sqrt(2), HALF - p[:, 2])


def hill_height(x, y):
    return -HALF + HALF / 2 * (1 + np.cos(np.pi * x / HALF)) * (1 + np.cos(np.pi * y / HALF)) / 2


def over_hill(p):
    steepest = np.pi / 2  # so that it is a distance at least
    return np.minimum((p[:, 2] - hill_height(p[:, 0], p[:, 1])) / math.hypot(1, steepest), in_box(p))


def write_ply(path, points, faces):
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
                   f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines("{} {} {}\n".format(*point) for point in points)
        file.writelines(f"{len(face)} {' '.join(map(str, face))}\n" for face in faces)


def write_cone(path):
    angle = np.arange(SIDES) * 2 * np.pi / SIDES
    points = [(0, 0, -HALF), (0, 0, HALF), *zip(2 * HALF * np.cos(angle), 2 * HALF * np.sin(angle), np.full(SIDES, HALF))]
    faces = []
    for k in range(SIDES):
        n = (k + 1) % SIDES
        faces += [(0, 2 + n, 2 + k), (1, 2 + k, 2 + n)]
    write_ply(path, points, faces)


def write_hill(path, cells=24):
    """A block under the cosine hill, a cell wider than the box."""
    side = np.linspace(-HALF, HALF, cells + 1)
    points = [(x, y, hill_height(x, y)) for y in side for x in side] + [(x, y, -HALF - 0.2) for y in side for x in side]
    across, half, faces = cells + 1, (cells + 1) ** 2, []
    for j in range(cells):
        for i in range(cells):
            a = j * across + i
            for first, second, third in ((a, a + 1, a + across), (a + 1, a + across + 1, a + across)):
                faces += [(first, second, third), (half + first, half + third, half + second)]
    rim = ([(i, i + 1) for i in range(cells)] + [(j * across + cells, (j + 1) * across + cells) for j in range(cells)]
           + [(cells * across + i + 1, cells * across + i) for i in range(cells)]
           + [((j + 1) * across, j * across) for j in range(cells)])
    for a, b in rim:
        faces += [(a, half + b, b), (a, half + a, half + b)]
    write_ply(path, points, faces)


# The table of the scene without its place, how deep points are in it, and its rotation.
VESSELS = {
    "box, lattice": ("", in_box, (0, 0, 0)),
    "box": ("", in_box, (0, 0, 0)),
    "box, as obstacle": (f'type = "box"\nsize = [{2 * HALF}, {2 * HALF}, {2 * HALF}]', in_box, (0, 0, 0)),
    "box, turned by 30°": (f'type = "box"\nsize = [{2 * HALF}, {2 * HALF}, {2 * HALF}]', in_box, (0, 30, 0)),
    "box, turned twice": (f'type = "box"\nsize = [{2 * HALF}, {2 * HALF}, {2 * HALF}]', in_box, (35, 20, 10)),
    "sphere": (f'type = "sphere"\nradius = {HALF}', in_sphere, (0, 0, 0)),
    "cylinder, upright": (f'type = "cylinder"\nradius = {HALF}\nheight = {2 * HALF}', in_cylinder, (0, 0, 0)),
    "cylinder, lying": (f'type = "cylinder"\nradius = {HALF}\nheight = {2 * HALF}', in_cylinder, (90, 0, 25)),
    "cylinder, leaning": (f'type = "cylinder"\nradius = {HALF}\nheight = {2 * HALF}', in_cylinder, (30, 0, 0)),
    "cone, a mesh": ('type = "mesh"\npath = "cone.ply"', in_cone, (0, 0, 0)),
    "torus": (f'type = "torus"\nradius = {HALF}\ntube = {HALF / 2}', in_torus, (0, 0, 0)),
    "hill, a mesh": ('type = "mesh"\npath = "hill.ply"', over_hill, (0, 0, 0)),
}


def extent_of(inside, turn):
    """Lowest and highest points of the inside about its centre, and a cloud of points in it FINE apart."""
    half = round(1.26 / FINE)
    side = np.arange(-half, half) * FINE + FINE / 2
    points = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[inside(points @ turn) > 0]
    return points.min(axis=0) - FINE / 2, points.max(axis=0) + FINE / 2, points


def still_water(points, volume):
    """Centre of mass of that volume of water under a level surface, and its depth; points are those of extent_of()."""
    points = points[np.argsort(points[:, 2], kind="stable")]
    count = min(round(volume / FINE**3), len(points))
    return points[:count].mean(axis=0), points[count - 1, 2] - points[0, 2] + FINE


def cloud_in(inside, turn, bounds, case):
    """Positions to start with, about the vessel's centre."""
    random, spacing, (low, high) = np.random.default_rng(case["seed"]), case["spacing"], bounds
    counts = np.ceil((high - low) / spacing).astype(int) + 1
    lattice = np.stack(np.meshgrid(*[np.arange(n) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3)
    p = low + spacing * (lattice + 0.5)
    if case["vessel"] != "box, lattice":
        p += random.uniform(-0.1, 0.1, p.shape) * spacing - random.uniform(0, spacing, 3)
    p = p[inside(p @ turn) >= 0.4999 * spacing]
    layers = DEPTHS[case["depth"]] * (high[2] - low[2]) / spacing - (0 if case["seed"] == 0 else 2 * random.uniform())
    return p[p[:, 2] < low[2] + max(layers, 2) * spacing]


def scene_of(case, bounds, folder, seconds):
    """The scene as a text, and where in it the middle of the vessel is."""
    obstacle, _, rotation = VESSELS[case["vessel"]]
    walls = not obstacle or "hill" in obstacle  # those of the domain
    place = np.zeros(3) if walls else np.random.default_rng([case["seed"], 1]).uniform(0, case["spacing"], 3)
    margin = 0 if walls else 3 * case["spacing"]
    low, high = ([round(float(x), 9) for x in corner] for corner in (bounds[0] - margin, bounds[1] + margin))
    if obstacle:
        key = "translate" if "mesh" in obstacle else "center"
        obstacle = f"[[obstacle]]\n{obstacle}\n{key} = {place.tolist()}\nrotate = {list(rotation)}\n"
        obstacle += "" if walls else "inside = true\n"
    return SCENE.format(low=low, high=high, spacing=case["spacing"], seconds=seconds,
                        obstacle=obstacle.replace('path = "', f'path = "{folder}/')), place


def rest(case, folder, trevi, seconds):
    _, inside, rotation = VESSELS[case["vessel"]]
    turn = turned(rotation)
    *bounds, points = extent_of(inside, turn)
    name = f"{list(VESSELS).index(case['vessel'])}_{case['spacing']}_{case['depth']}_{case['seed']}"
    text, place = scene_of(case, bounds, folder, seconds)
    cloud = cloud_in(inside, turn, bounds, case) + place
    scene, output = folder / f"{name}.toml", folder / name
    scene.write_text(text, encoding="utf-8")
    (folder / f"{name}_start").mkdir()
    settings = start_of((cloud, np.zeros_like(cloud)), folder / f"{name}_start")
    code, message = launch(trevi, scene, output, settings, 7200)
    if code != 0:
        raise SystemExit(f"study_vessels.py: {case}: {message}")
    columns = columns_of(output / "series.csv")
    late = slice(-round(2 / STEP), None)
    floor = tomllib.loads(text)["domain"]["min"][2]
    mass = columns["potential_energy"][-1] / GRAVITY / (columns["com_z"][-1] - floor)
    exact, depth = still_water(points, len(cloud) * case["spacing"] ** 3)
    off = np.array([mean(columns[f"com_{axis}"][late]) for axis in "xyz"]) - place - exact
    return {**case, "particles": len(cloud), "depth_m": round(depth, 2),
            "kinetic_energy": f"{mean(columns['kinetic_energy'][late]) / mass:.2e}",
            "off_spacings": round(float(np.linalg.norm(off)) / case["spacing"], 3),
            "above_spacings": round(float(off[2]) / case["spacing"], 3),
            "compression_mean": f"{mean(columns['compression_mean'][late]):.1e}"}


def seeds_of(vessel, count):
    """The lattice on the walls is one case."""
    return [0] if vessel == "box, lattice" else range(1, (2 if vessel == "box" else 1) * count + 1)


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--seconds", type=float, default=12, help="that each rests for (default %(default)s)")
    parser.add_argument("--spacings", type=float, nargs="+", default=[0.1, 0.07], help="m (default %(default)s)")
    parser.add_argument("--seeds", type=int, nargs="+", default=[4, 1], help="how many, for each (default %(default)s)")
    parser.add_argument("--only", default="", help="vessels with this in their names")
    options = parser.parse_args()
    cases = [{"vessel": vessel, "spacing": spacing, "depth": depth, "seed": seed}
             for spacing, seeds in zip(options.spacings, options.seeds, strict=True)
             for depth in DEPTHS for vessel in VESSELS if options.only in vessel for seed in seeds_of(vessel, seeds)]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        write_cone(folder / "cone.ply")
        write_hill(folder / "hill.ply")
        for row in two_at_a_time(lambda case: rest(case, folder, options.trevi, options.seconds), cases):
            print(*row.values(), sep=", ", flush=True)
            rows.append(row)
    write_table(options.output, rows)


if __name__ == "__main__":
    main()

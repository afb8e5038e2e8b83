#!/usr/bin/python3
"""Writes the stone of inputs/trevi_fountain.toml: closed surfaces of triangles, binary PLY, in metres, z up.

  trevi_basin.ply    the rim of an oval basin, with three steps that lead up to it from outside
  trevi_statue.ply   what stands in its middle: a stepped base, two bowls on a column, a draped figure on top

Both are outlines that are turned about an axis: one of them closed in itself and turned to an oval, the other from the
axis to the axis, and round but for the figure. The origin of each is on the floor, in the middle of the basin.
"""

import argparse
import struct
import sys
from pathlib import Path

import numpy as np

# The inner wall of the basin: |x/A|^n + |y/B|^n = 1; its outline as (distance outwards, z).
HALF_AXES, ROUNDNESS = (4.7, 3.0), 2.6
RIM = [(0, -0.2), (0, 0.74), (-0.08, 0.78), (-0.08, 0.9), (-0.04, 0.94), (0.34, 0.94), (0.38, 0.9), (0.38, 0.78),
       (0.3, 0.74), (0.3, 0.6), (0.6, 0.6), (0.6, 0.4), (0.9, 0.4), (0.9, 0.2), (1.2, 0.2), (1.2, -0.2)]
# From the floor upwards, as (distance from the axis, z): base, column, bowl, column, bowl, plinth.
STEPS = [(0, -0.2), (1.7, -0.2), (1.7, 0.4), (1.66, 0.44), (1.3, 0.44), (1.3, 0.74), (1.26, 0.78), (0.9, 0.78),
         (0.86, 0.9), (0.5, 0.96), (0.4, 1.1), (0.34, 1.3), (0.36, 1.46), (0.5, 1.56)]
BOWL = [(0.9, 1.66), (1.3, 1.84), (1.62, 2.1), (1.76, 2.28), (1.76, 2.36), (1.7, 2.4), (1.62, 2.36), (1.5, 2.24),
        (1.2, 2.02), (0.85, 1.88), (0.5, 1.84)]
STEM = [(0.34, 1.9), (0.27, 2.1), (0.24, 2.5), (0.25, 2.8), (0.34, 2.92)]
SMALL_BOWL = [(0.6, 3.0), (0.85, 3.14), (1.0, 3.32), (1.02, 3.4), (0.98, 3.44), (0.92, 3.4), (0.8, 3.28),
              (0.6, 3.18), (0.4, 3.16)]
PLINTH = [(0.34, 3.2), (0.3, 3.3), (0.3, 3.52), (0.34, 3.56)]
# The figure: height above the plinth, half widths across and along the line of sight, how deep the folds of its robe are.
FIGURE = [(0.0, 0.34, 0.32, 0.07), (0.15, 0.33, 0.3, 0.09), (0.5, 0.29, 0.25, 0.09), (0.8, 0.27, 0.22, 0.07),
          (1.0, 0.22, 0.19, 0.05), (1.12, 0.2, 0.17, 0.03), (1.3, 0.25, 0.19, 0.02), (1.45, 0.29, 0.18, 0.02),
          (1.55, 0.28, 0.15, 0.01), (1.62, 0.2, 0.12, 0), (1.66, 0.1, 0.1, 0), (1.72, 0.08, 0.09, 0),
          (1.78, 0.12, 0.13, 0), (1.88, 0.14, 0.15, 0), (1.98, 0.12, 0.14, 0), (2.05, 0.07, 0.08, 0), (2.07, 0, 0, 0)]
FOLDS, TWIST = 9, 0.7  # of the robe; rad/m


def power(x, exponent):
    return np.sign(x) * np.abs(x) ** exponent


def basin(sides):
    angle = np.arange(sides) * 2 * np.pi / sides
    oval = np.stack([power(np.cos(angle), 2 / ROUNDNESS), power(np.sin(angle), 2 / ROUNDNESS)], axis=-1)
    outline = np.array(RIM)[::-1]
    across = np.array(HALF_AXES) + outline[:, :1]
    rings = np.empty((sides, len(outline), 3))
    rings[..., :2] = oval[:, None] * across
    rings[..., 2] = outline[:, 1]
    return rings


def finer(outline, longest):
    """The same outline with more points, none further apart than that."""
    points = [outline[0]]
    for begin, end in zip(outline[:-1], outline[1:]):
        count = max(1, int(np.ceil(np.linalg.norm(np.subtract(end, begin)[:2]) / longest)))
        points += [begin + (end - begin) * k / count for k in range(1, count + 1)]
    return np.array(points)


def statue(sides):
    angle = np.arange(sides) * 2 * np.pi / sides
    round_part = np.array(STEPS + BOWL + STEM + SMALL_BOWL + PLINTH)
    top = round_part[-1, 1]
    rings = [np.stack([r * np.cos(angle), r * np.sin(angle), np.full(sides, z)], axis=-1) for r, z in round_part]
    for height, across, along, depth in finer(np.array(FIGURE), 0.09)[1:]:
        fold = 1 + depth / max(along, 0.1) * 0.5 * np.cos(FOLDS * (angle + TWIST * height) + np.sin(3 * angle))
        lean = 0.06 * np.sin(2.2 * height)  # she rests on one leg
        rings.append(np.stack([lean + across * fold * np.cos(angle), along * fold * np.sin(angle),
                               np.full(sides, top + height)], axis=-1))
    return np.array(rings).transpose(1, 0, 2)


def triangles_between(sides, points, closed):
    """Of rings[side][point], the outside on the right of each outline as it goes."""
    corners = []
    for side in range(sides):
        here, there = side * points, (side + 1) % sides * points
        for k in range(points if closed else points - 1):
            following = (k + 1) % points
            corners += [(here + k, there + k, here + following), (there + k, there + following, here + following)]
    return np.array(corners)


def mesh_of(rings, closed):
    """Points and triangles; those of the axis are one point, and what has no area is left out."""
    points, number = np.unique(rings.reshape(-1, 3).astype("<f4"), axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles_between(*rings.shape[:2], closed)]
    distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return points, triangles[distinct]


def write_ply(path, points, triangles, colours=None):
    """`colours`: of the points, uint8 (n, 3), for pictures."""
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz")
    if colours is not None:
        head += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    head += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    with open(path, "wb") as file:
        file.write(head.encode())
        rows = points.astype("<f4").view(np.uint8).reshape(len(points), 12)
        file.write((rows if colours is None else np.hstack([rows, colours])).tobytes())
        for triangle in triangles:
            file.write(struct.pack("<B3i", 3, *triangle))
    print(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default=Path(__file__).parent.parent / "inputs", type=Path)
    folder = parser.parse_args().folder
    write_ply(folder / "trevi_basin.ply", *mesh_of(basin(96), closed=True))
    write_ply(folder / "trevi_statue.ply", *mesh_of(statue(54), closed=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""Writes the stone of inputs/gallery: closed surfaces of triangles, binary PLY, in metres, z up.

  bowl.ply    a round bowl that stands in the air, with a hole in the middle of its floor
  spout.ply   a pipe that comes out of the wall x = 0 and bends downwards
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from make_basin import mesh_of, write_ply

# As (distance from the axis, z), up along the inside and down along the outside.
BOWL = [(0.26, 1.0), (0.22, 1.04), (0.22, 1.16), (0.26, 1.2), (1.2, 1.2), (1.3, 1.3), (1.3, 2.2), (1.34, 2.24), (1.46, 2.24),
        (1.5, 2.2), (1.5, 1.25), (1.25, 1.0)]
BORE, WALL = 0.24, 0.08  # m, of the spout
HEIGHT, STRAIGHT, BEND, TURN = 1.75, 0.8, 0.55, np.radians(65)  # m, m, m: radius of the bend; how far it turns


def bowl(sides):
    angle = np.arange(sides) * 2 * np.pi / sides
    return np.array([[(r * np.cos(a), r * np.sin(a), z) for r, z in BOWL] for a in angle])


def spout(sides):
    """Rings around a path of stations: along the outside to the mouth, and back within."""
    turn = np.concatenate([[0, 0], np.linspace(0, TURN, 16)[1:]])
    middle = np.stack([STRAIGHT + BEND * np.sin(turn), np.zeros_like(turn), HEIGHT - BEND * (1 - np.cos(turn))], axis=-1)
    middle[0, 0] = -0.4
    upwards = np.stack([np.sin(turn), np.zeros_like(turn), np.cos(turn)], axis=-1)
    angle = np.arange(sides) * 2 * np.pi / sides

    def rings(radius):
        return (middle + radius * (np.cos(angle)[:, None, None] * upwards
                                   + np.sin(angle)[:, None, None] * np.array([0, 1, 0])))
    return np.concatenate([rings(BORE + WALL), rings(BORE)[:, ::-1]], axis=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default=Path(__file__).parent.parent / "inputs/gallery", type=Path)
    folder = parser.parse_args().folder
    write_ply(folder / "bowl.ply", *mesh_of(bowl(96), closed=True))
    write_ply(folder / "spout.ply", *mesh_of(spout(48), closed=True))
    return 0


if __name__ == "__main__":
    sys.exit(main())

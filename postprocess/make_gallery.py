#!/usr/bin/python3
"""Writes the solids of inputs/gallery: closed surfaces of triangles, binary PLY, in metres, z up.

  bowl.ply    a round bowl that stands in the air, with a hole in the middle of its floor
  spout.ply   a pipe that comes out of the wall x = 0 and bends downwards
  duck.ply    a bath duck that looks along x, in its colours; needs VTK
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

# Ellipsoids of the duck: centre and half axes. The first four run into each other softly, as BLEND (m) says.
DUCK = {"body": ((0, 0, 0), (0.36, 0.27, 0.17)), "tail": ((-0.30, 0, 0.10), (0.16, 0.12, 0.09)),
        "neck": ((0.20, 0, 0.14), (0.13, 0.13, 0.14)), "head": ((0.23, 0, 0.30), (0.145, 0.135, 0.135)),
        "bill": ((0.38, 0, 0.275), (0.09, 0.075, 0.03)), "left eye": ((0.31, 0.095, 0.345), (0.03, 0.03, 0.03)),
        "right eye": ((0.31, -0.095, 0.345), (0.03, 0.03, 0.03))}
BLEND, BLEND_OF_BILL = 0.05, 0.012
COLOURS = {"bill": (230, 95, 20), "left eye": (15, 15, 20), "right eye": (15, 15, 20)}
FEATHERS = (250, 195, 30)
GRID, TRIANGLES = 0.0125, 3000  # m; about how many


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


def distance_to(points, center, half_axes):
    """To an ellipsoid, m, as good as it is close; below zero within."""
    place = (points - center) / half_axes
    length = np.linalg.norm(place, axis=-1)
    return length * (length - 1) / np.maximum(np.linalg.norm(place / half_axes, axis=-1), 1e-9)


def joined(distances, blend):
    return -blend * np.log(sum(np.exp(-distance / blend) for distance in distances))


def duck_distance(places):
    """About the distance from its surface, m; below 0 inside."""
    parts = [distance_to(places, *part) for part in DUCK.values()]
    return joined([joined(parts[:4], BLEND), *parts[4:]], BLEND_OF_BILL)


def duck():
    """Points, triangles, and the colour of each point."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy  # only the duck needs VTK
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkQuadricDecimation

    low, size = np.array([-0.55, -0.35, -0.25]), np.array([83, 57, 57])
    places = low + GRID * np.stack(np.meshgrid(*map(np.arange, size[::-1]), indexing="ij")[::-1], axis=-1)
    distance = duck_distance(places)
    grid, contour, fewer = vtkImageData(), vtkFlyingEdges3D(), vtkQuadricDecimation()
    grid.SetOrigin(*low)
    grid.SetSpacing(GRID, GRID, GRID)
    grid.SetDimensions(*map(int, size))
    grid.GetPointData().SetScalars(numpy_to_vtk(distance.reshape(-1), deep=1))
    contour.SetInputData(grid)
    contour.SetValue(0, 0)
    contour.ComputeNormalsOff()
    contour.ComputeScalarsOff()
    contour.Update()
    fewer.SetInputConnection(contour.GetOutputPort())
    fewer.SetTargetReduction(1 - TRIANGLES / contour.GetOutput().GetNumberOfPolys())
    fewer.Update()
    mesh = fewer.GetOutput()
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype("<f4")
    triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)[:, ::-1]  # to look outwards
    return points, triangles, duck_colours(points)


def duck_colours(points):
    colours = np.tile(np.array(FEATHERS, np.uint8), (len(points), 1))
    for name, colour in COLOURS.items():
        colours[distance_to(points, *DUCK[name]) < 0.4 * GRID] = colour
    return colours


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default=Path(__file__).parent.parent / "inputs/gallery", type=Path)
    folder = parser.parse_args().folder
    write_ply(folder / "bowl.ply", *mesh_of(bowl(96), closed=True))
    write_ply(folder / "spout.ply", *mesh_of(spout(48), closed=True))
    write_ply(folder / "duck.ply", *duck())
    return 0


if __name__ == "__main__":
    sys.exit(main())

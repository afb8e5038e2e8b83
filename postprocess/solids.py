"""Obstacles and bodies in the picture of surface.py: lit stone, or in colours of their own, seen directly and through
the water. No program of its own.

The stone is drawn once, as seen from the camera. A ray that the water bends is followed in that picture: it meets the
stone where it goes behind what the picture shows there, so what no straight ray sees is not seen through water either.
"""

from collections import namedtuple

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy

from light import dot
from water import ABSORPTION

STEPS = 24  # places at which a bent ray is compared with the picture
THICK = 0.4  # m; a ray that is further behind a stone has passed it


def points_on(surface, box, apart=0.02):
    """Points in the box on the surfaces of obstacles, one for each square of that edge (m), for their shadows."""
    if surface is None or not surface.GetNumberOfPoints():
        return np.zeros((0, 3))
    corners = vtk_to_numpy(surface.GetPoints().GetData())[vtk_to_numpy(surface.GetPolys().GetData()).reshape(-1, 4)[:, 1:]]
    first, along, across = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    counts = np.ceil(np.linalg.norm(np.cross(along, across), axis=1) / 2 / apart**2).astype(int).clip(1, 20000)
    share = np.random.default_rng(1).random((counts.sum(), 2))
    share = np.where(share.sum(axis=1, keepdims=True) > 1, 1 - share, share)
    point = np.repeat(first, counts, axis=0) + share[:, :1] * np.repeat(along, counts, axis=0) + share[:, 1:] * np.repeat(
        across, counts, axis=0)
    return point[((point >= box[0]) & (point <= box[1])).all(axis=1)]


# Of each pixel, rows of the picture one after the other: normal, distance along the viewing axis (infinite where there
# is nothing solid), own colour (linear, black without one).
Seen = namedtuple("Seen", "normal distance colour")


class Solids:
    """`seen`: as the camera sees them; `project` takes points to (column, row, distance); `light` as of light.py."""

    def __init__(self, seen, size, project, light):
        self.distance, self.size, self.project = seen.distance, size, project
        normal = seen.normal
        lamp = (light.lamp / np.linalg.norm(light.lamp)).astype(np.float32)
        bright = 0.75 * light.lamplight * np.clip(dot(normal, lamp), 0, 1) + 0.12 * np.clip(normal[:, 2:], 0, 1)
        own = np.where(seen.colour.any(axis=1, keepdims=True), seen.colour, light.stone)
        self.colour = own * (0.06 + light.ambient + bright)

    def seen_through(self, point, direction, length):
        """What rays within the water meet: whether they do, colour, and how far they have come (m)."""
        met = np.zeros(len(point), bool)
        colour, way = np.zeros_like(point), np.zeros((len(point), 1), np.float32)
        for step in (np.arange(STEPS) + 1) / STEPS:
            column, row, distance = self.project(point + step * length * direction)
            column, row = (np.floor(c).astype(int) for c in (column, row))
            inside = (column >= 0) & (column < self.size[0]) & (row >= 0) & (row < self.size[1]) & ~met
            pixel = np.where(inside, row * self.size[0] + column, 0)
            behind = distance - self.distance[pixel]
            now = inside & (behind > 0) & (behind < THICK)
            colour[now], way[now] = self.colour[pixel[now]], step * length[now]
            met |= now
        return met, colour * np.exp(-ABSORPTION * way), way


def lit(result, solids, front):
    """The stone where it is nearer than `front`, the distance of the water (infinite without), else what is there."""
    nearer = np.isfinite(solids.distance) & (solids.distance < front)
    result[nearer] = solids.colour[nearer]
    return nearer

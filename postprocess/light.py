"""Light and ground of surface.py's pictures: a night with lamps, and a day. No program of its own.

Works on arrays of rays (rows of 3 components, float32, m); colours are linear, 1 is white.
"""

from collections import namedtuple

import numpy as np
from scipy.ndimage import gaussian_filter

# sky: zenith, horizon, glow towards the key lamp; lamps: factors on `lamp`'s axes, strength, cosines between which they
# fade; lamp: where the key light comes from; pool, paving: stone below water, and dry; ambient: light without the lamp;
# spread: how far the lamp lights the ground, in sizes of the box; stone: obstacles.
Light = namedtuple("Light", "zenith horizon glow lamps lamp lamplight pool paving joint ambient spread stone")


def colour(*values):
    return np.array(values, np.float32)


LIGHTS = {
    "night": Light(
        zenith=colour(0.012, 0.03, 0.10), horizon=colour(0.006, 0.013, 0.035), glow=colour(0.015, 0.03, 0.06),
        lamps=(((1, 1, 1), 6.0, (0.955, 0.995)), ((-1, 0.4, 1.2), 3.0, (0.955, 0.995))),
        lamp=colour(-0.52, 0.62, 0.59), lamplight=colour(1.0, 0.93, 0.82), pool=colour(0.30, 0.46, 0.52),
        paving=colour(0.15, 0.15, 0.17), joint=0.45, ambient=0.04, spread=0.6, stone=colour(0.46, 0.41, 0.35)),
    "day": Light(
        zenith=colour(0.02, 0.10, 0.40), horizon=colour(0.28, 0.47, 0.74), glow=colour(0.10, 0.07, 0.04),
        lamps=(((1, 1, 1), 6.0, (0.985, 0.997)), ((1.1, -1.45, 0.86), 9.0, (0.9965, 0.999))),
        lamp=colour(-0.45, -0.55, 0.70), lamplight=colour(1.0, 0.96, 0.88), pool=colour(0.34, 0.47, 0.50),
        paving=colour(0.24, 0.22, 0.195), joint=0.18, ambient=0.20, spread=4.0, stone=colour(0.58, 0.51, 0.43)),
}
TILE = 0.6  # m
SHADES = 400  # cells of the map of shadows along its longer side
SHADE = (0.22, 0.75)  # what water in the air and stone take of the lamp's light


def normalised(v):
    return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)


def dot(a, b):
    return np.sum(a * b, axis=1, keepdims=True)


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


class Shadows:
    """What of the lamp's light the ground misses: points of water and stone, carried to z = 0 along the light."""

    def __init__(self, low, high, lamp, points):
        reach = high[2] * np.abs(lamp[:2] / lamp[2])
        self.low, size = low[:2] - reach - 0.5, high[:2] - low[:2] + 2 * reach + 1
        self.cell = size.max() / SHADES
        self.shape = np.ceil(size / self.cell).astype(int)
        self.taken = sum(share * self.cover(place - place[:, 2:] * (lamp / lamp[2]))
                         for share, place in zip(SHADE, points)).clip(0, 0.8)

    def cover(self, place):
        cells = ((place[:, :2] - self.low) / self.cell).astype(int)
        cells = cells[((cells >= 0) & (cells < self.shape)).all(axis=1)]
        counts = np.bincount(cells @ [self.shape[1], 1], minlength=self.shape.prod()).reshape(self.shape)
        return 1 - np.exp(-gaussian_filter(counts.astype(np.float32), 1.5))

    def at(self, xy):
        cells = ((xy - self.low) / self.cell).astype(int)
        within = ((cells >= 0) & (cells < self.shape)).all(axis=1)
        cells = np.where(within[:, None], cells, 0)
        return np.where(within, self.taken[cells[:, 0], cells[:, 1]], 0)[:, None]


class Surroundings:
    """The sky, and paving stones in the plane z = 0, lit around the middle of the box and lost in the haze far from it.
    `points`: water that may throw a shadow on the ground, and stone; (n, 3) each."""

    def __init__(self, low, high, light, points):
        self.light = light
        self.shadows = Shadows(low, high, light.lamp, points)
        self.low, self.high = low[:2].astype(np.float32), high[:2].astype(np.float32)
        self.middle, self.size = (self.low + self.high) / 2, np.linalg.norm(self.high - self.low)

    def sky(self, direction):
        light, up = self.light, np.clip(direction[:, 2:], 0, 1)
        result = light.horizon + (light.zenith - light.horizon) * up**0.5
        flat = light.lamp * [1, 1, 0] / np.linalg.norm(light.lamp[:2])
        toward = np.clip(dot(direction, flat.astype(np.float32)), 0, 1)
        result = result + light.glow * toward**4 * np.exp(-9 * up)
        for axes, strength, ends in light.lamps:
            lamp = light.lamp * axes
            lamp = (lamp / np.linalg.norm(lamp)).astype(np.float32)
            result = result + strength * light.lamplight * smoothstep(*ends, dot(direction, lamp))
        return result

    def ground(self, point, deep=0):
        """Its colour; deep, 0 to 1: how far it is that of a pool, in the box."""
        light, xy = self.light, point[:, :2]
        cell = np.floor(xy / TILE)
        noise = np.abs(np.sin(cell[:, :1] * 12.9898 + cell[:, 1:] * 78.233) * 43758.5453) % 1
        edge = np.abs(xy / TILE - cell - 0.5).max(axis=1, keepdims=True)
        inside = np.all((xy > self.low) & (xy < self.high), axis=1, keepdims=True)
        stone = light.paving + (light.pool - light.paving) * inside * deep
        stone = stone * (0.82 + 0.28 * noise) * (1 - light.joint * smoothstep(0.47, 0.485, edge))
        distance = np.linalg.norm(xy - self.middle, axis=1, keepdims=True)
        lamp = 0.65 * light.lamplight * np.exp(-((distance / (light.spread * self.size)) ** 2))
        return stone * (light.ambient + lamp * (1 - self.shadows.at(xy)))

    def seen(self, origin, direction, deep=0):
        """What a ray meets that misses the water; the ground, as ground() has it, fades into the horizon."""
        downward = direction[:, 2] < -1e-3
        result = self.sky(direction)
        way = -origin[downward, 2:] / direction[downward, 2:]
        point = origin[downward] + way * direction[downward]
        fade = np.exp(-way / (6 * self.size))
        level = direction[downward] * np.array([1, 1, 0], np.float32)
        result[downward] = self.ground(point, deep) * fade + self.sky(normalised(level)) * (1 - fade)
        return result

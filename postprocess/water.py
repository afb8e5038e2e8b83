"""Light on water, for surface.py: sky, paved ground, refraction, reflection, absorption. No program of its own.

Works on arrays of rays (rows of 3 components, float32, m; colours are linear, 1 is white). The water is a mesh of which
each ray knows the nearest point, its normal and the way to the nearest back side; ground and sky are formulas.
"""

import numpy as np

REFRACTION = 1.33
REFLECTANCE = 0.02  # of water at normal incidence
ABSORPTION = np.array([1.3, 0.30, 0.12], np.float32)  # 1/m; exaggerated, as 1 m of real water has no colour
ZENITH, HORIZON, GLOW = (
    np.array(c, np.float32) for c in ((0.012, 0.03, 0.10), (0.006, 0.013, 0.035), (0.015, 0.03, 0.06)))
LAMP = np.array([-0.52, 0.62, 0.59], np.float32)  # where the key light comes from
LAMPLIGHT = np.array([1.0, 0.93, 0.82], np.float32)
TILE = 0.6  # m


def normalised(v):
    return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-9)


def dot(a, b):
    return np.sum(a * b, axis=1, keepdims=True)


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def sky(direction):
    """Night: a dark zenith, a glow on the horizon, and two soft lamps that glitter in the water."""
    up = np.clip(direction[:, 2:], 0, 1)
    colour = HORIZON + (ZENITH - HORIZON) * up**0.5
    flat = LAMP * [1, 1, 0] / np.linalg.norm(LAMP[:2])
    toward = np.clip(dot(direction, flat.astype(np.float32)), 0, 1)
    colour = colour + GLOW * toward**4 * np.exp(-9 * up)
    for lamp, strength in ((LAMP, 6.0), (LAMP * [-1, 0.4, 1.2], 3.0)):
        lamp = (lamp / np.linalg.norm(lamp)).astype(np.float32)
        colour = colour + strength * LAMPLIGHT * smoothstep(0.955, 0.995, dot(direction, lamp))
    return colour


class Ground:
    """Paving stones in the plane z = 0, lit around the middle of the fountain and lost in the dark far from it."""

    def __init__(self, low, high):
        self.low, self.high = low[:2].astype(np.float32), high[:2].astype(np.float32)
        self.middle, self.size = (self.low + self.high) / 2, np.linalg.norm(self.high - self.low)

    def colour(self, point):
        xy = point[:, :2]
        cell = np.floor(xy / TILE)
        noise = np.abs(np.sin(cell[:, :1] * 12.9898 + cell[:, 1:] * 78.233) * 43758.5453) % 1
        edge = np.abs(xy / TILE - cell - 0.5).max(axis=1, keepdims=True)
        inside = np.all((xy > self.low) & (xy < self.high), axis=1, keepdims=True)
        stone = np.where(inside, np.array([0.30, 0.46, 0.52], np.float32), np.array([0.15, 0.15, 0.17], np.float32))
        stone = stone * (0.82 + 0.28 * noise) * (1 - 0.45 * smoothstep(0.47, 0.485, edge))
        distance = np.linalg.norm(xy - self.middle, axis=1, keepdims=True)
        return stone * (0.04 + 0.65 * LAMPLIGHT * np.exp(-((distance / (0.6 * self.size)) ** 2)))

    def seen(self, origin, direction):
        """What a ray meets that misses the water; the ground fades into the horizon."""
        downward = direction[:, 2] < -1e-3
        result = sky(direction)
        way = -origin[downward, 2:] / direction[downward, 2:]
        point = origin[downward] + way * direction[downward]
        fade = np.exp(-way / (6 * self.size))
        level = direction[downward] * np.array([1, 1, 0], np.float32)
        result[downward] = self.colour(point) * fade + sky(normalised(level)) * (1 - fade)
        return result


def refracted(direction, normal):
    eta, cosine = 1 / REFRACTION, -dot(direction, normal)
    return eta * direction + (eta * cosine - np.sqrt(1 - eta**2 * (1 - cosine**2))) * normal


def water(ground, hit, tint, foam, solids=None):
    """Colour of rays that meet the water. hit: point, normal, direction and depth (m to the nearest back side) of each;
    tint: the water's own colour; foam in [0, 1]: how much light it scatters rather than lets through; solids: what else
    rays in the water may meet (solids.py)."""
    inward = refracted(hit.direction, hit.normal)
    height, falling = np.maximum(hit.point[:, 2:], 0), -inward[:, 2:]
    to_floor = np.where(falling > 1e-3, height / np.maximum(falling, 1e-3), np.inf)
    on_floor = (to_floor < 1.1 * hit.depth + 0.1)
    way = np.where(on_floor, to_floor, hit.depth)
    out = hit.point + way * inward
    # A drop bends the ray a second time as much as the first.
    beyond = ground.seen(out, normalised(2 * inward - hit.direction))
    behind = np.where(on_floor, ground.colour(out), beyond) * np.exp(-ABSORPTION * way)
    if solids:
        met, stone, length = solids.seen_through(hit.point, inward, way)
        behind, way = np.where(met[:, None], stone, behind), np.where(met[:, None], length, way)
    light = 0.45 + 0.55 * np.clip(dot(hit.normal, LAMP), 0, 1) + 0.15 * hit.normal[:, 2:]
    scattered = 1 - np.exp(-foam * np.minimum(np.minimum(hit.depth, way), 0.6) / 0.12)
    behind = behind * (1 - scattered) + tint * light * scattered
    cosine = np.clip(-dot(hit.direction, hit.normal), 0, 1)
    fresnel = REFLECTANCE + (1 - REFLECTANCE) * (1 - cosine) ** 5
    mirrored = hit.direction + 2 * cosine * hit.normal
    return behind * (1 - fresnel) + ground.seen(hit.point, mirrored) * fresnel


def developed(linear):
    """uint8 from linear colour: a film curve that keeps highlights (Narkowicz 2015), then the display's gamma."""
    x = linear * 0.9
    x = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)
    return (255 * x ** (1 / 2.2) + 0.5).astype(np.uint8)

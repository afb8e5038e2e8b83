"""Light on water, for surface.py: refraction, reflection, absorption. No program of its own.

Works on arrays of rays (rows of 3 components, float32, m; colours are linear, 1 is white). The water is a mesh of which
each ray knows the nearest point, its normal and the way to the nearest back side; ground and sky are formulas (light.py).
"""

import numpy as np

from light import dot, normalised

REFRACTION = 1.33
SHALLOW = 0.08  # m; less water than that shows the stone as it is
REFLECTANCE = 0.02  # of water at normal incidence
ABSORPTION = np.array([1.3, 0.30, 0.12], np.float32)  # 1/m; exaggerated, as 1 m of real water has no colour


def refracted(direction, normal):
    eta, cosine = 1 / REFRACTION, -dot(direction, normal)
    return eta * direction + (eta * cosine - np.sqrt(1 - eta**2 * (1 - cosine**2))) * normal


def water(around, hit, tint, foam, solids=None):
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
    beyond = around.seen(out, normalised(2 * inward - hit.direction), deep=1)
    behind = np.where(on_floor, around.ground(out, 1 - np.exp(-height / SHALLOW)), beyond) * np.exp(-ABSORPTION * way)
    if solids:
        met, stone, length = solids.seen_through(hit.point, inward, way)
        behind, way = np.where(met[:, None], stone, behind), np.where(met[:, None], length, way)
    light = 0.45 + 0.55 * np.clip(dot(hit.normal, around.light.lamp), 0, 1) + 0.15 * hit.normal[:, 2:]
    scattered = 1 - np.exp(-foam * np.minimum(np.minimum(hit.depth, way), 0.6) / 0.12)
    behind = behind * (1 - scattered) + tint * light * scattered
    cosine = np.clip(-dot(hit.direction, hit.normal), 0, 1)
    fresnel = REFLECTANCE + (1 - REFLECTANCE) * (1 - cosine) ** 5
    mirrored = hit.direction + 2 * cosine * hit.normal
    return behind * (1 - fresnel) + around.seen(hit.point, mirrored) * fresnel


def developed(linear):
    """uint8 from linear colour: a film curve that keeps highlights (Narkowicz 2015), then the display's gamma."""
    x = linear * 0.9
    x = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)
    return (255 * x ** (1 / 2.2) + 0.5).astype(np.uint8)

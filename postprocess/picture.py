#!/usr/bin/python3
"""Draws the particles of a checkpoint as shaded balls, without ParaView or a display.

  postprocess/picture.py out/fountain/checkpoint_000360.h5 --output fountain.png
"""
import argparse
import colorsys
import sys

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import image as mpimage  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkpoint", help="checkpoint_<step>.h5 of a run")
    parser.add_argument("--output", default="picture.png", help="PNG to write (default %(default)s)")
    parser.add_argument("--colour", choices=["auto", "hue", "speed", "height", "blue"], default="auto",
                        help="auto: the rainbow where the run has one, else speed")
    parser.add_argument("--azimuth", type=float, default=30, help="degrees around the vertical (default %(default)s)")
    parser.add_argument("--elevation", type=float, default=18, help="degrees above the horizon (default %(default)s)")
    parser.add_argument("--size", type=int, nargs=2, default=[1280, 720], metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--radius", type=float, default=0.06, help="of a ball, m (default %(default)s)")
    return parser.parse_args()


def read(path):
    """Positions (m), velocities (m/s) and hue (None when the run has no rainbow)."""
    try:
        with h5py.File(path) as file:
            group = file["particles"]
            return group["position"][:], group["velocity"][:], group["hue"][:] if "hue" in group else None
    except (OSError, KeyError) as error:
        sys.exit(f"{path}: not a checkpoint ({error})")


def rainbow(share):
    table = np.array([colorsys.hsv_to_rgb(0.8 * k / 255, 0.85, 1.0) for k in range(256)])
    return table[np.clip(share * 255, 0, 255).astype(int)]


def colours(kind, position, velocity, hue):
    if kind == "auto":
        kind = "speed" if hue is None else "hue"
    if kind == "hue":
        if hue is None:
            sys.exit("this run has no rainbow; use --colour speed")
        return rainbow(hue)
    if kind == "height":
        return rainbow(position[:, 2] / max(position[:, 2].max(), 1e-9))
    if kind == "speed":
        speed = np.linalg.norm(velocity, axis=1)[:, None]
        share = np.clip(speed / max(np.quantile(speed, 0.999), 1e-9), 0, 1)
        return (1 - share) * np.array([0.10, 0.35, 0.85]) + share * np.array([0.95, 0.98, 1.0])
    return np.tile([0.15, 0.45, 0.9], (len(position), 1))


def project(position, azimuth, elevation):
    """Camera axes: right, up, and away from the viewer, all in metres."""
    a, e = np.radians([azimuth, elevation])
    right = np.array([-np.sin(a), np.cos(a), 0])
    back = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
    return np.stack([position @ right, position @ np.cross(back, right), -(position @ back)], axis=1)


def draw(camera, rgb, radius, size):
    """Depth-buffered balls, one pixel offset of all balls at a time; nearest last, so that it stays."""
    width, height = size
    low, high = camera[:, :2].min(axis=0) - radius, camera[:, :2].max(axis=0) + radius
    scale = 0.94 * min(width / (high[0] - low[0]), height / (high[1] - low[1]))
    centre = np.round((camera[:, :2] - (low + high) / 2) * scale * [1, -1] + [width / 2, height / 2]).astype(int)
    order = np.argsort(-camera[:, 2])
    centre, depth, rgb = centre[order], camera[order, 2], rgb[order]
    picture, buffer = np.ones((height * width, 3)), np.full(height * width, np.inf)
    pixels = max(int(np.ceil(radius * scale)), 1)
    for dy in range(-pixels, pixels + 1):
        for dx in range(-pixels, pixels + 1):
            inside = 1 - (dx * dx + dy * dy) / (radius * scale) ** 2
            if inside <= 0 and (dx or dy):
                continue
            front = np.sqrt(max(inside, 0))
            light = 0.35 + 0.65 * max(0, 0.55 * front - 0.55 * dy / pixels - 0.35 * dx / pixels)
            x, y = centre[:, 0] + dx, centre[:, 1] + dy
            seen = (x >= 0) & (x < width) & (y >= 0) & (y < height)
            at, z = (y * width + x)[seen], depth[seen] - front * radius
            nearest, owner = np.full(height * width, np.inf), np.zeros(height * width, int)
            nearest[at], owner[at] = z, np.flatnonzero(seen)
            better = nearest < buffer
            buffer[better] = nearest[better]
            picture[better] = np.clip(rgb[owner[better]] * light, 0, 1)
    return picture.reshape(height, width, 3)


def main():
    options = arguments()
    position, velocity, hue = read(options.checkpoint)
    rgb = colours(options.colour, position, velocity, hue)
    camera = project(position, options.azimuth, options.elevation)
    mpimage.imsave(options.output, draw(camera, rgb, options.radius, options.size))
    print(options.output)


if __name__ == "__main__":
    main()

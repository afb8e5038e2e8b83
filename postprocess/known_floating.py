"""Small motions of a body that floats in a tank, by linear theory: water without viscosity (Maskell & Ursell, J. Fluid Mech.
44, 1970), here by boundary elements on the walls of the tank itself, half of it by symmetry. No program of its own;
study_bodies.py runs it.
"""

import math

import numpy as np

from study import GRAVITY


def panels_between(corners, lengths):
    """Panels along straight lines through corners, each of about that length: ends as rows x, z, x, z."""
    rows = []
    for (a, b), length in zip(zip(corners, corners[1:]), lengths):
        n = max(1, round(math.dist(a, b) / length))
        points = np.array(a) + np.linspace(0, 1, n + 1)[:, None] * (np.array(b) - np.array(a))
        rows += [[*p, *q] for p, q in zip(points, points[1:])]
    return rows


def influence(place, panels):
    """Integrals over panels of ln r and of its derivative along their normal (to the right of their direction), seen from places."""
    a, b = panels[:, :2], panels[:, 2:]
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    off = a[None] - place[:, None]
    s = np.einsum("ijk,jk->ij", off, along)
    d = np.einsum("ijk,jk->ij", off, normal)
    e = s + length
    angle = np.arctan2(e, d) - np.arctan2(s, d)
    angle = np.where(np.abs(d) < 1e-12, 0, np.arctan(e / np.where(d == 0, 1, d)) - np.arctan(s / np.where(d == 0, 1, d)))
    log = lambda x: x * np.log(np.maximum(np.hypot(x, d), 1e-300)) - x
    return log(e) - log(s) + d * angle, angle


def decay(hull, *, half_length, depth, about, inertia, stiffness, start, seconds, dt=0.005):
    """Times and positions of a body in heave (about None) or in roll about a point of the line of symmetry, m and s, per metre
    of its length and per density of water, let go at `start`. hull: corners from the keel to the water line."""
    surface = panels_between([hull[-1], (half_length, 0)], [0.05])
    body = panels_between(hull, [0.03] * (len(hull) - 1))
    fixed = panels_between([(half_length, 0), (half_length, -depth), (0, -depth)], [0.1, 0.1])
    panels = np.array(body + surface + fixed)
    n_body, n_surface = len(body), len(surface)
    middle = (panels[:, :2] + panels[:, 2:]) / 2
    mirrored = panels[:, [2, 3, 0, 1]] * [-1, 1, -1, 1]
    sign = 1 if about is None else -1
    g1, h1 = influence(middle, panels)
    g2, h2 = influence(middle, mirrored)
    np.fill_diagonal(h1, np.diag(h1) - (h1 + h2).sum(axis=1))  # where all have the same potential nothing flows
    g, h = g1 + sign * g2, h1 + sign * h2
    is_surface = np.zeros(len(panels), bool)
    is_surface[n_body:n_body + n_surface] = True
    # Unknown: the flux on the surface, the potential elsewhere.
    matrix = np.where(is_surface[None], g, -h)
    inverse = np.linalg.inv(matrix)
    length = np.linalg.norm(panels[:, 2:] - panels[:, :2], axis=1)
    t = (panels[:, 2:] - panels[:, :2]) / length[:, None]
    normal = np.stack([t[:, 1], -t[:, 0]], axis=1)
    arm = normal[:, 1] if about is None else (middle[:, 1] - about) * normal[:, 0] - middle[:, 0] * normal[:, 1]
    arm = np.where(np.arange(len(panels)) < n_body, arm, 0)

    def solve(potential, flux):
        known = np.where(is_surface[None], h, -g) @ np.where(is_surface, potential, flux)
        found = inverse @ known
        return np.where(is_surface, potential, found), np.where(is_surface, found, flux)

    def force_of(potential_rate):
        return 2 * np.sum((potential_rate * arm * length)[:n_body])

    # Normals point into the water, so that pressure pushes against them.
    added = -force_of(solve(np.zeros(len(panels)), arm)[0])
    eta, phi = np.zeros(n_surface), np.zeros(n_surface)

    def rates(state):
        y, v, eta, phi = state
        whole = np.zeros(len(panels))
        whole[is_surface] = phi
        rise = solve(whole, v * arm)[1][is_surface] * normal[is_surface, 1]
        whole[is_surface] = -GRAVITY * eta
        pressure = solve(whole, np.zeros(len(panels)))[0]
        force = force_of(solve(whole, np.zeros(len(panels)))[0])
        return [v, (force - stiffness * y) / (inertia + added), rise, -GRAVITY * eta]

    state, times, places = [start, 0.0, eta, phi], [0.0], [start]
    for _ in range(round(seconds / dt)):
        k1 = rates(state)
        k2 = rates([x + dt / 2 * r for x, r in zip(state, k1)])
        k3 = rates([x + dt / 2 * r for x, r in zip(state, k2)])
        k4 = rates([x + dt * r for x, r in zip(state, k3)])
        state = [x + dt / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4)]
        times.append(times[-1] + dt)
        places.append(state[0])
    return np.array(times), np.array(places), added

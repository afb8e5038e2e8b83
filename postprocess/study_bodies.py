#!/usr/bin/python3
"""Bodies that float, against what is known of them: heave of half a cylinder of water (Ito, 1977) and roll of a barge against linear
theory in the same tank, draughts of cylinders, a ball of the water's density, a light ball that is let go under water, free fall, and
the energy of a raft.

One row for each case and quantity: what is expected, and what the run has. Theory of heave and roll is that of small motions of water
without viscosity (Maskell & Ursell, J. Fluid Mech. 44, 1970), here by boundary elements on the tank's own walls, half of it by symmetry.
"""

import csv
import math
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from study import GRAVITY, columns_of, launch, parser_of

RESULTS = Path(__file__).resolve().parent / "results"
SCENE = """
[domain]
min = [0.0, 0.0, 0.0]
max = {box}
[fluid]
spacing = {spacing}
[[particles]]
min = [0.0, 0.0, 0.0]
max = {water}
[time]
dt = {dt}
end = {end}
{gravity}
[[body]]
{body}
[output.series]
every_steps = 1
"""


def run(trevi, body, *, box, depth, spacing, dt, end, gravity="[gravity]"):
    """Columns of series.csv and bodies.csv of a tank with water up to `depth` and one body."""
    with tempfile.TemporaryDirectory() as folder:
        scene, output = Path(folder) / "scene.toml", Path(folder) / "run"
        lines = "\n".join(f"{key} = {value}" for key, value in body.items())
        scene.write_text(SCENE.format(box=list(map(float, box)), water=[*map(float, box[:2]), float(depth)], spacing=spacing, dt=dt,
                                      end=end, gravity=gravity, body=lines), encoding="utf-8")
        code, message = launch(trevi, scene, output, (), 1800)
        if code != 0:
            raise SystemExit(f"study_bodies: {message}")
        series, bodies = columns_of(output / "series.csv"), columns_of(output / "bodies.csv")
        return {k: np.array(v) for k, v in series.items()}, {k: np.array(v) for k, v in bodies.items()}


# ---- linear theory

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


# ---- cases: each gives rows of quantity, unit, expected, measured, and curves to draw

def heave(trevi, spacing):
    radius, depth, half = 1.0, 2.5, 10.0
    hull = [(radius * math.sin(a), -radius * math.cos(a)) for a in np.linspace(0, math.pi / 2, 31)]
    t, y, _ = decay(hull, half_length=half, depth=depth, about=None, inertia=math.pi / 2, stiffness=2 * GRAVITY, start=1 / 3,
                    seconds=4.2)
    body = {"type": '"cylinder"', "radius": radius, "height": 4 * spacing, "axis": [0.0, 1.0, 0.0],
            "center": [half, 2 * spacing, depth + radius / 3], "density": 500, "free": ["z"]}
    _, found = run(trevi, body, box=(2 * half, 4 * spacing, depth + 2), depth=depth, spacing=spacing, dt=0.01, end=4.2)
    here = (found["z_0"] - depth) * 3
    theory = np.interp(found["time"], t, y) * 3
    off = np.abs(here - theory)
    rows = [("largest difference of y from theory, of the start", "1", 0, off.max()),
            ("mean difference", "1", 0, off.mean())]
    for name, low, high, pick in (("first trough", 0.5, 1.8, np.argmin), ("first crest", 1.6, 3.0, np.argmax)):
        a, b = (t > low) & (t < high), (found["time"] > low) & (found["time"] < high)
        rows.append((name + " of y, of the start", "1", 3 * y[a][pick(y[a])], here[b][pick(here[b])]))
        rows.append(("time of it", "s", t[a][pick(y[a])], found["time"][b][pick(here[b])]))
    return rows, (found["time"] * math.sqrt(GRAVITY / radius), here, theory)


def crossings(t, y):
    at = np.flatnonzero(y[1:] * y[:-1] < 0)
    return t[at] + (t[at + 1] - t[at]) * y[at] / (y[at] - y[at + 1])


def roll(trevi, spacing):
    depth, half, angle = 2.0, 8.0, 5.0
    t, y, _ = decay([(0, -0.5), (1, -0.5), (1, 0)], half_length=half, depth=depth, about=0, inertia=5 / 12,
                    stiffness=GRAVITY * (8 / 12 - 0.25), start=angle, seconds=6)
    body = {"type": '"box"', "size": [2.0, 4 * spacing, 1.0], "center": [half, 2 * spacing, depth], "rotate": [0.0, angle, 0.0],
            "density": 500, "free": ["pitch"]}
    _, found = run(trevi, body, box=(2 * half, 4 * spacing, depth + 1.5), depth=depth, spacing=spacing, dt=0.01, end=6.0)
    turned = np.degrees(2 * np.arctan2(found["qy_0"], found["qw_0"]))
    expected, measured = crossings(t, y), crossings(found["time"], turned)
    period = lambda at: 2 * (at[4] - at[0]) / 4 if len(at) > 4 else math.nan
    a, b = (t > 1) & (t < 4), (found["time"] > 1) & (found["time"] < 4)
    return [("period, five crossings", "s", period(expected), period(measured)),
            ("angle at its second crest, of the start", "1", y[a].max() / angle, turned[b].max() / angle)
            ], (found["time"], turned, np.interp(found["time"], t, y))


def draught(trevi, density):
    radius, spacing, depth, length, width = 0.4, 0.05, 1.0, 4.0, 0.2
    body = {"type": '"cylinder"', "radius": radius, "height": width, "axis": [0.0, 1.0, 0.0], "density": density, "free": ["z"],
            "center": [length / 2, width / 2, depth + radius * (1 - 2 * density / 1000) + 0.05]}
    _, found = run(trevi, body, box=(length, width, 2.0), depth=depth, spacing=spacing, dt=1 / 60, end=15.0)
    wet = density / 1000 * math.pi * radius**2
    area = lambda d: radius**2 * math.acos(1 - d / radius) - (radius - d) * math.sqrt(2 * radius * d - d * d)
    low, high = 0.0, 2 * radius
    for _ in range(60):
        low, high = ((low + high) / 2, high) if area((low + high) / 2) < wet else (low, (low + high) / 2)
    # Particles under the body at the start have been left out: as much water as there is.
    start = body["center"][2]
    inside = max(0.0, min(2 * radius, depth - start + radius))
    level = depth + (wet - area(inside)) / length
    late = found["time"] > 10
    return [("draught less Archimedes'", "spacings", 0, (level - (found["z_0"][late].mean() - radius) - low) / spacing)], None


def neutral(trevi, spacing=0.05):
    body = {"type": '"sphere"', "radius": 3 * spacing, "center": [0.5, 0.5, 0.5], "density": 1000}
    _, found = run(trevi, body, box=(1.0, 1.0, 1.3), depth=1.0, spacing=spacing, dt=1 / 60, end=20.0)
    way = np.sqrt(sum((found[f"{a}_0"] - 0.5) ** 2 for a in "xyz"))
    return [("largest way in 20 s", "spacings", 0, way.max() / spacing)], None


def light(trevi, spacing=0.05):
    radius = 2.4 * spacing
    body = {"type": '"sphere"', "radius": radius, "center": [0.5, 0.5, 0.4], "density": 50}
    series, found = run(trevi, body, box=(1.0, 1.0, 2.5), depth=1.4, spacing=spacing, dt=1 / 60, end=6.0)
    rising = found["z_0"] < 1.4 - 2 * radius
    rising &= np.cumsum(~rising) == 0
    # A ball with the drag coefficient 0.5: g (1 - 0.05) 4/3 pi r^3 = 0.5/2 pi r^2 v^2.
    terminal = math.sqrt(GRAVITY * 0.95 * 16 / 3 * radius)
    return [("highest speed under water; terminal at a drag coefficient of 0.5", "m/s", terminal, found["vz_0"][rising].max()),
            ("jump of its centre above the surface", "m", math.nan, found["z_0"].max() - 1.4),
            ("fastest particle", "m/s", math.nan, max(series["speed_max"])),
            ("substeps a step", "1", 1, series["substeps"].max())], None


def fall(trevi):
    body = {"type": '"box"', "size": [0.3, 0.5, 0.2], "center": [0.6, 0.6, 4.0], "density": 500, "velocity": [0.3, 0.0, 0.0],
            "angular_velocity": [5.0, 0.5, 0.5]}
    _, found = run(trevi, body, box=(1.2, 1.2, 5.0), depth=0.1, spacing=0.1, dt=1 / 60, end=0.75)
    t = found["time"]
    off = np.hypot(found["x_0"] - 0.6 - 0.3 * t, found["z_0"] - 4 + GRAVITY / 2 * t * t)
    spin = 0.5 * 0.3 * 0.5 * 0.2 / 12 * 1000 * np.array([0.5**2 + 0.2**2, 0.3**2 + 0.2**2, 0.3**2 + 0.5**2])
    start = np.linalg.norm(spin * [5, 0.5, 0.5])
    q = np.stack([found[f"q{a}_0"] for a in "wxyz"], axis=1)
    w = np.stack([found[f"w{a}_0"] for a in "xyz"], axis=1)
    u = q[:, 1:]
    turned = w - 2 * np.cross(u, q[:, :1] * w) + 2 * np.cross(u, np.cross(u, w))  # into the frame of the body
    moment = np.linalg.norm(turned * spin, axis=1)
    return [("off the parabola", "m", 0, off.max()), ("change of angular momentum, of itself", "1", 0, np.abs(moment / start - 1).max())
            ], None


def raft(trevi, spacing=0.05):
    body = {"type": '"box"', "size": [0.4, 0.3, 0.15], "center": [0.6, 0.4, 0.54], "rotate": [0.0, 5.0, 0.0], "density": 500}
    series, _ = run(trevi, body, box=(1.2, 0.8, 0.9), depth=0.45, spacing=spacing, dt=1 / 60, end=10.0)
    energy = series["kinetic_energy"] + series["potential_energy"]
    return [("change of the water's energy in all, from 4 s on", "J", math.nan, energy[-1] - energy[240]),
            ("the same of its kinetic energy", "J", math.nan, series["kinetic_energy"][-1] - series["kinetic_energy"][240])], None


def draw(curves, path):
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.6))
    for axis, (title, unit, scale, named) in zip(axes, (("heave of half a cylinder", "t √(g/R)", "y / y0", "heave"),
                                                        ("roll of a barge", "t, s", "angle, °", "roll"))):
        for case, (t, here, theory) in curves.items():
            if case.startswith(named):
                axis.plot(t, here, label=case.split(", ")[1])
        axis.plot(t if named in case else curve_of(curves, named)[0], curve_of(curves, named)[2], "k--", lw=1, label="theory")
        axis.set(title=title, xlabel=unit, ylabel=scale)
        axis.grid(alpha=0.3)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def curve_of(curves, named):
    return [curve for case, curve in curves.items() if case.startswith(named)][-1]


CASES = {"free fall": fall, "light ball": light, "ball of the water's density": neutral, "raft": raft,
         **{f"cylinder of {d} kg/m³": (lambda trevi, d=d: draught(trevi, d)) for d in (300, 500, 700)},
         **{f"heave, {n} spacings a radius": (lambda trevi, n=n: heave(trevi, 1 / n)) for n in (10, 20)},
         **{f"roll, {n} spacings of draught": (lambda trevi, n=n: roll(trevi, 0.5 / n)) for n in (10,)}}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", help="cases whose name begins so")
    arguments = parser.parse_args()
    rows, curves = [], {}
    for case, measure in CASES.items():
        if arguments.only and not case.startswith(arguments.only):
            continue
        found, curve = measure(arguments.trevi)
        rows += [(case, *row) for row in found]
        for row in rows[-len(found):]:
            print(*row, sep="; ", flush=True)
        if curve:
            curves[case] = curve
    with open(arguments.output, "w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["case", "quantity", "unit", "expected", "measured"])
        out.writerows([*row[:3], *(f"{x:.4g}" for x in row[3:])] for row in rows)
    if {case.split(",")[0] for case in curves} >= {"heave", "roll"}:
        draw(curves, arguments.output.with_suffix(".png"))


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Taylor-Green vortices in a periodic box, against what Navier and Stokes say.

Four vortices in 1 m, in a box three kernel radii thin. Their energy is E0 exp(-4 nu k^2 t), k = 2 pi/1 m; the columns are the
ratio to it when it should have come to 3/4, 1/2 and 1/4. "wide" is wendland_c2 with h = 4 spacings, "default" the default kernel.
The Reynolds number is largest speed x 1 m/nu. The rows go to a CSV file.
"""

import math
import tempfile
from pathlib import Path

from study import parser_of, simulate, two_at_a_time, write_table

STEP = 0.005  # s
KERNELS = {"wide": (4, 'density_kernel = "wendland_c2"'), "default": (2, "")}
FLOWS = ((0.1, 0.05), (0.5, 0.05), (1.0, 0.01))  # m/s, m²/s


def vortex(trevi, kernel, across, speed, nu):
    radius, line = KERNELS[kernel]
    rate = 16 * math.pi**2 * nu
    end = STEP * (math.ceil(math.log(4) / rate / STEP) + 1)
    corners = f"min = [0.0, 0.0, 0.0]\nmax = [1.0, 1.0, {3 * radius / across!r}]\n"
    text = (f'[domain]\n{corners}periodic = ["x", "y", "z"]\n[fluid]\nspacing = {1 / across!r}\n'
            f"kernel_radius = {radius / across!r}\n{line}\n[[particles]]\n{corners}vortex = {speed}\n"
            f"[time]\ndt = {STEP}\nend = {end}\n[viscosity]\nnu = {nu}\n[output.series]\n")
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(text, encoding="utf-8")
        columns, code, message = simulate(trevi, scene, time_limit=7200)
    if code != 0:
        raise SystemExit(f"{text}\n{message}")
    energy, time = columns["kinetic_energy"], columns["time"]

    def ratio_when(share):
        row = round(-math.log(share) / rate / STEP)
        return round(energy[row] / energy[0] * math.exp(rate * time[row]), 4)

    return {"kernel": kernel, "across": across, "reynolds": round(speed / nu), "at_three_quarters": ratio_when(0.75),
            "at_half": ratio_when(0.5), "at_quarter": ratio_when(0.25),
            "compression_mean": float(f"{columns['compression_mean'][-1]:.2g}")}


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--largest", type=int, default=40, help="particles across of the finest runs, 20, 40 or 80")
    arguments = parser.parse_args()
    cases = [(kernel, across, *flow) for across in (20, 40, 80) if across <= arguments.largest
             for kernel in KERNELS for flow in FLOWS]
    rows = []
    for row in two_at_a_time(lambda case: vortex(arguments.trevi, *case), cases):
        print(row, flush=True)
        rows.append(row)
    write_table(arguments.output, rows)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Makes the tables of postprocess/results from the csv files beside them. A table follows a line that names it:

    <!-- result_tables.py: leaks -->

With --check it writes nothing, and ends with exit code 1 where a page has another table than its csv file.
"""

import argparse
import csv
import re
import statistics
import sys
from pathlib import Path

RESULTS = Path(__file__).resolve().parent / "results"


def rows_of(name):
    with open(RESULTS / f"{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def fixed(text, decimals):
    return f"{float(text):.{decimals}f}"


def signed(text, decimals):
    """As fixed(), with a sign that is a minus where it is one."""
    number = fixed(text, decimals)
    return "\N{MINUS SIGN}" + number[1:] if number.startswith("-") else "+" + number


def short(value, digits):
    """2.6e-4"""
    mantissa, exponent = f"{float(value):.{digits - 1}e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def flow(names):
    rows = sorted((row for row in rows_of("pipe") if row["flow"] in names), key=lambda row: names.index(row["flow"]))
    torque = "cylinders" in names
    yield ["", "particles across", "root mean square", "largest", "mean flow"] + ["torque"] * torque
    for row in rows:
        yield [row["flow"], row["across"]] + [fixed(row[key], 3) for key in ("rms_error", "largest_error", "mean_over_exact") +
                                              ("torque_over_exact",) * torque]


def vortices():
    kernels = {"wide": "wendland_c2, h = 4 s", "default": "default, h = 2 s"}
    yield ["kernel", "across", "Reynolds number", "at 3/4", "at 1/2", "at 1/4"]
    rows = sorted(rows_of("periodic"), key=lambda row: (list(kernels).index(row["kernel"]), int(row["reynolds"]), int(row["across"])))
    for row in rows:
        yield [kernels[row["kernel"]], row["across"], row["reynolds"]] + [
            fixed(row[key], 3) for key in ("at_three_quarters", "at_half", "at_quarter")]


def tanks(water):
    """{(layers, length, start): {tank: row}}, those that start as a lattice first."""
    pairs = {}
    for row in rows_of("periodic_tanks"):
        if row["water"] == water:
            pairs.setdefault((row["layers"], row["length"], row["start"]), {})[row["tank"]] = row
    return sorted(pairs.items(), key=lambda item: item[0][2] != "lattice")


def pools():
    yield ["layers", "start", "periodic: m²/s²", "spacings", "walls: m²/s²", "spacings"]
    for (layers, _, start), tank in tanks("rest"):
        digits = 1 if start == "lattice" else 2
        cells = []
        for row in (tank["periodic"], tank["walls"]):
            off = row["com_error_spacings"]
            cells += [short(row["kinetic_per_mass"], digits), short(off, 1) if start == "lattice" else fixed(off, 3)]
        yield [layers, start if start == "lattice" else "each particle up to 0.2 spacings off", *cells]


def waves():
    yield ["layers", "length of the ring", "ring: period", "loss", "walls: period", "loss"]
    for (layers, length, _), tank in tanks("wave"):
        cells = []
        for row in (tank["periodic"], tank["walls"]):
            cells += [fixed(row["period_ratio"], 3), f"{100 * float(row['loss_per_half']):.1f} %"]
        yield [layers, f"{float(length):g} m", *cells]


def surfaces():
    yield ["case", "particles", "volume before", "volume", "open edges", "pieces before", "pieces"]
    rows = rows_of("surface")
    for was, row in zip(rows[::2], rows[1::2]):
        yield [row["case"], row["particles"], signed(was["volume_error_percent"], 2) + " %",
               signed(row["volume_error_percent"], 2) + " %", row["open_edges"], was["pieces"], row["pieces"]]


def vessels():
    yield ["vessel", "deep: mean", "median", "largest", "off", "shallow: mean", "median", "largest", "off"]
    rows = rows_of("vessels")
    for vessel in dict.fromkeys(row["vessel"] for row in rows):
        cells = []
        for depth in ("deep", "shallow"):
            those = [row for row in rows if (row["vessel"], row["depth"]) == (vessel, depth)]
            energies = [float(row["kinetic_energy"]) for row in those]
            cells += [short(value, 2) for value in (statistics.mean(energies), statistics.median(energies), max(energies))]
            cells.append(f"{max(float(row['off_spacings']) for row in those):.2f}")
        yield [vessel, *cells]


def leaks():
    yield ["vessel", "particles", "lost", "outside", "nearest, m"]
    for row in rows_of("leaks"):
        yield [row["vessel"], row["particles"], row["lost"], row["outside"], row["farthest_m"].lstrip("-")]


def ducts():
    yield ["case", "spacing, m", "steps a second", "quantity", "theory", "measured"]
    for row in rows_of("ducts"):
        decimals = 0 if "Pa" in row["quantity"] else 4
        yield [row["case"], row["spacing"], row["steps_per_second"], row["quantity"], fixed(row["theory"], decimals),
               fixed(row["measured"], decimals)]


def full_vessels():
    yield ["vessel", "spacing, m", "steps a second", "energy over a rigid body's", "velocities off", "compression"]
    for row in rows_of("full_vessels"):
        resting = row["velocity_off"] == ""
        yield [row["vessel"], row["spacing"], row["steps_per_second"],
               f"at rest: {short(row['kinetic_per_mass'], 2)} m²/s²" if resting else fixed(row["energy_over_rigid"], 3),
               "" if resting else fixed(row["velocity_off"], 3), short(row["compression_mean"], 2)]


def paddles():
    yield ["case", "height, spacings", "step, s", "quantity", "theory", "measured"]
    for row in rows_of("waves"):
        yield [row["case"], f"{float(row['height_spacings']):g}", f"1/{1 / float(row['step_s']):.0f}", row["quantity"],
               row["theory"], fixed(row["measured"], 3)]


def currents():
    rows = rows_of("currents")
    speeds = list(dict.fromkeys(row["current"] for row in rows))
    yield ["steps a second"] + [f"{signed(speed, 1) if float(speed) else '0'} m/s" for speed in speeds]
    for rate in dict.fromkeys(row["steps_per_second"] for row in rows):
        yield [rate] + [signed(row["growth"], 3) for row in rows if row["steps_per_second"] == rate]


def channels():
    yield ["case", "spacing, m", "quantity", "theory", "measured"]
    for row in rows_of("channels"):
        yield [row["case"], row["spacing"], row["quantity"], fixed(row["theory"], 4), fixed(row["measured"], 4)]


def bodies():
    yield ["case", "quantity", "unit", "expected", "measured"]
    for row in rows_of("bodies"):
        yield [row["case"], row["quantity"], "" if row["unit"] == "1" else row["unit"],
               "" if row["expected"] == "nan" else row["expected"], row["measured"]]


def plane_bodies():
    yield ["case", "quantity", "expected", "measured"]
    for row in rows_of("plane_bodies"):
        number = lambda text: "" if text == "nan" else text if re.fullmatch(r"-?\d+", text) else fixed(text, 4)
        yield [row["case"], row["quantity"], number(row["expected"]), number(row["measured"])]


def planes(kind, heads):
    """Rows of two_dimensions.csv of a kind, each with columns (head, name, how it is written)."""
    yield ["case", "dimensions", "particles", *(head for head, _, _ in heads), "CPU s a second"]
    for row in rows_of("two_dimensions"):
        if row["case"].split()[0] in kind.split():
            yield [row["case"], row["dimensions"], f"{int(row['particles']):,}",
                   *(write(row[name]) if row[name] else "" for _, name, write in heads), fixed(row["cpu_per_second"], 2)]


def frames():
    yield ["frames", "bytes a particle", "of all as in `[output.vtkhdf]`"]
    rows = rows_of("frames")
    for row in rows:
        yield [row["frames"].replace("[output.vtkhdf]", "as in `[output.vtkhdf]`"), fixed(row["bytes_per_particle"], 1),
               fixed(float(row["bytes"]) / float(rows[0]["bytes"]), 2)]


def percent(text):
    return f"{100 * float(text):.1f} %"


PLANES = {
    "plane_dams": ("dam", [("front raw", "front_raw", percent), ("shift dT", "shift", lambda x: signed(x, 3)),
                           ("after", "front_shifted", percent), ("energy at 0.8 s", "energy_0.8_s", lambda x: fixed(x, 3)),
                           ("at 1.5 s", "energy_1.5_s", lambda x: fixed(x, 3)),
                           ("compression", "compression_mean", lambda x: f"{100 * float(x):.2f} %")]),
    "plane_waves": ("wave", [("period over linear", "period", lambda x: fixed(x, 3)),
                             ("lost per half-period", "loss_per_half", percent),
                             ("energy rises by", "own_energy_gain", percent)]),
    "plane_rest": ("still pool", [("motion, m²/s²", "motion", lambda x: short(x, 1)),
                                  ("centre of mass too high", "com_error", lambda x: f"{100 * float(x):.3f} %"),
                                  ("energy rises by", "energy_gain", lambda x: f"{100 * float(x):.3f} %")]),
    "plane_vortices": ("vortices shear", [("energy over exact", "energy", lambda x: fixed(x, 3)),
                                          ("effective over true viscosity", "viscosity", lambda x: fixed(x, 3)),
                                          ("shear: energy after 1 turn", "energy_1", lambda x: fixed(x, 3)),
                                          ("after 3", "energy_3", lambda x: fixed(x, 3))]),
}
def shapes():
    columns = {"particles": "particles", "nodes": "nodes", "ranks_a_node": "ranks a node", "slabs": "slabs", "parts": "parts of each",
               "planes_x_rows": "planes x rows a rank", "ms_a_step": "ms a step", "efficiency": "efficiency",
               "efficiency_of_slabs": "slabs alone", "halo_percent": "halo %", "GB_a_node": "GB a node",
               "s_a_frame": "s a frame", "s_a_checkpoint": "s a checkpoint", "s_of_restart": "s of a restart"}
    yield ["", *columns.values()]
    for row in rows_of("scaling_shapes"):
        yield [row["study"]] + [row[key] or "\N{EN DASH}" for key in columns]


TABLES = {name: lambda name=name: planes(*PLANES[name]) for name in PLANES} | {
    "paddles": paddles, "plates": lambda: flow(["plates", "pipe"]), "cylinders": lambda: flow(["cylinders"]), "vortices": vortices,
    "frames": frames, "channels": channels, "ducts": ducts, "currents": currents, "bodies": bodies, "plane_bodies": plane_bodies, "pools": pools, "waves": waves, "surfaces": surfaces, "vessels": vessels,
    "leaks": leaks, "full_vessels": full_vessels, "scaling_shapes": shapes}


def markdown(rows):
    rows = list(rows)
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines[0] = lines[0].replace("|  |", "| |")
    return [lines[0], "|" + "---|" * len(rows[0]), *lines[1:]]


def made(text):
    """The page with its tables made anew, and their names."""
    names, lines, kept = [], text.splitlines(), []
    while lines:
        kept.append(lines.pop(0))
        mark = re.fullmatch(r"<!-- result_tables\.py: (\w+) -->", kept[-1])
        if not mark:
            continue
        names.append(mark[1])
        if lines and not lines[0]:
            kept.append(lines.pop(0))
        while lines and lines[0].startswith("|"):
            lines.pop(0)
        kept += markdown(TABLES[mark[1]]())
    return "\n".join(kept) + "\n", names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing")
    arguments = parser.parse_args()
    found, wrong = [], []
    for page in sorted(RESULTS.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        new, names = made(text)
        found += names
        if new == text:
            continue
        wrong.append(page.name)
        if not arguments.check:
            page.write_text(new, encoding="utf-8")
    if sorted(found) != sorted(TABLES):
        sys.exit(f"the pages have the tables {sorted(found)}, and these can be made: {sorted(TABLES)}")
    if arguments.check and wrong:
        sys.exit(f"not as their csv files: {', '.join(wrong)}; run postprocess/result_tables.py")


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""What the performance model says of 1 to 10,000 nodes, with slabs alone and with cuts inside them; output and restart.

scaling_shapes.py CSV PNG writes a row for each size and number of nodes, and draws them beside published codes. The
constants are those of results/scaling.md, or with --constants those of DIR/constants.json, which scaling.py writes from
the runs of jobs/scaling.sh on any machine. Nothing here is measured but the constants: results/scaling.md says which.
"""

import argparse
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from scaling_model import Basin, Costs, Node, blocks, efficiency, node_bytes, shapes, windows  # noqa: E402
from study import write_table  # noqa: E402

CORES, DOMAINS, MEMORY = 64, 8, 300e9  # of a node; memory domains, which no rank spans; bytes/s
CLUSTER = {"latency": 2e-6, "bandwidth": 12e9, "reduction": 2e-6}
CONSTANTS = {"particle": 456e-9, "cell": 6.5e-9, "serial": 1e-9, "fork": 0.45e-6, "traffic": 2550, "between": 8.1e9}
FRAME, CHECKPOINT = 44, 56  # bytes a particle: float32 (results/frames.md); all fields of the state
NODE_MEMORY = 512e9  # bytes
DISK_OF_NODE, DISK = 2e9, 200e9  # bytes/s that one node writes, and that the file system takes
NODES = (1, 8, 64, 128, 512, 1000, 2304, 4096, 10_000)
# Efficiency of others, over their own smallest run: cores, what they state, where.
PEERS = [("SWIFT, weak, arXiv:1807.01341", "weak", 4096, 0.75),
         ("SWIFT, strong, 512 times the cores, over 100,000, arXiv:1606.02738", "strong", 100_000, 0.60),
         ("ls1 mardyn, strong, 8 to 7168 nodes, doi:10.1177/1094342018819741", "strong", 7168 * 24, 0.81),
         ("ls1 mardyn, weak, the same", "weak", 7168 * 24, 0.88)]
COLOURS = ["#0072B2", "#D55E00", "#009E73"]  # Okabe and Ito


def cube(particles):
    edge = round(particles**(1 / 3))
    return Basin(edge, edge, edge)


STUDIES = {"strong 10⁹": lambda _: cube(1e9), "strong 10¹¹": lambda _: cube(1e11),
           "weak 10⁷ a node": lambda nodes: cube(1e7 * nodes)}


def best(basin, nodes, constants, parts_allowed):
    """(seconds, step, ranks of a node, shape), None where nothing fits into box and memory."""
    found = None
    for each in (DOMAINS * 2**k for k in range(4)):
        node = Node(each, MEMORY, constants["between"])
        costs = Costs(**{key: constants[key] for key in ("particle", "cell", "serial", "fork", "traffic")}, **CLUSTER)
        for shape in shapes(basin, nodes * each):
            step = windows(basin, shape, costs, CORES // each, node) if parts_allowed or shape[1] == 1 else None
            if step and (found is None or step.total() < found[1].total()):
                found = efficiency(basin, nodes * each, step, costs, CORES // each), step, each, shape
    return found


def rows_of(constants):
    rows = []
    for study, basin_of in STUDIES.items():
        for nodes in NODES:
            basin = basin_of(nodes)
            shared, alone = (best(basin, nodes, constants, some) for some in (True, False))
            if shared is None:
                continue
            value, step, each, shape = shared
            memory = node_bytes(basin, shape, Node(each))
            if memory > NODE_MEMORY:
                continue
            block, _ = blocks(basin, shape, each)
            disk = min(nodes * DISK_OF_NODE, DISK)
            home = basin.particles() * CHECKPOINT / nodes / CLUSTER["bandwidth"]
            rows.append({
                "study": study, "nodes": nodes, "cores": nodes * CORES, "particles": f"{basin.particles():.3g}",
                "ranks_a_node": each, "slabs": shape[0], "parts": shape[1],
                "planes_x_rows": f"{block.planes} x {block.rows}", "ms_a_step": f"{1e3 * step.total():.1f}",
                "efficiency": f"{value:.2f}", "efficiency_of_slabs": f"{alone[0]:.2f}" if alone else "",
                "halo_percent": f"{100 * (step.latency + step.transfer) / step.total():.0f}",
                "GB_a_node": f"{memory / 1e9:.1f}", "s_a_frame": f"{basin.particles() * FRAME / disk:.1f}",
                "s_a_checkpoint": f"{basin.particles() * CHECKPOINT / disk:.1f}",
                "s_of_restart": f"{basin.particles() * CHECKPOINT / disk + home:.1f}"})
    return rows


def draw(path, rows):
    figure, panels = plt.subplots(1, 2, figsize=(12, 4.5), constrained_layout=True, sharey=True)
    for panel, kind in zip(panels, ("strong", "weak")):
        for study, colour in zip([name for name in STUDIES if name.startswith(kind)], COLOURS):
            mine = [row for row in rows if row["study"] == study]
            for column, line in (("efficiency", "o-"), ("efficiency_of_slabs", "s:")):
                some = [row for row in mine if row[column]]
                panel.plot([row["cores"] for row in some], [float(row[column]) for row in some], line, color=colour,
                           label=study.split(" ", 1)[1] + (", slabs alone" if line == "s:" else ", cuts inside slabs"))
        for (name, of, cores, value), mark in zip(PEERS, "vD^P"):
            if of == kind:
                panel.plot([cores], [value], mark, color="black", label=name)
        panel.set(xscale="log", ylim=(0, 1.05), xlabel="cores", title=kind)
        panel.grid(alpha=0.3)
        panel.legend(fontsize=7)
    panels[0].set_ylabel("efficiency; ours predicted, others as published")
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("csv", type=Path)
    parser.add_argument("png", type=Path)
    parser.add_argument("--constants", type=Path, help="constants.json of scaling.py; default those of scaling.md")
    arguments = parser.parse_args()
    constants = dict(CONSTANTS)
    if arguments.constants:
        try:
            given = json.loads(arguments.constants.read_text(encoding="utf-8"))
            constants.update({key: float(given[key]) for key in CONSTANTS})
        except (OSError, ValueError, KeyError, TypeError) as error:
            sys.exit(print(f"scaling_shapes.py: {arguments.constants}: no constants of scaling.py ({error}); write them "
                           "with jobs/scaling.sh", file=sys.stderr) or 2)
    rows = rows_of(constants)
    write_table(arguments.csv, rows)
    draw(arguments.png, rows)


if __name__ == "__main__":
    main()

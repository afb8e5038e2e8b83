#!/usr/bin/python3
"""Tables and plots of the runs of jobs/scaling.sh, and the performance model fitted to them.

scaling.py DIR reads DIR/STUDY/CASE/npRANKS[xTHREADS]-NUMBER/run.json (and series.csv) and DIR/network/*.csv, prints the
tables as Markdown and writes DIR/scaling.csv, DIR/metrics.csv and DIR/scaling.png. With runs of the strong study on
one core and the network at hand it goes on to the model: DIR/constants.json, model.csv and model.png, its error on the
runs, its predictions for nodes of 64 cores, and the two ways to exchange ghosts.
"""

import argparse
import csv
import json
import re
import statistics
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import LogLocator, NullFormatter  # noqa: E402

from scaling_model import (CYCLES, EXCHANGES, SCALAR, SWEEPS, Basin, Costs, Node, efficiency,  # noqa: E402
                           exchange_bytes, messages, node_bytes, rebuild_bytes, redundant_lambda, slabs)
from scaling_metrics import metric_rows, work_rows  # noqa: E402
from study import columns_of, write_table  # noqa: E402
from trevi_run import Run, RunError  # noqa: E402

TIMED = ("strong", "weak")
# The basins of jobs/scaling.sh, in layers of particles.
BASINS = {("strong", "96k"): lambda _: Basin(60, 40, 40), ("strong", "million"): lambda _: Basin(100, 100, 100),
          ("weak", "96k"): lambda ranks: Basin(60 * ranks, 40, 40),
          ("weak", "million"): lambda ranks: Basin(50 * ranks, 100, 100),
          ("counted", "rest"): lambda _: Basin(60, 40, 40), ("counted", "rest_filters"): lambda _: Basin(60, 40, 40)}
FILTER_EXCHANGES = {"rest_filters": 3}  # velocities twice, curl
# Of a step on one thread, by perf record of 96,000 particles at rest: the multigrid, loops over planes.
MULTIGRID, BY_PLANES = 0.028, 0.065
# Measured, too: memory cleared and moved, and the search for particles that leave, both by the first thread; start and
# end of a loop on two threads, for each; bytes by cachegrind with 4 MB of cache.
THREADS = {"serial": 1e-9, "migration": 5e-9, "fork": 0.45e-6, "traffic": 2550}
# What the predictions assume of a cluster; the cores are taken to be those of the runs.
CLUSTER = {"latency": 2e-6, "bandwidth": 12e9, "reduction": 2e-6}
CORES, MEMORY = 64, 300e9  # of a node; bytes/s
SHAPES = {("cube", 1e9): (Basin(1000, 1000, 1000), (1, 7, 31, 125, 250, 500)),
          ("cube", 1e11): (Basin(4642, 4642, 4642), (36, 128, 580, 1160, 2321)),
          ("channel", 1e11): (Basin(1e6, 1000, 100), (125, 1250, 12_500))}
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]  # Okabe and Ito


class BadInput(Exception):
    pass


# ---- runs -----------------------------------------------------------------------------------------------------------

def read_runs(folder):
    runs = []
    for path in sorted(folder.glob("*/*/np*-*/run.json")):
        try:
            run = Run(path.parent).report
            run["study"], run["case"], place = path.parts[-4:-1]
            run["ranks"], run["threads"] = (int(n) for n in re.match(r"np(\d+)(?:x(\d+))?-", place).groups(default=1))
            run["ms"] = 1e3 * run["wall_seconds"] / run["steps"]
            run["wait"] = statistics.mean(run["halo_wait_seconds"]) / run["wall_seconds"]
        except (RunError, AttributeError, KeyError, TypeError, ZeroDivisionError) as error:
            raise BadInput(f"{path}: not the report of a run that ended ({error}); run it again") from error
        run["series"] = columns_of(path.parent / "series.csv")
        runs.append(run)
    if not runs:
        raise BadInput(f"{folder}: no STUDY/CASE/npRANKS[xTHREADS]-NUMBER/run.json; make them with jobs/scaling.sh")
    return runs


def groups_of(runs):
    groups = {}
    for run in runs:
        groups.setdefault((run["study"], run["case"], run["ranks"], run["threads"]), []).append(run)
    return groups


def rows_of(groups):
    """One row for each study, case, ranks and threads; without times where ranks had to share cores."""
    rows = []
    for (study, case, ranks, threads), runs in sorted(groups.items()):
        fastest, timed = min(runs, key=lambda run: run["ms"]), study in TIMED
        base = groups.get((study, case, 1, 1)) if timed else None
        row = {"study": study, "case": case, "ranks": ranks, "threads": threads, "runs": len(runs),
               "particles": fastest["particles"]}
        median = statistics.median(run["ms"] for run in runs)
        row["ms_per_step_median"] = f"{median:.1f}" if timed else ""
        row["ms_per_step_fastest"] = f"{fastest['ms']:.1f}" if timed else ""
        ideal = ranks * threads if study == "strong" else 1
        for name, pick in (("median", statistics.median), ("fastest", min)):
            time = pick(run["ms"] for run in runs)
            row[f"efficiency_{name}"] = f"{pick(run['ms'] for run in base) / ideal / time:.3f}" if base else ""
        row["wait_percent_median"] = f"{100 * statistics.median(run['wait'] for run in runs):.1f}" if timed else ""
        row["wait_percent_least"] = f"{100 * min(run['wait'] for run in runs):.1f}" if timed else ""
        row["imbalance_mean"] = f"{fastest['imbalance']['mean']:.4f}"
        row["imbalance_max"] = f"{fastest['imbalance']['max']:.4f}"
        row["cut_moves"] = fastest["cut_moves"]
        row["messages_per_step"] = f"{fastest['halo_messages_per_step']:.1f}"
        row["bytes_per_step"] = f"{fastest['halo_bytes_per_step']:.0f}"
        row["bytes_per_particle"] = f"{fastest['bytes_per_particle']:.0f}"
        rows.append(row)
    return rows


def print_table(title, rows):
    print(f"\n### {title}\n")
    print("| " + " | ".join(name.replace("_", " ") for name in rows[0]) + " |")
    print("|" + "---|" * len(rows[0]))
    for row in rows:
        print("| " + " | ".join(str(value) for value in row.values()) + " |")


def draw_runs(path, rows, groups):
    figure, (times, shares, balance) = plt.subplots(1, 3, figsize=(15, 4.5), constrained_layout=True)
    cases = sorted({(row["study"], row["case"]) for row in rows if row["study"] in TIMED})
    for (study, case), colour in zip(cases, COLOURS * 2):
        for threaded, mark in ((False, "o"), (True, "s")):
            mine = [row for row in rows if (row["study"], row["case"]) == (study, case)
                    and (row["ranks"] * row["threads"] == 1 or (row["threads"] > 1) == threaded)]
            if threaded and all(row["threads"] == 1 for row in mine):
                continue
            cores, name = [row["ranks"] * row["threads"] for row in mine], f"{study} {case}" + ", threads" * threaded
            times.plot(cores, [float(row["ms_per_step_fastest"]) for row in mine], mark + "-", color=colour, label=name)
            if all(row["efficiency_fastest"] for row in mine):
                for value, line in (("fastest", "-"), ("median", ":")):
                    shares.plot(cores, [float(row[f"efficiency_{value}"]) for row in mine], mark + line, color=colour,
                                label=name if line == "-" else None)
    times.set(yscale="log", xlabel="cores: ranks, or threads of one", ylabel="wall time of a step, fastest run (ms)")
    shares.set(ylim=(0, 1.1), xlabel="cores: ranks, or threads of one", ylabel="efficiency (1); dotted: by the median")
    for panel in (times, shares):
        panel.set_xscale("log", base=2)
        panel.xaxis.set_major_formatter("{x:.0f}")
    plain_ticks(times.yaxis, "{x:.0f}")
    draw_balance(balance, groups)
    for panel in (times, shares, balance):
        panel.grid(alpha=0.3)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=8)
    figure.savefig(path, dpi=110)


def plain_ticks(axis, form):
    """1, 2, 5, 10, ... in place of powers."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(form)
    axis.set_minor_formatter(NullFormatter())


def draw_balance(panel, groups):
    cases = sorted(key for key in groups if key[0] == "balance" and groups[key][0]["series"])
    names = sorted({(case.rsplit("_", 1)[0], ranks) for _, case, ranks, _ in cases})
    for _, case, ranks, threads in cases:
        name, slabs_kind = case.rsplit("_", 1)
        series = groups["balance", case, ranks, threads][0]["series"]
        panel.plot(series["time"], series["imbalance"], "-" if slabs_kind == "balanced" else ":",
                   color=COLOURS[names.index((name, ranks)) % len(COLOURS)],
                   label=f"{name}, {slabs_kind}, {ranks} ranks")
    panel.set(xlabel="simulated time (s)", ylabel="imbalance, most work over mean work (1)")
    if cases:
        panel.set_yscale("log")
        plain_ticks(panel.yaxis, "{x:g}")
        panel.set_ylim(0.95, None)


# ---- model ----------------------------------------------------------------------------------------------------------

def network_costs(network):
    """Latency s, bandwidth B/s and seconds of a reduction between two ranks, of read_network(); None of nothing."""
    if not network:
        return None
    exchanges = np.array([[1, row["bytes"], row["us"] / 1e6] for row in network if row["operation"] == "exchange"])
    exchanges = exchanges[exchanges[:, 1] < 2e6]  # larger ones leave the caches
    latency, per_byte = np.linalg.lstsq(exchanges[:, :2] / exchanges[:, 2:], np.ones(len(exchanges)), rcond=None)[0]
    reduction = next(row["us"] / 1e6 for row in network if row["operation"] == "reduce")
    return {"latency": latency, "bandwidth": 1 / per_byte, "reduction": reduction}


def fit(groups, network):
    """Costs from the fastest runs of the strong and weak studies on one core and the network between two."""
    alone = {}
    for run in sorted((run for runs in groups.values() for run in runs), key=lambda run: -run["ms"]):
        if run["study"] in TIMED and (run["study"], run["case"]) in BASINS and run["ranks"] == run["threads"] == 1:
            alone[run["particles"]] = run
    step = statistics.mean(run["ms"] / 1e3 / particles for particles, run in alone.items())
    by_planes, cell = BY_PLANES * step, MULTIGRID * step * 8 / (CYCLES * SWEEPS * 4 / 3)
    particle = (1 - BY_PLANES - MULTIGRID) * step - THREADS["serial"]
    largest = max(alone.values(), key=lambda run: run["particles"])
    return Costs(particle, cell, **network_costs(network), by_planes=by_planes, **THREADS), largest


def phase_ms(run, name):
    return next(1e3 * phase["seconds"]["mean"] / run["steps"] for phase in run["phases"] if phase["name"] == name)


def read_network(folder):
    """Times between two ranks: the median of those that start together."""
    rows = []
    for path in sorted(folder.glob("network/np2*.csv")):
        with open(path, newline="", encoding="utf-8") as stream:
            rows += [{"operation": row["operation"], "bytes": int(row["bytes"]), "us": float(row["median_us"])}
                     for row in csv.DictReader(stream)]
    return rows


def check_model(groups, costs):
    rows = []
    for (study, case, ranks, threads), runs in sorted(groups.items()):
        if (study, case) not in BASINS or study not in TIMED:
            continue
        basin, fastest = BASINS[study, case](ranks * threads), min(runs, key=lambda run: run["ms"])
        model = 1e3 * slabs(basin, ranks, costs, threads).total()
        median = statistics.median(run["ms"] for run in runs)
        rows.append({"run": f"{study} {case}, {ranks} x {threads}", "model_ms": f"{model:.1f}",
                     "fastest_ms": f"{fastest['ms']:.1f}", "error_percent": f"{100 * (model / fastest['ms'] - 1):+.1f}",
                     "median_ms": f"{median:.1f}", "error_to_median_percent": f"{100 * (model / median - 1):+.1f}"})
    return rows


def check_traffic(groups):
    """Messages and bytes of a whole run, its start included, by the formula and as counted."""
    rows = []
    for (study, case, ranks, _), (run, *_) in sorted(groups.items()):
        if study != "counted" or case not in [name for kind, name in BASINS if kind == study]:
            continue
        basin, steps, filters = BASINS[study, case](ranks), run["steps"], FILTER_EXCHANGES.get(case, 0)
        ways = 2 * (ranks - 1)  # both, through every cut
        rows.append({"case": case, "ranks": ranks, "steps": steps,
                     "messages_by_formula": round(ways * (steps * messages(basin, filters) + 2)),
                     "messages": round(run["halo_messages_per_step"] * steps),
                     "bytes_by_formula": round(ways * (steps * exchange_bytes(basin, filters) + rebuild_bytes(basin))),
                     "bytes": round(run["halo_bytes_per_step"] * steps),
                     "imbalance": f"{run['imbalance']['max']:.3f}"})
    return rows


def predictions(costs, between):
    """All splits of nodes into ranks and threads; in `mended`, if migration and loops over planes went by rows, too."""
    mended = costs._replace(particle=costs.particle + costs.by_planes + costs.migration, by_planes=0.0, migration=0.0)
    rows = []
    for (shape, particles), (basin, numbers) in SHAPES.items():
        for nodes in numbers:
            for each in (2**k for k in range(7)):
                node, ranks, threads = Node(each, MEMORY, between), nodes * each, CORES // each
                step, other = (slabs(basin, ranks, some, threads, node) for some in (costs, mended))
                if step is None:
                    continue
                row = {"shape": shape, "particles": f"{particles:.0e}", "nodes": nodes, "ranks": ranks,
                       "threads": threads, "planes_a_rank": f"{basin.planes() / ranks:.1f}",
                       "ms_a_step": f"{1e3 * step.total():.1f}",
                       "efficiency": f"{efficiency(basin, ranks, step, costs, threads):.2f}"}
                for name, seconds in step._asdict().items():
                    row[f"{name}_percent"] = f"{100 * seconds / step.total():.0f}"
                row["mended_ms"] = f"{1e3 * other.total():.1f}"
                row["mended_efficiency"] = f"{efficiency(basin, ranks, other, costs, threads):.2f}"
                row["GB_a_node"] = f"{node_bytes(basin, (ranks, 1), node) / 1e9:.1f}"
                rows.append(row)
    return rows


def best_of(rows, value):
    """Of each number of nodes the split that takes least."""
    best = {}
    for row in rows:
        key = row["shape"], row["particles"], row["nodes"]
        if key not in best or float(row[value]) < float(best[key][value]):
            best[key] = row
    return list(best.values())


def exchange_choice(costs, largest):
    """Whether one exchange an iteration with a wider ghost layer could win: rows by the size of a plane."""
    particles = largest["particles"]
    passes = next(phase["calls"] for phase in largest["phases"] if phase["name"] == "Lambda") / largest["steps"]
    lambda_cost = phase_ms(largest, "Lambda") / 1e3 / passes / particles
    search_cost = phase_ms(largest, "NeighbourSearch") / 1e3 / particles
    here, there = (latency / redundant_lambda(1, lambda_cost, search_cost)
                   for latency in (costs.latency, CLUSTER["latency"]))
    print(f"\nlambda {1e9 * lambda_cost:.0f} ns, search {1e9 * search_cost:.0f} ns a particle; wider ghosts win below "
          f"{here:.0f} particles a plane here, {there:.0f} on the cluster")
    rows = []
    for plane in (10, 100, 1000, 10_000, 100_000):
        bytes_sent = plane * SCALAR
        rows.append({"particles_a_plane": plane,
                     "second_exchange_here_us": f"{1e6 * (costs.latency + bytes_sent / costs.bandwidth):.1f}",
                     "on_the_cluster_us": f"{1e6 * (CLUSTER['latency'] + 2 * bytes_sent / CLUSTER['bandwidth']):.1f}",
                     "of_it_latency_us": f"{1e6 * CLUSTER['latency']:.1f}",
                     "redundant_work_us": f"{1e6 * redundant_lambda(plane, lambda_cost, search_cost):.1f}"})
    return rows


def draw_model(path, rows):
    figure, panels = plt.subplots(1, len(SHAPES), figsize=(15, 4.5), constrained_layout=True, sharey=True)
    for panel, (shape, particles) in zip(panels, SHAPES):
        mine = [row for row in rows if (row["shape"], row["particles"]) == (shape, f"{particles:.0e}")]
        for threads, colour in zip((1, 4, 16, 32, 64), COLOURS):
            some = [row for row in mine if row["threads"] == threads]
            cores = [row["ranks"] * threads for row in some]
            for value, line in (("efficiency", "o-"), ("mended_efficiency", "o:")):
                panel.plot(cores, [float(row[value]) for row in some], line, color=colour,
                           label=f"{threads} thread{'s' * (threads > 1)} a rank" if line == "o-" else None)
        panel.set(xscale="log", ylim=(0, 1.05), xlabel="cores", title=f"{shape}, {particles:.0e} particles")
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8)
    panels[0].set_ylabel("predicted efficiency (1); dotted: mended")
    figure.savefig(path, dpi=110)


def report_model(folder, groups, network):
    costs, largest = fit(groups, network)
    print(f"\nfitted: {1e9 * costs.particle:.0f} ns a particle and step, {1e9 * costs.cell:.2f} ns a cell and sweep, "
          f"latency {1e6 * costs.latency:.2f} us, {costs.bandwidth / 1e9:.1f} GB/s, reduction "
          f"{1e6 * costs.reduction:.2f} us; {1e9 * costs.by_planes:.0f} ns a particle by planes; "
          f"{EXCHANGES} exchanges of particles a step")
    print_table("Model against the runs", check_model(groups, costs))
    whole = costs.particle + costs.by_planes + costs.migration  # all by rows, as the program has them now
    constants = {"particle": whole, "cell": costs.cell, "serial": costs.serial, "fork": costs.fork,
                 "traffic": costs.traffic, "between": costs.bandwidth, "latency": costs.latency}
    (folder / "constants.json").write_text(json.dumps(constants, indent=2) + "\n", encoding="utf-8")
    cluster = costs._replace(**CLUSTER)
    rows = predictions(cluster, costs.bandwidth)
    write_table(folder / "model.csv", rows)
    print_table("Predictions, fastest split of the nodes", best_of(rows, "ms_a_step"))
    print_table("Fastest if all loops went by rows", best_of(rows, "mended_ms"))
    print_table("Slabs alone", [row for row in rows if row["threads"] == 1])
    print_table("One exchange an iteration or two", exchange_choice(costs, largest))
    draw_model(folder / "model.png", rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where jobs/scaling.sh left its runs")
    folder = parser.parse_args().folder
    groups = groups_of(read_runs(folder))
    rows = rows_of(groups)
    write_table(folder / "scaling.csv", rows)
    print_table("Runs", rows)
    draw_runs(folder / "scaling.png", rows, groups)
    traffic = check_traffic(groups)
    if traffic:
        print_table("Halo traffic", traffic)
    network = read_network(folder)
    efficiencies = metric_rows(groups, network_costs(network))
    if efficiencies:
        write_table(folder / "metrics.csv", efficiencies)
        print_table("POP metrics", efficiencies)
    if work := work_rows(groups):
        print_table("Work of the pair loops", work)
    if network and any(study == "strong" and (study, case) in BASINS and ranks == threads == 1
                       for study, case, ranks, threads in groups):
        report_model(folder, groups, network)


if __name__ == "__main__":
    try:
        main()
    except BadInput as error:
        sys.exit(print(f"scaling.py: {error}", file=sys.stderr) or 2)

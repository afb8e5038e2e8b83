"""The POP metrics of the runs of jobs/scaling.sh, and the work of their pair loops against memory, for scaling.py.
postprocess/results/scaling_metrics.md says what they mean. No program of its own."""

import math
import statistics

PAIR_LOOPS = ("Lambda", "Delta", "Vorticity", "XsphViscosity")


def useful_seconds(run):
    """Of each rank, what it computes: its steps less its waiting."""
    return [step - waiting for step, waiting in zip(run["step_seconds"], run["waiting_seconds"], strict=True)]


def phase(run, name):
    return next((one for one in run.get("phases", []) if one["name"] == name), None)


def transfer_seconds(run, network):
    """What messages and reductions of a rank between two others take on a network that is measured, if nothing hides it;
    at most what the rank that waits least waits."""
    ranks, steps = len(run["step_seconds"]), run["steps"]
    if ranks == 1:
        return 0.0
    ways = 2 * (ranks - 1)  # through the cuts, both directions
    messages, sent = (steps * run[f"halo_{what}_per_step"] / ways for what in ("messages", "bytes"))
    reductions = (phase(run, "Reductions") or {"calls": 0})["calls"]
    seconds = (messages * network["latency"] + sent / network["bandwidth"] +
               reductions * network["reduction"] * math.log2(ranks))
    return min(seconds, max(run["step_seconds"]) - max(useful_seconds(run)))


def metrics(run, alone, network):
    """Efficiencies, 1 at best; `alone`: the run on one core that this one is compared with, or None."""
    useful, wall = useful_seconds(run), max(run["step_seconds"])
    row = {"parallel_efficiency": statistics.mean(useful) / wall,
           "load_balance": statistics.mean(useful) / max(useful),
           "communication": max(useful) / wall,
           "serialisation": None, "transfer": None, "computation": None, "global_efficiency": None}
    if network is not None:
        ideal = wall - transfer_seconds(run, network)
        row["serialisation"], row["transfer"] = max(useful) / ideal, ideal / wall
    if alone is not None:  # per particle and step, so that weak studies have it, too
        cost = [sum(useful_seconds(one)) * cores / (one["particles"] * one["steps"])
                for one, cores in ((alone, 1), (run, run["threads"]))]
        row["computation"] = cost[0] / cost[1]
        row["global_efficiency"] = row["parallel_efficiency"] * row["computation"]
    return row


def shares(run):
    """Percent of the time of all ranks: waiting for others, in it reductions and exchanges with neighbours, and migration
    with its own waiting."""
    total = sum(run["step_seconds"])
    migrate = phase(run, "Migrate")
    of_ranks = {"waiting": sum(run["waiting_seconds"]), "reductions": sum(run["reduction_seconds"]),
                "exchanges": sum(run["halo_wait_seconds"]),
                "migration": migrate["seconds"]["mean"] * len(run["step_seconds"]) if migrate else 0}
    return {f"{name}_percent": 100 * seconds / total for name, seconds in of_ranks.items()}


def metric_rows(groups, network):
    """One row for each group of runs that is timed: of the run whose time is the median."""
    rows = []
    for (study, case, ranks, threads), runs in sorted(groups.items()):
        if study not in ("strong", "weak") or any("waiting_seconds" not in run for run in runs):
            continue
        run = sorted(runs, key=lambda one: one["ms"])[(len(runs) - 1) // 2]
        base = groups.get((study, case, 1, 1))
        alone = sorted(base, key=lambda one: one["ms"])[(len(base) - 1) // 2] if base else None
        row = {"study": study, "case": case, "ranks": ranks, "threads": threads, "runs": len(runs),
               "ms_per_step": f"{run['ms']:.1f}"}
        row |= {name: "" if value is None else f"{value:.3f}" for name, value in metrics(run, alone, network).items()}
        row |= {name: f"{value:.1f}" for name, value in shares(run).items()}
        energy = run.get("energy_joules")
        row["microjoules_a_particle_and_step"] = (
            f"{1e6 * energy / (run['particles'] * run['steps']):.2f}" if energy is not None else "")
        rows.append(row)
    return rows


def work_rows(groups):
    """Of each pair loop on one core of the largest water: work, bytes that must be moved at least, and their rates."""
    alone = [run for (study, _, ranks, threads), runs in groups.items() if ranks == threads == 1
             for run in runs if study in ("strong", "weak")]
    if not alone:
        return []
    run = max(alone, key=lambda one: (one["particles"], -one["ms"]))
    rows = []
    for name in PAIR_LOOPS:
        one = phase(run, name)
        if one and one.get("bytes"):
            seconds = one["seconds"]["mean"]
            rows.append({"loop": name, "particles": run["particles"], "flops_a_byte": f"{one['flops'] / one['bytes']:.1f}",
                         "gflop_a_second": f"{1e-9 * one['flops'] / seconds:.1f}",
                         "gbyte_a_second": f"{1e-9 * one['bytes'] / seconds:.1f}"})
    return rows

#!/usr/bin/env python3
"""How much of a wait for a neighbour is behind work: runs of scenes as they are, with a rank that is slower than the
others, and with messages that take some time on their way, each on clocks of processor time (virtual_time.cpp), so that
neither other work on the machine nor the number of its cores counts. Of each kind a short and a longer run are made,
whose start and end are the same, so that their difference is that of steps. The last kind, without overlap, has the
time of a message pass where it is sent. Prints a table of medians: a step in ms, what its ranks wait in the mean, what
of that is for neighbours that were late and not for the way of messages, and how much of the way was behind work.

    tests/benchmarks/hidden_waiting.py build/bench/trevi inputs/bench_rest.toml inputs/falling_cube.toml --ranks 2 3
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

NUMBERS = ("clock", "computed", "exchanges", "behind", "waited", "late", "way", "reductions", "reduced")
TOLD = re.compile(r"virtual time: rank \d+ clock (\S+) computed (\S+) exchanges (\d+) behind (\d+) waited (\S+) "
                  r"late (\S+) way (\S+) reductions (\d+) waited (\S+)")
FILES = "output.vtu", "output.checkpoint"  # of scenes that have them: they cost time of their own


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trevi", type=Path, help="the program")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--library", type=Path,
                        help="libvirtual_time.so; default: that in tests/benchmarks beside the program")
    parser.add_argument("--ranks", type=int, nargs="+", default=[2, 3])
    parser.add_argument("--steps", type=int, nargs=2, default=[5, 25], help="of the two runs (default 5 25)")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--delay", type=int, default=1000, help="us of a message (default 1000)")
    parser.add_argument("--percent", type=int, default=10, help="by which the slow rank is slower (default 10)")
    arguments = parser.parse_args()
    library = arguments.library or arguments.trevi.parent / "tests/benchmarks/libvirtual_time.so"
    arguments.library = library.resolve()
    if not arguments.library.exists():
        sys.exit(f"{library} is not there: build with -DTREVI_BENCHMARKS=ON, or give --library")
    return arguments


def kinds(arguments):
    """Names of rows, and the environment of each."""
    delay = {"TREVI_DELAY_US": str(arguments.delay)}
    slow = {"TREVI_SLOW_RANK": "0", "TREVI_SLOW_PERCENT": str(arguments.percent)}
    return {"as it is": {}, f"rank 0 slower by {arguments.percent} %": slow,
            f"messages of {arguments.delay / 1000:g} ms": delay,
            "the same, no overlap": {**delay, "TREVI_OVERLAP": "0"}}


def run(arguments, scene, ranks, environment, steps):
    """What each rank told, as rows of NUMBERS."""
    text = Path(scene).read_text(encoding="utf-8")
    sets = [word for table in FILES if f"[{table}]" in text for word in ("--set", f"{table}.every=1000.0")]
    with tempfile.TemporaryDirectory() as folder:
        result = subprocess.run(
            [os.environ.get("MPIRUN", "mpirun"), "-np", str(ranks), str(arguments.trevi), scene, "--steps", str(steps),
             "--threads", "1", "--progress", "none", "--output", f"{folder}/run", *sets],
            env={**os.environ, "LD_PRELOAD": str(arguments.library), **environment}, capture_output=True, text=True,
            check=False)
    told = [[float(number) for number in found] for found in TOLD.findall(result.stderr)]
    if result.returncode != 0 or len(told) != ranks:
        sys.exit(f"{scene} on {ranks} ranks: {result.stderr[-500:]}")
    return told


def figures_of_steps(arguments, scene, ranks, environment):
    """Of a step, in ms where it is a time: the mean of the ranks, but the clock of the last."""
    short, long = (run(arguments, scene, ranks, environment, steps) for steps in arguments.steps)
    steps = arguments.steps[1] - arguments.steps[0]
    means = [[statistics.mean(rank[k] for rank in told) for k in range(len(NUMBERS))] for told in (short, long)]
    row = {name: (after - before) / steps for name, before, after in zip(NUMBERS, *means)}
    row["clock"] = (max(rank[0] for rank in long) - max(rank[0] for rank in short)) / steps
    return {name: value * (1 if name in ("exchanges", "behind", "reductions") else 1000) for name, value in row.items()}


def main():
    arguments = parse_arguments()
    print("| scene, ranks | | ms a step | computing | waits for messages | of it for late neighbours | waits in "
          "reductions | exchanges | all behind work | of their way behind work | reductions |\n" + "|---" * 11 + "|")
    for scene in arguments.scenes:
        for ranks in arguments.ranks:
            rows = {name: [] for name in kinds(arguments)}
            for _ in range(arguments.repeats):
                for name, environment in kinds(arguments).items():
                    rows[name].append(figures_of_steps(arguments, scene, ranks, environment))
            for name, repeats in rows.items():
                row = {key: statistics.median(one[key] for one in repeats) for key in NUMBERS}
                behind = "– | –"
                if name.startswith("messages"):
                    way = arguments.delay / 1000 * row["exchanges"]
                    behind = f"{row['behind']:.1f} | {100 * (1 - row['way'] / way):.0f} %"
                print(f"| {Path(scene).stem}, {ranks} | {name} | {row['clock']:.1f} | {row['computed']:.1f} | "
                      f"{row['waited']:.2f} | {row['late']:.2f} | {row['reduced']:.2f} | {row['exchanges']:.1f} | "
                      f"{behind} | {row['reductions']:.1f} |", flush=True)


if __name__ == "__main__":
    main()

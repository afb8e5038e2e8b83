#!/usr/bin/env python3
"""What of a step threads do not share, by clock_loops.cpp: on one rank of one thread two runs of a scene, whose start
and end are the same, so that their difference is that of steps. Processor time, so that other work on the machine does
not count. Prints the share that is in no loop, which is the first thread's alone, and that of each loop with at most so
many parts, such as the number of planes of cells; no more threads than parts are of use to a loop.

    tests/benchmarks/shared_loops.py build/bench/trevi inputs/bench_rest.toml 5 25 -- --set output.series.every_steps=1
"""

import argparse
import bisect
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trevi", type=Path, help="the program, with libclock_loops.so in tests/benchmarks beside it")
    parser.add_argument("scene")
    parser.add_argument("steps", type=int, help="of the shorter run")
    parser.add_argument("more_steps", type=int, help="of the longer one")
    parser.add_argument("--parts", type=float, default=60, help="loops of at most so many are told (default 60)")
    own, options = sys.argv[1:], []
    if "--" in own:
        own, options = own[:own.index("--")], own[own.index("--") + 1:]  # the latter are trevi's
    arguments = parser.parse_args(own)
    arguments.options = options
    return arguments


def functions_of(library):
    """Addresses and names of its functions, ascending."""
    text = "".join(subprocess.run(["nm", *kind, library], capture_output=True, text=True, check=False).stdout
                   for kind in (["-C"], ["-D", "-C"]))
    return sorted((int(address, 16), name) for address, name in re.findall(r"^([0-9a-f]+) [TtWV] (.*)$", text, re.M))


def measure(arguments, steps):
    """({(library, address of the call): (seconds, seconds since the loop before, calls, parts)}, seconds in all)."""
    shim = arguments.trevi.resolve().parent / "tests/benchmarks/libclock_loops.so"
    with tempfile.TemporaryDirectory() as folder:
        command = [str(arguments.trevi), arguments.scene, "--steps", str(steps), "--output", f"{folder}/run",
                   "--progress", "none", "--threads", "1", *arguments.options]
        run = subprocess.run(command, capture_output=True, text=True, check=False,
                             env={**os.environ, "LD_PRELOAD": str(shim), "OMP_NUM_THREADS": "1"})
    rows = re.findall(r"^loop (\S+) (\S+) (\d+) (\S+) (\S+) (\S+)$", run.stderr, re.M)
    if run.returncode != 0 or not rows:
        raise SystemExit(f"shared_loops.py: {arguments.trevi} ended with {run.returncode}; {shim} must be there\n"
                         + run.stderr)
    loops = {(library, int(address, 16)): (float(seconds), float(before), int(calls), float(parts))
             for seconds, before, calls, parts, library, address in rows}
    return loops, max(float(seconds) for seconds in re.findall(r"^all (\S+)$", run.stderr, re.M))


def main():
    arguments = parse_arguments()
    (before, begin), (after, end) = (measure(arguments, steps) for steps in (arguments.steps, arguments.more_steps))
    steps, rows = arguments.more_steps - arguments.steps, []
    for place, (seconds, alone, calls, parts) in after.items():
        earlier = before.get(place, (0, 0, 0, 0))
        rows.append((100 * (seconds - earlier[0]) / (end - begin), 100 * (alone - earlier[1]) / (end - begin),
                     (calls - earlier[2]) / steps, parts, place))
    print(f"a step takes {1e3 * (end - begin) / steps:.2f} ms of processor time, "
          f"{sum(row[1] for row in rows):.2f} % of it between loops")
    functions = {library: functions_of(library) for library in {row[4][0] for row in rows}}

    def name_of(library, address):
        at = bisect.bisect_right([start for start, _ in functions[library]], address) - 1
        return functions[library][at][1].split("(")[0] if at >= 0 else "?"

    for share, _, calls, parts, place in sorted(rows, reverse=True):
        if parts <= arguments.parts and share >= 0.05:
            print(f"{share:6.2f} %, {calls:5.1f} times a step, {parts:5.1f} parts: {name_of(*place)}")
    print("between loops, by the loop that follows:")
    for _, alone, calls, _, place in sorted(rows, key=lambda row: -row[1]):
        if alone >= 0.03:
            print(f"{alone:6.2f} %, {calls:5.1f} times a step, before {name_of(*place)}")


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""What a step costs from Python, over the same step of the program: a million particles at rest, one rank.

  tests/benchmarks/python_step.py [--pairs N] [--steps N]

Runs of both alternate. The cost of a step is the user CPU time of a run of N + 2 steps less that of a run of 2, over N,
which other work on the machine moves less than wall time. Prints each pair, the medians and the load of the machine, and
whether the arrays of Python are the solver's own memory: the same address after each step, and no copy.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "inputs/bench_rest.toml"
OVERRIDES = {"domain.max": "[10.0,10.0,12.0]", "particles.0.max": "[10.0,10.0,10.0]"}
SCRIPT = """
import sys, trevi
solver = trevi.make_solver(trevi.read_scene(sys.argv[1], {overrides}))
for _ in range(int(sys.argv[2])):
    solver.step()
    view = solver.positions
    assert not view.flags.owndata and view.ctypes.data == solver.positions.ctypes.data
print(len(solver.positions), "particles; positions are a view of the solver's memory")
"""


def user_seconds(command, environment):
    """User CPU time of a command, and what it said."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        sys.exit(f"python_step.py: {' '.join(map(str, command))}: {result.stderr.strip()}")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, result.stdout.strip()


def cost_of_a_step(command_of, steps, environment):
    """ms, and what the longer run said."""
    short, _ = user_seconds(command_of(2), environment)
    long, said = user_seconds(command_of(steps + 2), environment)
    return 1000 * (long - short) / steps, said


def commands(build, folder):
    """For each name what runs a number of steps."""
    settings = [word for key, value in OVERRIDES.items() for word in ("--set", f"{key}={value}")]
    script = Path(folder) / "script.py"
    script.write_text(SCRIPT.format(overrides=repr({key: eval(value) for key, value in OVERRIDES.items()})))  # pylint: disable=eval-used
    number = iter(range(10**6))

    def program(steps):
        return [build / "trevi", SCENE, "--steps", str(steps), "--progress", "none", "--output",
                tempfile.mkdtemp(dir=folder), *settings]

    def python(steps):
        return ["/usr/bin/python3", script, SCENE, str(steps)]
    return {"program": program, "Python": python}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=ROOT / "build/release")
    parser.add_argument("--pairs", type=int, default=5, help="of runs (default %(default)s)")
    parser.add_argument("--steps", type=int, default=20, help="that are timed in each (default %(default)s)")
    options = parser.parse_args()
    environment = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(options.build / "python")}
    ratios, costs, said = [], {"program": [], "Python": []}, ""
    with tempfile.TemporaryDirectory() as folder:
        turn = list(commands(options.build, folder).items())
        for number in range(options.pairs):
            for name, command_of in turn if number % 2 == 0 else turn[::-1]:
                cost, said_now = cost_of_a_step(command_of, options.steps, environment)
                costs[name].append(cost)
                said = said_now or said
            ratios.append(costs["Python"][-1] / costs["program"][-1])
            print(f"program {costs['program'][-1]:7.1f} ms  Python {costs['Python'][-1]:7.1f} ms  ratio {ratios[-1]:.3f}  "
                  f"load {os.getloadavg()[0]:.1f}", flush=True)
    print(f"medians: program {statistics.median(costs['program']):.1f} ms, Python {statistics.median(costs['Python']):.1f} ms, "
          f"ratio {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f})\n{said}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

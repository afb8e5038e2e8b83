#!/usr/bin/python3
"""Whether two runs did the same to the last bit: particles of their last checkpoints, and the rows of series.csv.

The columns imbalance and wall_seconds do not count, as they are times. Exits 1 and says what differs.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from trevi_run import Run, RunError

NOT_STATE = {"imbalance", "wall_seconds"}


def rows_of_series(run):
    columns = {name: column.tolist() for name, column in run.series.items() if name not in NOT_STATE}
    return [dict(zip(columns, row)) for row in zip(*columns.values())]


def last_particles(run):
    if not run.checkpoints:
        sys.exit(f"same_bits.py: {run.directory}: has no checkpoint; run it with [output.checkpoint]")
    frame = run.checkpoints[-1]
    return {name: getattr(frame, name) for name in frame.fields}


def differences(a, b):
    """Lines that say where two runs differ; none for the same bits."""
    first, second = rows_of_series(a), rows_of_series(b)
    for number, (one, two) in enumerate(zip(first, second)):
        keys = [key for key in one if repr(one[key]) != repr(two.get(key))]  # as text, in which nan equals nan
        if keys or set(one) != set(two):
            yield f"series.csv row {number}: {', '.join(f'{k} {one[k]} and {two.get(k)}' for k in keys[:3])}"
            break
    if len(first) != len(second):
        yield f"series.csv has {len(first)} and {len(second)} rows"
    first, second = last_particles(a), last_particles(b)
    if set(first) != set(second):
        yield f"fields {sorted(first)} and {sorted(second)}"
    for name in sorted(set(first) & set(second)):
        one, two = first[name], second[name]
        if one.shape != two.shape:
            yield f"{name}: shapes {one.shape} and {two.shape}"
        elif one.tobytes() != two.tobytes():
            rows = np.flatnonzero((one != two).reshape(len(one), -1).any(axis=1))
            yield f"{name}: {len(rows)} of {len(one)} rows differ, the first is row {rows[0] if len(rows) else '?'}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("first", type=Path, help="folder of output with series.csv and checkpoint_*.h5")
    parser.add_argument("second", type=Path)
    arguments = parser.parse_args()
    try:
        found = list(differences(Run(arguments.first), Run(arguments.second)))
    except RunError as error:
        print(f"same_bits.py: {error}", file=sys.stderr)
        return 2
    print("\n".join(found) or "the same bits")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/python3
"""Whether two runs did the same to the last bit: particles of their last checkpoints, and the rows of series.csv.

The columns imbalance and wall_seconds do not count, as they are times. Exits 1 and says what differs.
"""

import argparse
import csv
import sys
from pathlib import Path

import h5py
import numpy as np

NOT_STATE = {"imbalance", "wall_seconds"}


def rows_of_series(folder):
    with open(folder / "series.csv", newline="") as file:
        return [{key: value for key, value in row.items() if key not in NOT_STATE} for row in csv.DictReader(file)]


def last_checkpoint(folder):
    return max(folder.glob("checkpoint_*.h5"), key=lambda path: int(path.stem.split("_")[1]))


def last_particles(folder):
    with h5py.File(last_checkpoint(folder)) as file:
        return {name: table[()] for name, table in file["particles"].items() if "checksum" not in name}


def differences(a, b):
    """Lines that say where two folders of output differ; none for the same bits."""
    first, second = rows_of_series(a), rows_of_series(b)
    for number, (one, two) in enumerate(zip(first, second)):
        if one != two:
            keys = [key for key in one if one[key] != two.get(key)]
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
    found = list(differences(arguments.first, arguments.second))
    print("\n".join(found) or "the same bits")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

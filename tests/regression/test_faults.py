#!/usr/bin/python3
"""Disks that are not well: a rename, fsync or write that fails at the n-th call, and an fsync that takes its time.

A failed call ends the run with 3 and a message that names the file; nothing half-written stays, and a restart from what
is there ends in the bits of a run that was left alone. usage: test_faults.py SHIM [CALLS], SHIM the library of
fault_shim.cpp, CALLS how many of each call are made to fail (default: the first and the sixth). The program: runs.py.
"""

import errno
import os
import re
import sys

import runs
from runs import CHECKPOINTS, CUBE, FRAMES, Folder

STEPS = 12
SOME = (1, 6)


def problems(code, told, output):
    found = [f"exit code {code}"] if code != 3 else []
    found += ["no file named"] if not re.search(r"trevi: .*/\S+: cannot", told) else []
    found += [f"left {path.name}" for path in output.rglob("*.tmp")]
    found += ["a signal"] if re.search("signal|Segmentation|terminate called", told) else []
    return found


def try_fault(folder, scene, straight, fault):
    """What went wrong, and whether the run failed: it may not come to the call, or do without, as with the sync of a
    folder."""
    output = folder.path(fault.replace(":", "_"))
    shim = {"LD_PRELOAD": sys.argv[1], "TREVI_FAULT": fault, "TREVI_FAULT_FOLDER": str(output),
            "TREVI_FAULT_ERRNO": str(errno.ENOSPC if fault.startswith(("write", "pwrite")) else errno.EIO)}
    code, told = runs.finish(runs.start(1, scene, output, "--steps", STEPS, extra=shim))
    reached = code != 0
    found = problems(code, told, output) if reached else []
    again, more = runs.run(2, scene, output, "--steps", STEPS, "--restart", "latest")
    found += [f"restart: exit code {again}: {more}"] if again != 0 else []
    found += runs.differences(straight, output) if again == 0 else []
    return [f"{fault}: {', '.join(found)}: {told.strip()}"] if found else [], reached


def main():
    failed, tried = [], 0
    calls = range(1, int(sys.argv[2]) + 1) if len(sys.argv) > 2 else SOME
    with Folder() as folder:
        scene = folder.scene(CUBE + FRAMES.replace("every_steps = 10", "every_steps = 5") + CHECKPOINTS.format(3, 2))
        straight = folder.path("straight")
        runs.run_well(1, scene, straight, "--steps", STEPS)
        for call in ("rename", "fsync", "pwrite", "write"):
            for number in calls:
                found, reached = try_fault(folder, scene, straight, f"{call}:{number}")
                failed += found
                tried += reached
        slow = folder.path("slow")
        extra = {"LD_PRELOAD": sys.argv[1], "TREVI_FAULT": "slow:20", "TREVI_FAULT_FOLDER": str(slow)}
        code, told = runs.finish(runs.start(2, scene, slow, "--steps", STEPS, extra=extra))
        failed += [f"slow: {told}"] if code != 0 or runs.differences(straight, slow) else []
    print("\n".join(failed))
    print(f"faults: {tried} calls failed, {len(failed)} not survived")
    return 1 if failed or not tried else 0


if __name__ == "__main__":
    os.environ.pop("LD_PRELOAD", None)
    sys.exit(main())

#!/usr/bin/python3
"""Disks that are not well, ranks that are lost at a chosen call of MPI, and clocks that jump.

A call on the disk that fails ends the run with 3 and a message that names the file; nothing half-written stays, and a
restart from what is there ends in the bits of a run that was left alone. So it does when a rank is lost wherever it is
in a step, and the other ranks end. A slow disk and a clock that jumps change nothing. The shim tells when it strikes: a
kind of fault that never struck, whatever the runs did, is a failure, too.
usage: test_faults.py SHIM [CALLS [KILLS]], SHIM the library of fault_shim.cpp, CALLS how many of each call on the disk
are made to fail (default: the first and the sixth), KILLS how many points of a run are those at which a rank is lost
(default 4). Without CALLS only two writers meet full and slow disks. The program: runs.py.
"""

import errno
import os
import re
import sys
import time
from pathlib import Path

import runs
from runs import CHECKPOINTS, CUBE, FRAMES, Folder

STEPS = 12
SOME = (1, 6)
# What stands in the path of the files of each writer.
WRITERS = ["checkpoint_", "series.csv", "obstacles.csv", "run.json", ".hdf"]
WRITERS += ["vtu/", "particles.pvd", "obstacles_"] if "VTK" not in runs.WITHOUT else []
OBSTACLE = """
[[obstacle]]
type = "sphere"
center = [0.8, 0.3, 0.2]
radius = 0.1
motion = [[0, 0.8, 0.3, 0.2], [1, 0.9, 0.3, 0.2]]
"""
STRIKE = r"fault: \S+ strikes trevi at (.*)"
MESSAGE = r"trevi: (rank \d+: )?.*/\S+: cannot"


class Faults:
    """Runs of one scene, each with a fault, compared with one that was left alone."""

    def __init__(self, folder):
        self.folder = folder
        self.scene = folder.scene(CUBE + OBSTACLE + FRAMES.replace("every_steps = 10", "every_steps = 5")
                                  + CHECKPOINTS.format(3, 2) + '[run]\nwall_limit = "1h"\n')
        self.straight = folder.path("straight")
        self.failed, self.struck = [], {}  # the latter: kind of fault -> [runs that it struck, runs]
        runs.run_well(1, self.scene, self.straight, "--steps", STEPS)

    def run(self, ranks, kind, fault, **more):
        """Exit code, what was told, where it struck (nothing: nowhere), and the folder of a run with a fault. Four
        ranks share two slabs."""
        shared = ["--set", "domain.ranks=[2, 2]"] if ranks == 4 else []
        output = self.folder.path(re.sub(r"[^a-z0-9_]", "_", f"{kind}_{fault}"))
        shim = {"LD_PRELOAD": sys.argv[1], "TREVI_FAULT": fault, "TREVI_FAULT_FOLDER": str(output),
                **{f"TREVI_FAULT_{key.upper()}": str(value) for key, value in more.items()}}
        code, told = runs.finish(runs.start(ranks, self.scene, output, "--steps", STEPS, *shared, extra=shim))
        strike = re.search(STRIKE, told)
        counts = self.struck.setdefault(kind, [0, 0])
        counts[0] += strike is not None
        counts[1] += 1
        return code, told, strike and strike[1], output

    def check(self, name, told, found, output):
        """The run went as it should but for what was found; a restart must end in the bits of a run left alone."""
        code, more = runs.run(2, self.scene, output, "--steps", STEPS, "--restart", "latest")
        found += runs.differences(self.straight, output) if code == 0 else [f"restart: exit code {code}: {more}"]
        self.failed += [f"{name}: {', '.join(found)}: {told.strip()}"] if found else []

    def disk(self, ranks, kind, fault, **more):
        """A run may end before its so-manieth call, and does without the sync of a folder and the words in the lock."""
        code, told, where, output = self.run(ranks, kind, fault, **more)
        endured = where is None or Path(where).is_dir() or where.endswith("run.lock")
        found = disk_problems(code, told, output) if code != 0 or not endured else []
        self.check(f"{kind} {fault} at {where}", told, found, output)

    def lose(self, ranks, call, rank):
        code, told, where, output = self.run(ranks, "a rank lost", f"kill:{call}", rank=rank)
        found = ["exit code 0"] if where and code == 0 else []
        end = time.monotonic() + 20
        while left_over(output) and time.monotonic() < end:
            time.sleep(0.05)
        found += [f"process {pid} lives on" for pid in left_over(output)]
        self.check(f"rank {rank} of {ranks}, lost at {where}", told, found, output)
        return where

    def never_struck(self):
        return [f"{kind}: never struck" for kind, (struck, _) in self.struck.items() if not struck]


def disk_problems(code, told, output):
    found = [f"exit code {code}"] if code != 3 else []
    found += ["no file named"] if not re.search(MESSAGE, told) else []
    found += [f"left {path.name}" for path in output.rglob("*.tmp")]
    found += ["a signal"] if re.search("signal|Segmentation|terminate called", told) else []
    return found


def left_over(output):
    """Processes of the program that write to a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0") if entry.name.isdigit() else []
        except OSError:  # gone meanwhile
            continue
        if words and words[0].endswith(b"/trevi") and str(output).encode() in words:
            found.append(int(entry.name))
    return found


def try_disks(faults, calls, writers):
    for call in ("rename", "fsync", "pwrite", "write"):
        error = errno.ENOSPC if "write" in call else errno.EIO
        for number in calls:
            faults.disk(1, call, f"{call}:{number}", errno=error)
    for writer in writers:
        faults.disk(2, f"no room for {writer}", "full:2", file=writer)
    # Once when it is made, and then with the first checkpoint, as a restart relies on its rows.
    for table in ("series.csv", "obstacles.csv"):
        faults.disk(1, f"{table} synced with a checkpoint", "fsync:2", file=table)


def try_delays(faults, writers):
    """Disks that take their time, and clocks that jump: nothing changes."""
    cases = [(f"slow {writer}", "slow:4", {"file": writer}) for writer in writers]
    for name, fault, more in [*cases, ("clock", "clock:7", {})]:
        code, told, _, output = faults.run(2, name, fault, **more)
        found = [f"exit code {code}"] if code != 0 else []
        seconds = runs.column(output, "wall_seconds") if code == 0 else []
        found += ["wall_seconds jump"] if seconds != sorted(seconds) or any(s > 3600 for s in seconds) else []
        faults.check(name, told, found, output)


def try_losses(faults, kills, ranks=3):
    """At calls that are spread over the run of a rank, each rank in turn; returns how often at which call."""
    told = faults.run(ranks, "calls counted", "calls:0")[1]
    del faults.struck["calls counted"]  # nothing happens there
    numbers = {int(rank): int(calls) for rank, calls in re.findall(r"rank (\d+): (\d+) calls of MPI", told)}
    assert len(numbers) == ranks, told
    reached = {}
    for k in range(kills):
        rank = k % ranks
        call = faults.lose(ranks, max(1, round((k + 0.5) / kills * numbers[rank])), rank)
        reached[call] = reached.get(call, 0) + 1
    return reached


def main():
    calls = range(1, int(sys.argv[2]) + 1) if len(sys.argv) > 2 else SOME
    writers = WRITERS if len(sys.argv) > 2 else WRITERS[:2]
    kills = int(sys.argv[3]) if len(sys.argv) > 3 else 4
    with Folder() as folder:
        faults = Faults(folder)
        try_disks(faults, calls, writers)
        try_delays(faults, writers)
        reached = [try_losses(faults, kills, ranks) for ranks in (3, 4)]
    for ranks, of_ranks in zip((3, 4), reached):
        print(f"of {ranks} ranks lost at", ", ".join(f"{call}: {n}" for call, n in sorted(of_ranks.items(), key=str)))
    print("runs struck:", ", ".join(f"{kind} {struck} of {tried}" for kind, (struck, tried) in faults.struck.items()))
    failed = faults.failed + faults.never_struck()
    print("\n".join(failed))
    print(f"faults: {sum(struck for struck, _ in faults.struck.values())} runs struck, {len(failed)} failures")
    return 1 if failed else 0


if __name__ == "__main__":
    os.environ.pop("LD_PRELOAD", None)
    sys.exit(main())

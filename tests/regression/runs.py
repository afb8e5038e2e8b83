"""Runs of the real program on small scenes, for the tests beside this file: start, wait, kill, compare.

Needs Python 3.8, numpy and h5py. The program and mpiexec come from the environment: TREVI (default
build/release/trevi of this project) and MPIEXEC (default mpirun).
"""

import os
import re
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import h5py
import numpy

from program import WITHOUT, with_instruction_set
from scenes import tank

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("TREVI", str(ROOT / "build/release/trevi"))
TREVI = str(with_instruction_set(PROGRAM))
MPIEXEC = os.environ.get("MPIEXEC", "mpirun")
TIMEOUT = 300  # s; a run of these tests takes a few, but sanitizers and busy machines are slow
RANK_DEPENDENT = {"imbalance", "wall_seconds"}
SETTINGS = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
}

# 576 particles in a box of eight planes: a step takes about a millisecond.
BOX = tank("1.6, 0.6, 1.6", ("{low}, 0.0, {height}", "{high}, 0.6, {top}")) + """
[tensile]
k = 0.001

[vorticity]
epsilon = 0.002

[viscosity]
c = 0.001

[output.series]
every_steps = 1
"""
CUBE = BOX.format(low=0.2, high=1.4, height=0.6, top=1.4)
JET = """
[[fountain]]
center = [0.8, 0.3]
diameter = 0.25
height = 0.2
speed = 5.0
jitter = 2.5
"""
FOUNTAIN = BOX.format(low=0.0, high=1.6, height=0.0, top=0.6) + JET
FLOW = BOX.format(low=0.0, high=1.6, height=0.0, top=0.6) + """
[[inlet]]
center = [0.4, 0.3, 1.2]
direction = [0.2, 0, -1]
radius = 0.15
speed = 3.0
jitter = 0.5
recycle = true
[[inlet]]
type = "rectangle"
center = [1.0, 0.3, 0.05]
size = [0.3, 0.2]
flow = 0.1
[[drain]]
min = [1.3, 0, 0.3]
max = [1.6, 0.6, 0.8]
"""  # an inlet that recycles and one that does not, and a drain
MUSIC = 'music = "score.txt"\nspeed_range = [3.0, 6.0]\n'  # to end a FOUNTAIN
SCORE = """# a second of notes
0 C4 0.2
0.25 E4 0.2
0.5 G4 0.3
"""
FRAMES = """
[colour]
by = "rainbow_x"

[output.vtkhdf]
every_steps = 10
fields = ["rgb", "id"]
"""
if "VTK" not in WITHOUT:
    FRAMES += """
[output.vtu]
every_steps = 10
fields = ["rgb"]
"""
CHECKPOINTS = """
[output.checkpoint]
every_steps = {}
keep = {}
"""


class Folder(tempfile.TemporaryDirectory):
    """A folder for the scene and the outputs of a test."""

    def __enter__(self):
        return self

    def path(self, name):
        return Path(self.name) / name

    def scene(self, text, name="scene.toml"):
        path = self.path(name)
        path.write_text(text)
        return path


def environment(extra=None):
    return {**os.environ, **SETTINGS, **(extra or {})}


def command(ranks, scene, output, *arguments):
    launch = [MPIEXEC, "-np", str(ranks)] if ranks > 1 else []
    return [*launch, TREVI, str(scene), "--output", str(output), "--progress", "none", *map(str, arguments)]


def start(ranks, scene, output, *arguments, extra=None):
    return subprocess.Popen(command(ranks, scene, output, *arguments), stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, env=environment(extra))


def finish(process):
    """Exit code and output; a run that hangs is killed and raises."""
    try:
        text, _ = process.communicate(timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    return process.returncode, text


def run(ranks, scene, output, *arguments):
    return finish(start(ranks, scene, output, *arguments))


def run_well(ranks, scene, output, *arguments):
    code, text = run(ranks, scene, output, *arguments)
    assert code == 0, f"exit code {code}: {text}"
    return text


def ranks_of(process, program="trevi"):
    """Process ids of the ranks below an mpirun, or of the program itself."""
    found, parents = [], {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            stat = (entry / "stat").read_text()
        except OSError:  # gone meanwhile
            continue
        name, rest = re.search(r"\((.*)\) (.*)", stat, re.S).groups()
        parents[int(entry.name)] = (int(rest.split()[1]), name)
    for pid, (parent, name) in parents.items():
        if name == program and (pid == process.pid or parent == process.pid):
            found.append(pid)
    return sorted(found)


class EndedBefore(AssertionError):
    """A run ended before what was waited for."""


def wait_for(condition, process, what):
    """Waits until condition() holds; fails when the run ends first."""
    end = time.monotonic() + TIMEOUT
    while not condition():
        if process.poll() is not None and not condition():  # which may have come true with the end
            raise EndedBefore(f"the run ended before {what}")
        if time.monotonic() > end:
            process.kill()
            raise AssertionError(f"waited in vain for {what}")
        time.sleep(0.0005)


def wait_for_row(output, row, process):
    series = Path(output) / "series.csv"
    wait_for(lambda: series.exists() and series.read_text().count("\n") > row, process, f"row {row} of the series")


def kill_one(process, which):
    """kill -9 of one rank; False when the run was over already."""
    ranks = ranks_of(process)
    if not ranks:
        return False
    try:
        os.kill(ranks[which % len(ranks)], signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def particles(checkpoint):
    """Everything in a checkpoint but the time it took, as bytes."""
    with h5py.File(checkpoint, "r") as file:
        content = {f"{group}/{name}": numpy.array(file[group][name]).tobytes()
                   for group in ("particles", "checksums") for name in file[group]}
        content.update({name: bytes(numpy.array(value).tobytes()) for name, value in file.attrs.items()
                        if name != "wall_seconds"})
    return content


def rows(output):
    """series.csv without the columns that depend on the ranks."""
    table = [line.split(",") for line in (Path(output) / "series.csv").read_text().splitlines()]
    keep = [k for k, name in enumerate(table[0]) if name not in RANK_DEPENDENT]
    return [[row[k] for k in keep] for row in table]


def column(output, name):
    table = [line.split(",") for line in (Path(output) / "series.csv").read_text().splitlines()]
    place = table[0].index(name)
    return [float(row[place]) for row in table[1:]]


def last_step(output):
    return int(column(output, "step")[-1])


def last_checkpoint(output):
    return sorted(Path(output).glob("checkpoint_*.h5"))[-1]


def differences(one, other):
    """What differs between the results of two runs; empty when they are the same bits."""
    found = []
    first, second = particles(last_checkpoint(one)), particles(last_checkpoint(other))
    names = first.keys() | second.keys()
    # Scenes may differ in what a restart may change.
    found += [name for name in sorted(names - {"scene_checksum", "scene_overrides"}) if first.get(name) != second.get(name)]
    found += ["series.csv"] if rows(one) != rows(other) else []
    for name in ("obstacles.csv", "particles.pvd", "particles.hdf.series", "obstacles.vtp.series"):
        texts = [path.read_text() if path.exists() else "" for path in (Path(one) / name, Path(other) / name)]
        found += [name] if texts[0] != texts[1] else []
    return found

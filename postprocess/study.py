"""What the studies share: arguments, a scene run with some keys set, and the figures of its series.csv. No program of its
own."""

import argparse
import csv
import os
import shlex
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from itertools import accumulate
from pathlib import Path

import h5py

import trevi_run

ROOT = Path(__file__).resolve().parents[1]
STRESS = ROOT / "inputs" / "stress"
GRAVITY = 9.8  # m/s²
REPORT = ["density.preset=report"]
PLAIN_JACOBI = ["density.method=jacobi", "density.relaxation=1.0", "density.constraint=equality", "walls.density=none"]
MPI_SETTINGS = {"OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
                "OMP_NUM_THREADS": os.environ.get("OMP_NUM_THREADS", "1")}  # as several runs share the machine


def parser_of(description, written):
    """Arguments that all studies have: the file to write, of the kind that is told, and the program."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path, help=f"{written} file to write")
    parser.add_argument("--trevi", type=Path, default=ROOT / "build/release/trevi")
    return parser


def launch(trevi, scene, output, settings, time_limit):
    """Exit code and message of a run into the folder `output`; exit code None: the limit was met."""
    command = [str(trevi), str(scene), "--output", str(output), "--progress", "none"]
    for setting in settings:
        command += ["--set", setting]
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=time_limit, check=False,
                                env={**os.environ, **MPI_SETTINGS})
        return result.returncode, result.stderr.strip()
    except subprocess.TimeoutExpired:
        return None, f"stopped after {time_limit} s: {shlex.join(command)}"


def simulate(trevi, scene, settings=(), time_limit=120, cloud=None):
    """Columns of series.csv by name, as lists of float, and what launch() tells. cloud: positions (m) and velocities (m/s)
    to start with, arrays of N x 3, in place of the scene's own particles."""
    columns, _, code, message = simulate_states(trevi, scene, settings, time_limit, cloud)
    return columns, code, message


def simulate_states(trevi, scene, settings=(), time_limit=120, cloud=None):
    """The same, and after the columns the positions and velocities of each checkpoint the run has left, in their order."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "run"
        code, message = launch(trevi, scene, output, [*settings, *start_of(cloud, folder)], time_limit)
        return columns_of(output / "series.csv"), states_of(output), code, message


def start_of(cloud, folder):
    """The setting by which a run starts with this cloud, which is written to the folder."""
    if cloud is None:
        return []
    file = Path(folder) / "start.h5"
    with h5py.File(file, "w") as stream:
        stream["particles/position"], stream["particles/velocity"] = cloud
    return [f'particles=[{{type="file",path="{file}"}}]']


def states_of(output):
    return [(state.position, state.velocity) for state in trevi_run.Run(output).checkpoints] if output.is_dir() else []


def in_turn(work, cases, jobs=1):
    """work(case) of each, in their order, as they are done, `jobs` at a time. A study goes through its cases by this, or by
    the one below, and makes one run in each, so that ctest `studies` can ask whether all their scenes are well."""
    if jobs == 1:
        yield from map(work, cases)
        return
    with ThreadPoolExecutor(jobs) as workers:
        yield from workers.map(work, cases)


def two_at_a_time(work, cases):
    """For runs that nobody times."""
    yield from in_turn(work, cases, 2)


def columns_of(file):
    """Of a table of a run, lists of float by name; none where a run that failed has not written it."""
    return {name: column.tolist() for name, column in trevi_run.Table(file).items()} if file.exists() else {}


def mean(values):
    return sum(values) / len(values) if values else float("nan")


def energies(columns):
    return [k + p for k, p in zip(columns["kinetic_energy"], columns["potential_energy"])]


def largest_rise(energy):
    """Above its lowest so far, of an energy that should never rise."""
    return max(now - lowest for now, lowest in zip(energy, accumulate(energy, min)))


def mass_of(columns, spacing=0.1, rest_density=1000.0):
    """kg in all, by the volume of the lattice; a calibrated mass differs by the few per cent the kernel's sum does."""
    return columns["particles"][0] * rest_density * spacing**3


def energy_gain(columns, spacing=0.1, gravity=GRAVITY):
    """The highest rise of the total energy above its start, as a share of max(E0, m g h N), h twice the spacing."""
    energy = energies(columns)
    scale = max(abs(energy[0]), mass_of(columns, spacing) * gravity * 2 * spacing)
    return (max(energy) - energy[0]) / scale


def write_as_found(path, rows_of, cases):
    """A table of the rows of all cases, which are printed as they are found, two cases at a time."""
    rows = []
    for some in two_at_a_time(rows_of, cases):
        rows += some
        for row in some:
            print(*row.values(), sep=", ", flush=True)
    write_table(path, rows)


def write_table(path, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)

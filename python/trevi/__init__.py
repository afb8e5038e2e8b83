"""Water by position based fluids, from Python.

    import trevi
    scene = trevi.read_scene("inputs/fountain_small.toml", {"time.end": 2})
    solver = trevi.make_solver(scene)
    solver.run()
    print(solver.positions.mean(axis=0))

Under mpirun every rank (trevi.rank of trevi.size) runs the same script and makes the same calls; arrays are those of
this rank, and solver.gather_positions() has them all, by id, on rank 0. Bits are those of the program `trevi` on any
ranks and threads.
Units are SI; names and defaults are those of the scene file (inputs/README.md). Errors are InputError (a ValueError),
RunError (a RuntimeError) and BlowUp (a RunError), raised on all ranks alike.
"""

import contextlib
import hashlib
import json
import math
import operator
import os
import sys
import time

# Threads that wait for each other spin this often and then sleep; read when the library of threads is loaded.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

from trevi._trevi import (  # noqa: E402
    BlowUp, BodySettings, Box, CheckpointSettings, Colour, Constraint, DampingSettings, DensitySettings,
    DrainSettings, DrainShape, FluidSettings, Follow, FountainSettings, FrameContent, FrameFormat,
    FrameSetSettings, FrameSettings, GaugeKind, GaugeSettings, InletSettings, InletShape, InputError, Mass,
    Method, Mooring, MusicKind, MusicSettings, ObstacleSettings, Oscillation, OutputSettings, PaddleKind,
    Precision, Reflection, RunError, Scene, Schedule, Settings, Shape, SlabCuts, Solver, SpeedMapping,
    TensileSettings, TriangleMesh, VorticityForm, WallDensity, WallSettings, WaveKind, WaveSpectrum,
    WavemakerSettings, __version__, _make_solver, _read_scene, paddle_of, rank, read_mesh, report_settings, size,
    threads, use_threads)

__all__ = [
    "BlowUp", "BodySettings", "Box", "CheckpointSettings", "Colour", "Constraint", "DampingSettings",
    "DensitySettings", "DrainSettings", "DrainShape", "FluidSettings", "Follow", "FountainSettings",
    "FrameContent", "FrameFormat", "FrameSetSettings", "FrameSettings", "GaugeKind", "GaugeSettings",
    "InletSettings", "InletShape", "InputError", "Mass", "Method", "Mooring", "MusicKind", "MusicSettings",
    "ObstacleSettings", "Oscillation", "OutputSettings", "PaddleKind", "Precision", "Reflection", "RunError",
    "Scene", "Schedule", "Settings", "Shape", "SlabCuts", "Solver", "SpeedMapping", "TensileSettings",
    "TriangleMesh", "VorticityForm", "WallDensity", "WallSettings", "WaveKind", "WaveSpectrum",
    "WavemakerSettings", "__version__", "make_solver", "paddle_of", "rank", "read_mesh", "read_scene",
    "report_settings", "size", "threads", "use_threads"]


def _toml(value):
    """A value as a scene file would have it."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist") and getattr(value, "ndim", 0):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value))
    if hasattr(value, "item"):  # of numpy
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)


def _fields(kind):
    return [name for name in dir(kind) if isinstance(getattr(kind, name), property)]


def _plain(value):
    """What a value consists of, as numbers and texts."""
    if hasattr(value, "tobytes"):  # of numpy; a mesh may have millions of points
        return hashlib.blake2b(value.tobytes()).hexdigest() if value.ndim else value.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if hasattr(value, "__iter__"):
        return [_plain(one) for one in value]
    return [(name, _plain(getattr(value, name))) for name in _fields(type(value))]


def _marks(settings, rows):
    """A number for each part of what must be the same on all ranks, by its name."""
    if size == 1 or not isinstance(settings, Settings):
        return []
    parts = [("settings", type(settings).__name__), ("rows", _plain(rows))]
    parts += [(f"settings.{name}", _plain(getattr(settings, name))) for name in _fields(Settings)]
    return [(name, int.from_bytes(hashlib.blake2b(repr(part).encode(), digest_size=7).digest(), "big"))
            for name, part in parts]


def read_scene(path, overrides=None, comm=None):
    """Reads and checks a scene file. `overrides`: values for "table.key", as --set of the program takes them.
    InputError with every problem of the file, a line each. Collective."""
    return _read_scene(os.fspath(path), [f"{key}={_toml(value)}" for key, value in (overrides or {}).items()], comm)


def make_solver(settings, positions=None, velocities=None, ids=None, *, forcings=(), rows=None, comm=None):
    """A solver for a Scene, or for Settings and particles of one's own, before its first step. It writes the files of
    settings.output where that has a directory; solver.close(), or the end of the script, ends them. Collective:
    settings and rows are the same on all ranks.

    positions, velocities: arrays (n, 3) of this rank, any part of the whole, in m and m/s; a Scene has its own where
    they are None. ids: whole numbers from 0 and below 2**62, unique over all ranks; None: consecutive. forcings:
    callables f(water, step), called once a substep on each rank to change water.velocities; one that may push faster
    than the water goes should have an attribute `fastest`, m/s, for the choice of substeps. rows: keeps a row of
    solver.series, forces and gauges every so many steps; None: as settings.output.series says. comm: of mpi4py; None:
    all ranks. InputError on all ranks for what is wrong on any.
    """
    return _make_solver(settings, positions, velocities, ids, forcings, rows, comm, _marks(settings, rows))


class _Progress:
    """A line on the terminal of rank 0, at most four times a second."""

    def __init__(self, solver, last, shown):
        self.solver, self.first, self.last, self.begun, self.shown = solver, solver.steps, last, time.time(), 0.0
        self.visible = solver.rank == 0 and (sys.stderr.isatty() if shown is None else shown)

    def show(self):
        done, now = self.solver.steps - self.first, time.time()
        if not self.visible or (self.solver.steps < self.last and now - self.shown < 0.25):
            return
        self.shown = now
        total = self.last - self.first
        bar = "#" * (30 * done // total)
        left = (now - self.begun) / done * (total - done)
        end = "\n" if done == total else ""
        print(f"\r{self.solver.time:8.3f} s [{bar:30}] {done}/{total}, {left:.0f} s left ", end=end, file=sys.stderr,
              flush=True)


def _fits(test, number):
    try:
        return test(number)
    except TypeError:
        return False


def _steps_asked_for(self, until, steps):
    """InputError for what is no number of steps, or no time."""
    if steps is None:
        end = self._end if until is None else until
        if end is None:
            raise InputError("run(): give until or steps, as settings have no end")
        if not _fits(lambda time: math.isfinite(time / self.dt), end):
            raise InputError("run(): until must be a time, s")
        return max(0, round(end / self.dt) - self.steps)
    if not _fits(lambda number: operator.index(number) >= 0, steps):
        raise InputError("run(): steps must be a whole number from 0 on")
    return operator.index(steps)


def _agreed_steps(self, until, steps):
    """The same on all ranks; InputError on all of them otherwise."""
    try:
        steps = min(_steps_asked_for(self, until, steps), 2**62)  # an integer of MPI
    except InputError:
        self._agree(1)
        raise
    if self._agree(0):
        raise InputError("run(): until or steps are wrong on another rank")
    if -self._agree(-steps) != self._agree(steps):
        raise InputError("run(): until or steps differ between ranks; give the same on all of them")
    return steps


def _stops(self, callback, line):
    """Whether the callback of any rank says so. Its exception on one rank is a RunError on the others."""
    try:
        line.show()
        stops = 1 if callback is not None and callback(self) else 0
    except BaseException:
        self._agree(2)
        raise
    stops = self._agree(stops)
    if stops == 2:
        raise RunError("run(): the callback failed on another rank")
    return stops == 1


def _run(self, until=None, *, steps=None, callback=None, progress=None):
    """Steps until that time, s (of a Scene its end where None), or for so many steps. callback(solver) after each step;
    where it returns true on any rank the run ends on all. Its exception on one rank is a RunError on the others.
    progress: a bar; None: on a terminal. Collective."""
    self._refuse_within("run()")
    steps = _agreed_steps(self, until, steps)
    line = _Progress(self, self.steps + steps, progress)
    for _ in range(steps):
        self.step()
        if _stops(self, callback, line):
            break
    return self


@contextlib.contextmanager
def _change(self):
    """Within `with solver.change():` positions, velocities and ids may be written to, or replaced by arrays of another
    length; the solver takes them over at the end of the block, and arrays of the block are read-only from then on.
    Where the block fails on any rank nothing is changed, and the others have a RunError. Collective: all ranks, also
    those that change nothing."""
    self._begin_change()
    try:
        yield self
    except BaseException:
        self._end_change(False)
        raise
    self._end_change(True)


Solver.run = _run
Solver.change = _change

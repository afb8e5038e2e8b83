"""Water by position based fluids, from Python.

    import trevi
    scene = trevi.read_scene("inputs/fountain_small.toml", {"time.end": 2})
    solver = trevi.make_solver(scene)
    solver.run()
    print(solver.positions.mean(axis=0))

Under mpirun every rank (trevi.rank of trevi.size) runs the same script and makes the same calls; arrays are those of this rank, and
solver.gather_positions() has them all, by id, on rank 0. Bits are those of the program `trevi` on any ranks and threads.
Units are SI; names and defaults are those of the scene file (inputs/README.md). Errors are InputError (a ValueError),
RunError (a RuntimeError) and BlowUp (a RunError), raised on all ranks alike.
"""

import contextlib
import json
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
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value.item() if hasattr(value, "item") else value)


def read_scene(path, overrides=None, comm=None):
    """Reads and checks a scene file. `overrides`: values for "table.key", as --set of the program takes them. Collective.
    InputError with every problem of the file, a line each."""
    return _read_scene(os.fspath(path), [f"{key}={_toml(value)}" for key, value in (overrides or {}).items()], comm)


def make_solver(settings, positions=None, velocities=None, ids=None, *, forcings=(), rows=None, comm=None):
    """A solver for a Scene, or for Settings and particles of one's own, before its first step. Collective. It writes the
    files of settings.output where that has a directory; solver.close(), or the end of the script, ends them.

    positions, velocities: arrays (n, 3) of this rank, any part of the whole, in m and m/s; a Scene has its own where
    they are None. ids: unique over all ranks; None: consecutive. forcings: callables f(water, step), called once a
    substep on each rank to change water.velocities; one that may push faster than the water goes should have an
    attribute `fastest`, m/s, for the choice of substeps. rows: keeps a row of solver.series, forces and gauges every so
    many steps; None: as settings.output.series says. comm: of mpi4py; None: all ranks.
    """
    return _make_solver(settings, positions, velocities, ids, list(forcings), rows, comm)


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
        print(f"\r{self.solver.time:8.3f} s [{bar:30}] {done}/{total}, {left:.0f} s left ", end=end, file=sys.stderr, flush=True)


def _run(self, until=None, *, steps=None, callback=None, progress=None):
    """Steps until that time, s (of a Scene its end where None), or for so many steps. callback(solver) after each step;
    where it returns true, on all
    ranks alike, the run ends. progress: a bar; None: on a terminal. Collective."""
    if steps is None:
        end = self._end if until is None else until
        if end is None:
            raise InputError("run(): give until or steps, as settings have no end")
        steps = max(0, round(end / self.dt) - self.steps)
    line = _Progress(self, self.steps + steps, progress)
    for _ in range(steps):
        self.step()
        line.show()
        if callback is not None and callback(self):
            break
    return self


@contextlib.contextmanager
def _change(self):
    """Within `with solver.change():` positions, velocities and ids may be written to, or replaced by arrays of another
    length; the solver takes them over at the end of the block. Collective: all ranks, also those that change nothing."""
    self._begin_change()
    try:
        yield self
    except BaseException:
        self._end_change(False)
        raise
    self._end_change(True)


Solver.run = _run
Solver.change = _change

#!/usr/bin/python3
"""Reads what a run has written, as numpy arrays. No program of its own; needs numpy, and h5py for VTKHDF frames and
checkpoints.

  from trevi_run import Run

  run = Run("out/fountain")
  run.series["time"], run.series["kinetic_energy"]   # columns of series.csv; obstacles, bodies and gauges likewise
  len(run.frames), run.frames.times                  # frames of [output.vtu], else of [output.vtkhdf]
  run.frames[3].position, run.frames[-1].velocity    # of a frame by its number; sorted by id where that was written
  run.frames.at(1.5).density                         # of the frame nearest a time, s
  run.frame_sets["0"][3].position                    # of [[output.frames]], by name; of cells .fraction[i, j, k]
  run.checkpoints[-1].position                       # checkpoints have the same interface
  run.frames[3].to_vtk(), run.frames[3].solids_to_vtk()   # for VTK, and by pyvista.wrap() for PyVista
  run.scene["fluid"]["spacing"], run.report          # the scene with its --set, and run.json

Files are read when they are asked for. Whatever cannot be read is a RunError that names the file. Only to_vtk() and
solids_to_vtk() need VTK's Python modules.
"""

import bisect
import csv
import importlib
import json
import re
import xml.etree.ElementTree as xml
import zlib
from functools import cached_property
from pathlib import Path

import numpy as np

TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1"}


class RunError(Exception):
    """A run, or a part of it, that is not there or cannot be read."""


class Table(dict):
    """Columns of a CSV file by their names, float64. A row that a run is still writing, without the end of its line, is
    left out."""

    def __init__(self, path):
        try:
            text = Path(path).read_text(encoding="utf-8")
        except (OSError, ValueError) as error:
            raise RunError(f"{path}: {error}") from error
        names, *rows = [row for row in csv.reader(text[:text.rfind("\n") + 1].splitlines()) if row] or [[]]
        if not names:
            raise RunError(f"{path}: is empty")
        try:
            columns = np.array(rows, float).reshape(len(rows), len(names)).T
        except ValueError as error:
            raise RunError(f"{path}: a row is not {len(names)} numbers ({error})") from error
        super().__init__(zip(names, columns))


class Frame:
    """The particles at a time. `fields` are the names that it has; each is an attribute, too: position, velocity (m/s),
    density (kg/m³), id, rgb, rank, hue. `solids` are the files with the surfaces of obstacles and bodies: those that
    stay, then those that move.

    A frame of cells has fraction, velocity and density, as they were asked for, of shape (x, y, z) or (x, y, z, 3), at
    the points origin + spacing * (i, j, k), m."""

    def __init__(self, path, time, read, solids=()):
        self.path, self.time, self.solids, self._read = path, time, tuple(solids), read

    def __repr__(self):
        return f"Frame({str(self.path)!r}, time={self.time:.6g})"

    @cached_property
    def _arrays(self):
        try:
            arrays = self._read(self.path)
        except RunError:
            raise
        except Exception as error:  # whatever a damaged file makes of a parser
            raise RunError(f"{self.path}: {error}") from error
        if "id" in arrays:  # which no cells have
            order = np.argsort(arrays["id"], kind="stable")
            arrays = {name: values[order] for name, values in arrays.items()}
        return arrays

    @property
    def fields(self):
        return tuple(self._arrays)

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in self._arrays:
            raise AttributeError(f"{self.path} has no {name}; it has {', '.join(self.fields)}")
        return self._arrays[name]

    def __len__(self):
        if "position" in self._arrays:
            return len(self.position)
        return int(np.prod(next(iter(self._arrays.values())).shape[:3]))

    def to_vtk(self):
        """A vtkPolyData with a vertex for each particle, or a vtkImageData of cells, with the fields as arrays."""
        numpy_to_vtk = _vtk("util.numpy_support").numpy_to_vtk
        arrays = dict(self._arrays)
        if "position" in arrays:
            data = _vertices(arrays.pop("position"))
        else:
            data, shape = _grid(arrays.pop("origin"), arrays.pop("spacing"), next(iter(arrays.values())).shape[:3])
            arrays = {name: np.swapaxes(values, 0, 2).reshape(np.prod(shape), *values.shape[3:])
                      for name, values in arrays.items()}
        for name, values in arrays.items():
            array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
            array.SetName(name)
            data.GetPointData().AddArray(array)
        return data

    def solids_to_vtk(self):
        """The surfaces of obstacles and bodies as one vtkPolyData, whose cells have their numbers, `obstacle`."""
        together = _vtk("vtkFiltersCore").vtkAppendPolyData()
        for path in self.solids:
            reader = _vtk("vtkIOXML").vtkXMLPolyDataReader()
            reader.SetFileName(str(path))
            together.AddInputConnection(reader.GetOutputPort())
        if self.solids:
            together.Update()
        return together.GetOutput()


class Frames:
    """Frames in the order of time: by number, as slices, in loops, or the one nearest a time."""

    def __init__(self, frames):
        self._frames = sorted(frames, key=lambda frame: frame.time)
        self.times = np.array([frame.time for frame in self._frames])

    def __len__(self):
        return len(self._frames)

    def __getitem__(self, number):
        return self._frames[number]

    def at(self, time):
        if not self._frames:
            raise RunError("the run has no such frames; add [output.vtu], [output.vtkhdf] or [output.checkpoint]")
        after = min(max(bisect.bisect(self.times, time), 1), len(self) - 1) if len(self) > 1 else 0
        return min(self._frames[max(after - 1, 0):after + 1], key=lambda frame: abs(frame.time - time))


class Run:
    """What is in the directory of a run."""

    def __init__(self, directory):
        self.directory = Path(directory)
        if not self.directory.is_dir():
            raise RunError(f"{self.directory}: no such directory")

    @cached_property
    def report(self):
        """run.json; there when the run has ended."""
        return _json(self.directory / "run.json")

    @cached_property
    def scene(self):
        """The tables of the scene as dicts, --set included; from a checkpoint, else from the file that run.json names."""
        if len(self.checkpoints):
            text = _scene_of_checkpoint(self.checkpoints[-1].path)
        else:
            path = Path(self.report["scene"])
            try:
                text = path.read_text()
            except OSError as error:
                raise RunError(f"{path}: {error}; the run has no checkpoint with its scene") from error
        return scene_of(text)

    @cached_property
    def series(self):
        return Table(self.directory / "series.csv")

    @cached_property
    def obstacles(self):
        return Table(self.directory / "obstacles.csv")

    @cached_property
    def bodies(self):
        return Table(self.directory / "bodies.csv")

    @cached_property
    def gauges(self):
        return Table(self.directory / "gauges.csv")

    @cached_property
    def frames(self):
        """Those of [output.vtu], else of [output.vtkhdf]; none where the run has neither."""
        return self.vtu if len(self.vtu) else self.vtkhdf

    @cached_property
    def vtu(self):
        return _vtu_frames(self.directory)

    @cached_property
    def vtkhdf(self):
        return _hdf_frames(self.directory, "particles.hdf.series", _read_vtkhdf)

    @cached_property
    def frame_sets(self):
        """The frames of each of [[output.frames]] by its name, which by default is its number in the scene."""
        sets = {}
        for folder in sorted(self.directory.glob("frames_*")):
            if folder.is_dir():
                found = (_vtu_frames(folder), _hdf_frames(folder, "particles.hdf.series", _read_vtkhdf),
                         _hdf_frames(folder, "cells.hdf.series", _read_cells))
                sets[folder.name.removeprefix("frames_")] = max(found, key=len)
        return sets

    @cached_property
    def checkpoints(self):
        return Frames([Frame(path, _time_of_checkpoint(path), _read_checkpoint)
                       for path in sorted(self.directory.glob("checkpoint_*.h5"))])


def _vtu_frames(directory):
    index, entries = directory / "particles.pvd", {}
    if not index.exists():
        return Frames([])
    try:
        for entry in xml.parse(index).getroot().iter("DataSet"):
            entries.setdefault(float(entry.get("timestep")), {})[entry.get("part")] = entry.get("file")
    except (xml.ParseError, TypeError, ValueError) as error:
        raise RunError(f"{index}: {error}") from error
    return Frames([Frame(directory / files["0"], time, _read_pvtu,
                         [directory / files[part] for part in sorted(files) if part != "0"])
                   for time, files in entries.items()])


def _hdf_frames(directory, name, read):
    index = directory / name
    if not index.exists():
        return Frames([])
    moving, stays = directory / "obstacles.vtp.series", directory / "obstacles.vtp"
    moving = {entry["time"]: entry["name"] for entry in _json(moving)["files"]} if moving.exists() else {}
    return Frames([Frame(directory / entry["name"], entry["time"], read,
                         ([stays] if stays.exists() else [])
                         + ([directory / moving[entry["time"]]] if entry["time"] in moving else []))
                   for entry in _json(index)["files"]])


def scene_of(text):
    """The tables of a scene's text, which ends with a line `# --set table.key=value` for each override."""
    import tomllib  # pylint: disable=import-outside-toplevel  # Python 3.11; all else reads with older ones
    scene = tomllib.loads(text)
    for path, value in re.findall(r"^# --set ([^=\n]+)=(.*)$", text, re.MULTILINE):
        *tables, key = path.strip().split(".")
        try:
            value = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            pass  # a bare word is text
        place = scene
        for table in tables:
            place = place[int(table)] if isinstance(place, list) else place.setdefault(table, {})
        if isinstance(place, list):
            place[int(key)] = value
        else:
            place[key] = value
    return scene


def _vtk(module):
    try:
        return importlib.import_module("vtkmodules." + module)
    except ImportError as error:
        raise RunError(f"VTK's objects need its Python modules, the Debian package python3-vtk9 ({error})") from error


def _vertices(position):
    """A vtkPolyData of points and nothing else."""
    arrays, model = _vtk("util.numpy_support"), _vtk("vtkCommonDataModel")
    data, points, vertices = model.vtkPolyData(), _vtk("vtkCommonCore").vtkPoints(), model.vtkCellArray()
    points.SetData(arrays.numpy_to_vtk(np.ascontiguousarray(position), deep=True))
    numbers = np.arange(len(position) + 1, dtype=np.int64)
    vertices.SetData(*(arrays.numpy_to_vtkIdTypeArray(part, deep=True) for part in (numbers, numbers[:-1])))
    data.SetPoints(points)
    data.SetVerts(vertices)
    return data


def _grid(origin, spacing, shape):
    data = _vtk("vtkCommonDataModel").vtkImageData()
    data.SetOrigin(*map(float, origin))
    data.SetSpacing(*map(float, spacing))
    data.SetDimensions(*map(int, shape))
    return data, shape


def _json(path):
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise RunError(f"{path}: {error}") from error


def _hdf5(path):
    try:
        import h5py  # pylint: disable=import-outside-toplevel
    except ImportError as error:
        raise RunError(f"{path}: needs h5py, the Debian package python3-h5py") from error
    try:
        return h5py.File(path)
    except OSError as error:
        raise RunError(f"{path}: {error}") from error


def _read_checkpoint(path):
    with _hdf5(path) as file:
        return {name: values[:] for name, values in file["particles"].items()}


def _time_of_checkpoint(path):
    with _hdf5(path) as file:
        return float(file.attrs["time"])


def _scene_of_checkpoint(path):
    with _hdf5(path) as file:
        return file["scene"][()].decode()


def _read_vtkhdf(path):
    with _hdf5(path) as file:
        data = file["VTKHDF"]
        return {"position": data["Points"][:], **{name: values[:] for name, values in data["PointData"].items()}}


def _read_cells(path):
    with _hdf5(path) as file:
        data = file["VTKHDF"]
        arrays = {name: np.swapaxes(values[:], 0, 2) for name, values in data["PointData"].items()}
        return arrays | {"origin": data.attrs["Origin"], "spacing": data.attrs["Spacing"]}


def _read_pvtu(path):
    pieces = [_read_vtu(path.parent / piece.get("Source")) for piece in xml.parse(path).getroot().iter("Piece")]
    return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}


def _read_vtu(path):
    """The arrays of points of a file as VTK's writer makes it: appended raw blocks, with zlib or without."""
    data = path.read_bytes()
    start = data.index(b"<AppendedData")
    start = data.index(b"_", start)
    root = xml.fromstring(data[:start].rsplit(b"<AppendedData", 1)[0] + b"</VTKFile>")
    if root.get("byte_order") != "LittleEndian" or root.get("header_type") != "UInt64":
        raise RunError(f"{path}: not as Trevi writes it")
    arrays = {}
    for section in ("Points", "PointData"):
        for array in root.find(f".//{section}"):
            raw = _block(data, start + 1 + int(array.get("offset")), root.get("compressor"))
            values = np.frombuffer(raw, TYPES[array.get("type")])
            components = int(array.get("NumberOfComponents") or 1)
            arrays["position" if section == "Points" else array.get("Name")] = (
                values.reshape(-1, components) if components > 1 else values)
    return arrays


def _block(data, offset, compressor):
    """Header without a compressor: bytes; with one: blocks, their size, that of the last, and compressed sizes."""
    def header(n):
        return np.frombuffer(data, "<u8", n, offset)
    if not compressor:
        size = int(header(1)[0])
        return data[offset + 8:offset + 8 + size]
    blocks = int(header(1)[0])
    sizes = header(3 + blocks)[3:]
    begin = offset + 8 * (3 + blocks)
    parts = []
    for size in map(int, sizes):
        parts.append(zlib.decompress(data[begin:begin + size]))
        begin += size
    return b"".join(parts)

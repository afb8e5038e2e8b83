#!/usr/bin/python3
"""The pages inputs/README.md and postprocess/README.md against the program.

Every key, type and default of a scene, every column, key, dataset, attribute and file that a run writes is in a row of
their tables, and no row names what is not there. Defaults are compared with tests/scene/scene_defaults.hpp, which a unit
test compares with the program's scene, and written out in runs that must give the same bits as those without them.
"""

import csv
import itertools
import json
import math
import os
import re
import signal
import subprocess
import tempfile
import time
from collections import namedtuple
from pathlib import Path

import h5py
from program import MPI_SETTINGS, TIME_LIMIT, WITHOUT, ProgramTest, main
from scenes import tank

ROOT = Path(__file__).resolve().parents[2]
TIMES = ("imbalance", "wall_seconds")
# Files that a run removes before it ends, and those that only a viewer and a removed folder bring about.
ONLY_ON_THE_WAY = {"run.lock", "stop", "*.tmp", "view.key", "DIR.rescued/"}

SCENE = """body = [{type = "torus", center = [0.8, 0.4, 0.5], radius = 0.2, tube = 0.1, density = 400}]
gauge = [{type = "height", center = [0.8, 0.4, 0]}, {type = "height", center = [0.4, 0.4, 0]},
         {type = "pressure", center = [0.3, 0.4, 0.2], normal = [1, 0, 0]}, {type = "velocity", center = [0.8, 0.4, 0.2]},
 {type = "flow", center = [0.8, 0.4, 0.2], size = [1, 1], normal = [1, 0, 0]}, {type = "run_up", center = [0, 0.4, 0], normal = [1, 0, 0]}]
""" + tank("1.6, 0.8, 2.4", ("0, 0, 0", "1.6, 0.8, 0.4"), ("0.4, 0.2, 0.8", "0.8, 0.6, 1.2")) + """
[[fountain]]
center = [1.2, 0.4]
[[obstacle]]
type = "box"
center = [0.2, 0.4, 0.3]
size = [0.2, 0.2, 0.4]
[[obstacle]]
type = "sphere"
center = [1.3, 0.4, 1.4]
radius = 0.1
velocity = [0.01, 0, 0]
[output.series]
"""
FILTERS = "[tensile]\n[vorticity]\n[viscosity]\n"
OUTPUTS = """
[[drain]]
min = [0, 0, 2.3]
max = [1.6, 0.8, 2.4]
[[drain]]
min = [0.8, 0, 0]
max = [1.6, 0.8, 0.4]
flow = 0
[colour]
by = "rainbow_x"
[output.vtkhdf]
every_steps = 2
fields = ["velocity", "density", "id", "rank", "rgb"]
[[output.frames]]
every_steps = 2
precision = "single"
[[output.frames]]
name = "means"
what = "cells"
every_steps = 2
fields = ["fraction", "velocity", "density"]
[output.checkpoint]
every_steps = 2
keep = 9
""" + ("" if "VTK" in WITHOUT else "[output.vtu]\nevery_steps = 2\n")
TERMS = {"spacing": 0.1, "speed": 10.0}  # what the formulas of the page are about, as in SCENE

Table = namedtuple("Table", "heading columns rows")


def cells(line):
    return [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


def tables(page):
    """The tables of a Markdown page, each with the heading above it."""
    found, heading, inside = [], "", False
    for line in page.read_text().splitlines():
        if line.startswith("#"):
            heading = line.lstrip("#").strip()
        if not line.startswith("|"):
            inside = False
        elif not inside:
            found.append(Table(heading, cells(line), []))
            inside = True
        elif not re.fullmatch(r"[|\- ]+", line):
            found[-1].rows.append(cells(line))
    return found


def column(page, heading, first, *more):
    """[(name, cells in the columns `more`)] of the table under a heading whose first column has the title `first`.
    A row may have several names."""
    table, = [t for t in tables(page) if t.heading == heading and t.columns[0] == first]
    wanted = [table.columns.index(name) for name in more]
    return [(name, *[row[k] for k in wanted]) for row in table.rows for name in re.findall(r"`([^`]+)`", row[0])]


def key_rows():
    """{("[table]", "key"): (type, default)} of the page of scenes."""
    rows = [((table.heading, row[0].strip("`")), (row[1], row[2])) for table in tables(ROOT / "inputs/README.md")
            if table.heading.startswith("[") for row in table.rows]
    assert len(rows) == len(dict(rows)), "a key has two rows"
    return dict(rows)


def default_of(cell):
    """The default that a cell names first, as TOML; None without one."""
    match = re.match(r"`([^`]*)`", cell)
    return match and match[1]


def path_of(key):
    """fountain.0.speed of ("[[fountain]]", "speed")."""
    table, name = key
    return table[2:-2] + ".0." + name if table.startswith("[[") else table[1:-1] + "." + name


def value_of(toml):
    """A TOML scalar or list as Python has it; whole numbers as floats, so that 1 and 1.0 are the same."""
    value = json.loads(toml.replace("'", '"'))
    return [float(x) if isinstance(x, int) else x for x in value] if isinstance(value, list) else (
        float(value) if isinstance(value, int) and not isinstance(value, bool) else value)


def assignments(name):
    """{path: value} of a list in scene_defaults.hpp; those with {} are computed, and None here."""
    text = (ROOT / "tests/scene/scene_defaults.hpp").read_text()
    body = re.search(re.escape(name) + r"[^;{]*\{(.*?)\};", text, re.S)[1]
    found = {}
    for path, value in re.findall(r'"([a-z_0-9.]+)=([^"\n]*)"', body):
        nested = re.fullmatch(r"\{(\w*)=?(.*)\}", value)
        if "{}" in value or (nested and not nested[1]):
            found[path] = None
        elif nested:
            found[f"{path}.{nested[1]}"] = value_of(nested[2])
        else:
            found[path] = value_of(value)
    return found


def largest_eigenvalue(spacing, h):
    """mu of a Jacobi sweep with Spiky in both places, mass calibrated and epsilon 1 (src/kernels/kernels.hpp)."""
    reach = range(-math.ceil(h / spacing), math.ceil(h / spacing) + 1)
    places = [tuple(spacing * n for n in r) for r in itertools.product(reach, repeat=3)]
    near = [(r, math.hypot(*r)) for r in places if math.hypot(*r) < h]
    volume = 1 / sum(15 / (math.pi * h ** 6) * (h - d) ** 3 for _, d in near)
    pulls = [(r, volume * 45 / (math.pi * h ** 6) * (h - d) ** 2 / d) for r, d in near if d > 0]
    scale = sum(pull ** 2 * sum(x * x for x in r) for r, pull in pulls) + 1

    def wave(k):
        sines = [(r, pull * math.sin(sum(a * b for a, b in zip(k, r)) / spacing)) for r, pull in pulls]
        return sum(sum(r[axis] * s for r, s in sines) ** 2 for axis in range(3)) / scale

    angles = [math.pi * n / 12 for n in range(13)]
    return max(wave(k) for k in itertools.combinations_with_replacement(angles, 3))


class Page(ProgramTest):
    page = ROOT / "inputs/README.md"

    def assert_same_names(self, described, real, what):
        described = list(described)
        self.assertEqual(len(described), len(set(described)), f"{what}: a name has two rows in {self.page}")
        self.assertEqual(set(real) - set(described), set(), f"{what}: not described in {self.page}")
        self.assertEqual(set(described) - set(real), set(), f"{what}: described in {self.page}, but not there")

    def series(self, name, text, settings=(), steps=30):
        scene = self.folder / "scene.toml"
        scene.write_text(text)
        arguments = [word for setting in settings for word in ("--set", setting)]
        self.run_well(1, scene, "--steps", steps, *arguments, folder=self.folder / name)
        with open(self.folder / name / "out/scene/series.csv", newline="") as file:
            return [{key: value for key, value in row.items() if key not in TIMES} for row in csv.DictReader(file)]

    def run_well(self, ranks, *arguments, folder=None):
        folder and folder.mkdir()
        result = self.run_trevi(ranks, *arguments, "--progress", "none", folder=folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result


class Keys(Page):
    def known(self):
        """{("[table]", "key"): (type, required)}, as the program tells them."""
        told = self.run_well(1, "--help").stdout.split("Keys of a scene:\n")[1]
        found = {}
        for line in told.strip().splitlines():
            label, text = line.split(": ", 1)
            found[tuple(label.split(" "))] = (text.split("; ")[0], text.endswith("; required"))
        self.assertGreater(len(found), 60)
        return found

    def test_scenes(self):
        files = [path.relative_to(self.page.parent).as_posix() for path in self.page.parent.rglob("*")
                 if path.is_file() and path != self.page]
        self.assert_same_names([row[0] for row in column(self.page, "What is here", "file")], files, "scenes")

    def test_keys_and_types(self):
        known, rows = self.known(), key_rows()
        self.assert_same_names(rows, known, "keys")
        for key, (kind, required) in known.items():
            self.assertEqual(rows[key][0], kind, key)
            self.assertEqual(rows[key][1] == "required", required, key)
            self.assertRegex(rows[key][1], r"^(required|–|`.+)", key)

    def test_defaults(self):
        real = assignments("defaults_of_all_scenes") | assignments("defaults_of_features")
        for key, (_, cell) in key_rows().items():
            path = path_of(key)
            if real.get(path) is not None:
                self.assertEqual(value_of(self.evaluated(path, default_of(cell) or "null")), real[path], path)
            elif path not in real:  # nor is it in the unit test's list: it has none
                self.assertIsNone(default_of(cell), path)

    def evaluated(self, path, toml):
        """TOML of a default that may be a formula."""
        for word, value in TERMS.items():
            toml = re.sub(rf"\b{word}\b", str(value), toml)
        if path == "output.directory":
            return toml.replace("SCENE", "scene")
        return json.dumps(eval(toml, {})) if re.search(r"[*/] ?\d|\d [*/]", toml) else toml  # pylint: disable=eval-used

    def test_relaxation(self):
        said = float(default_of(key_rows()["[density]", "relaxation"][1]))
        self.assertAlmostEqual(said, 0.9587 * 2 / largest_eigenvalue(0.1, 0.2), delta=0.0005)

    def written_out(self, tables_of):
        said = {path_of(key): default_of(cell) for key, (_, cell) in key_rows().items() if key[0] in tables_of}
        del said["density.relaxation"]  # in three digits; test_relaxation has more
        return [f"{path}={self.evaluated(path, toml)}" for path, toml in said.items() if toml]

    def test_defaults_written_out_change_nothing(self):
        plain = ["[domain]", "[fluid]", "[[particles]]", "[time]", "[gravity]", "[density]", "[walls]", "[[fountain]]",
                 "[random]", "[output]", "[output.series]"]
        music = {"mapping", "follow", "rate"}  # have no place without music
        for name, text, more in (("plain", SCENE, []),
                                 ("filters", SCENE + FILTERS, ["[tensile]", "[vorticity]", "[viscosity]"])):
            settings = [line for line in self.written_out([*plain, *more]) if not set(re.split("[.=]", line)) & music]
            with self.subTest(name):
                self.assertGreater(len(settings), 20)
                absent = self.series(name + "_absent", text)
                self.assertEqual(self.series(name + "_written", text, settings), absent)
                self.assertGreater(float(absent[-1]["compression_max"]), 1e-3)  # the water has met

    def test_preset(self):
        rows = column(self.page, "The report's preset", "key", "value")
        said = {path: value_of(value.strip("`")) for path, value in rows}
        real = {path: value for path, value in assignments("defaults_of_the_report").items() if value is not None}
        self.assertEqual({path: said.get(path) for path in real}, real)
        preset = self.series("preset", SCENE, ["density.preset='report'"])
        self.assertEqual(self.series("written", SCENE, [f"{path}={value.strip('`')}" for path, value in rows]), preset)
        self.assertNotEqual(preset, self.series("default", SCENE))


def type_of(item):
    if item.dtype.kind in "SO":
        return "text"
    width = item.shape[-1] if len(item.shape) in (2, 4) else 1  # grids are of three
    return f"{item.dtype}" + (f" × {width}" if width > 1 else "")


def datasets_below(group):
    """{path: type}; a dataset with two names is there twice, which h5py's own visit leaves out."""
    found = {}
    for item in (group[name] for name in group):
        found |= {item.name: type_of(item)} if isinstance(item, h5py.Dataset) else datasets_below(item)
    return found


def contents_of(path):
    """Datasets and attributes of the root, with their types."""
    with h5py.File(path) as file:
        return datasets_below(file), {name: "text" if isinstance(value, bytes) else str(value.dtype)
                                      for name, value in file.attrs.items()}


def json_keys(value, path=""):
    if isinstance(value, dict):
        return {key for name, child in value.items() for key in json_keys(child, f"{path}.{name}" if path else name)}
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return {key for child in value for key in json_keys(child, path + "[]")}
    return {path}


class Files(Page):
    page = ROOT / "postprocess/README.md"

    made = None  # the folder of the runs that all tests look at

    def setUp(self):
        super().setUp()
        (self.folder / "scene.toml").write_text(SCENE + OUTPUTS)
        if Files.made is None:
            Files.made = tempfile.TemporaryDirectory()
            self.make_runs(Path(Files.made.name) / "out")
        self.output = Path(Files.made.name) / "out"

    def make_runs(self, output):
        scene = self.folder / "scene.toml"
        self.run_well(2, scene, "--output", output, "--steps", 8)
        self.run_well(2, scene, "--output", output, "--restart", output / "checkpoint_000004.h5", "--steps", 6)

    def rows(self, heading, first, *more):
        return column(self.page, heading, first, *more)

    def check_columns(self, file):
        header = re.sub(",[^,]*_1(?=,)", "", (self.output / file).read_text().split("\n")[0])
        self.assertEqual([name for name, in self.rows(file, "column")], re.sub(r"_\d(?=,|$)", "_K", header).split(","))

    def test_columns(self):
        for name in ("series", "obstacles", "bodies", "gauges"):
            self.check_columns(name + ".csv")

    def test_run_json(self):
        report = json.loads((self.output / "run.json").read_text())
        self.assert_same_names([name for name, in self.rows("run.json", "key")], json_keys(report), "run.json")

    def assert_hdf5(self, heading, path):
        datasets, attributes = contents_of(path)
        self.assertEqual(dict(self.rows(heading, "dataset", "type")), datasets)
        return attributes

    def test_checkpoint(self):
        attributes = self.assert_hdf5("Checkpoints", self.output / "checkpoint_000006.h5")
        self.assertEqual(dict(self.rows("Checkpoints", "attribute", "type")), attributes)

    def test_frames(self):
        self.assertEqual(self.assert_hdf5("Frames", self.output / "particles_000006.hdf"), {})

    def test_cells(self):
        self.assertEqual(self.assert_hdf5("Cells", self.output / "frames_means/cells_000006.hdf"), {})

    def blow_up(self):
        folder = self.folder / "blown"
        settings = ["gravity.acceleration=[0,0,-1e308]", "time.dt=20.0", "time.end=1000.0", "time.cfl=0"]
        result = self.run_trevi(1, self.folder / "scene.toml", "--output", folder,
                                *[word for setting in settings for word in ("--set", setting)])
        self.assertEqual(result.returncode, 3, result.stderr)
        return folder

    def test_blow_up(self):
        file, = self.blow_up().glob("blowup_*.h5")
        datasets, attributes = contents_of(file)
        self.assertEqual(dict(self.rows("Blow-ups", "attribute", "type")), attributes)
        said = dict(self.rows("Frames", "dataset", "type")) | dict(self.rows("Blow-ups", "dataset", "type"))
        self.assertEqual({name: said.get(name) for name in datasets}, datasets)
        self.assertEqual({name for name, _ in self.rows("Blow-ups", "dataset", "type")} - set(datasets), set())

    def test_file_names(self):
        names = [path.relative_to(folder).as_posix() for folder in (self.output, self.blow_up())
                 for path in folder.rglob("*") if path.is_symlink() or path.is_file()]
        places = {r"\*": ".*", "_N": r"_\d{6}", "_R": r"_\d+"}
        patterns = {name: re.compile(re.sub(r"\\\*|_[NR]", lambda place: places[place[0]], re.escape(name)))
                    for name, in self.rows("Files", "file")}
        unknown = [name for name in names if not any(pattern.fullmatch(name) for pattern in patterns.values())]
        self.assertEqual(unknown, [], f"not described in {self.page}")
        unseen = {said for said, pattern in patterns.items() if not any(map(pattern.fullmatch, names))}
        if "VTK" in WITHOUT:
            unseen = {name for name in unseen if "vtu" not in name and "pvd" not in name}
        self.assertEqual(unseen, ONLY_ON_THE_WAY, f"described in {self.page}, but not there")

    def test_lock_and_stop(self):
        folder = self.folder / "long"
        command = [self.trevi, self.folder / "scene.toml", "--output", folder, "--progress", "none",
                   "--set", "time.end=1e6"]
        with subprocess.Popen(command, env={**os.environ, **MPI_SETTINGS}, cwd=self.folder,
                              stderr=subprocess.DEVNULL) as run:
            try:
                deadline = time.monotonic() + TIME_LIMIT
                while not (folder / "series.csv").exists() and time.monotonic() < deadline:
                    time.sleep(0.02)
                self.assertTrue((folder / "run.lock").exists())
                (folder / "stop").touch()
                self.assertEqual(run.wait(TIME_LIMIT), 4)
            finally:
                run.send_signal(signal.SIGKILL)
        self.assertFalse((folder / "run.lock").exists() or (folder / "stop").exists())

    def test_preview(self):
        self.run_well(1, self.folder / "scene.toml", "--preview", "curves.csv")
        header = (self.folder / "curves.csv").read_text().splitlines()[0].split(",")
        self.assertEqual([name.replace("_K", "_0") for name, in self.rows("Preview", "column")], header)

    def test_scripts(self):
        scripts = [path.name for path in self.page.parent.glob("*.py")]
        self.assert_same_names([name for name, in self.rows("Scripts", "script")], scripts, "scripts")


if __name__ == "__main__":
    main()

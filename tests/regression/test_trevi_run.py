#!/usr/bin/python3
"""postprocess/trevi_run.py against what a run has written, by h5py and VTK's reader, and the notebook's cells."""

import base64
import json
import os
import re
import subprocess
import sys
import unittest
import unittest.mock
from pathlib import Path

import h5py
import numpy as np

from program import INPUTS, TIME_LIMIT, WITHOUT, ProgramTest, main
from scenes import tank

if "VTK" not in WITHOUT:
    from vtkmodules.util.numpy_support import vtk_to_numpy

POSTPROCESS = Path(__file__).resolve().parents[2] / "postprocess"
sys.path.insert(0, str(POSTPROCESS))
from trevi_run import Run, RunError, scene_of  # noqa: E402

SCENE = tank("1.6, 0.8, 1.2", ("0, 0, 0", "0.8, 0.8, 0.8"), dt=0.02, end=0.4) + """
[colour]
by = "speed"
[[obstacle]]
type = "sphere"
center = [1.2, 0.4, 0.4]
radius = 0.2
velocity = [0, 0, 0.1]
[[gauge]]
type = "height"
center = [0.4, 0.4, 0]
[output.vtkhdf]
every = 0.2
[[output.frames]]
every = 0.2
precision = "single"
one_in = 4
[[output.frames]]
name = "means"
what = "cells"
every = 0.1
fields = ["fraction", "velocity", "density"]
[output.checkpoint]
every = 0.1
keep = 9
[output.series]
every_steps = 1
""" + ("" if "VTK" in WITHOUT else "[output.vtu]\nevery = 0.1\nfields = [\"velocity\", \"density\", \"id\", \"rgb\"]\n")


class Reader(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.folder / "scene.toml").write_text(SCENE)
        self.run_well(2, "scene.toml", "--output", "run", "--set", "fluid.rest_density=997", "--set",
                      "particles.0.velocity=[1,0,0]")
        self.run_folder = self.folder / "run"

    def test_everything_of_a_run(self):
        run = Run(self.run_folder)
        self.assertEqual(run.scene["fluid"], {"spacing": 0.1, "rest_density": 997})
        self.assertEqual(run.scene["particles"][0]["velocity"], [1, 0, 0])
        self.assertEqual(run.report["particles"], 512)
        lines = (self.run_folder / "series.csv").read_text().splitlines()
        self.assertEqual(list(run.series), lines[0].split(","))
        self.assertEqual([column[-1] for column in run.series.values()], [float(x) for x in lines[-1].split(",")])
        self.assertEqual(len(run.series["time"]), 21)
        self.assertIn("force_x_0", run.obstacles)
        self.assertAlmostEqual(run.gauges["height_0"][0], 0.8)
        self.assertEqual(len(run.vtkhdf), 3)
        self.assertEqual(len(run.checkpoints), 5)
        self.assertEqual(len(run.frames), 3 if "VTK" in WITHOUT else 5)
        for frame in (*run.frames, *run.vtkhdf):
            state = run.checkpoints.at(frame.time)
            self.assertAlmostEqual(frame.time, state.time)
            self.assertEqual(frame.id.tolist(), state.id.tolist())
            self.assertEqual(np.abs(frame.position - state.position).max(), 0)
            np.testing.assert_allclose(frame.velocity, state.velocity, rtol=1e-6, atol=1e-6)
            self.assertTrue(frame.solids and all(file.exists() for file in frame.solids))
            self.assertEqual(frame.density.shape, (512,))
        with h5py.File(run.checkpoints[-1].path) as file:
            self.assertTrue((run.checkpoints[-1].position == file["particles/position"][:]).all())
        if "VTK" not in WITHOUT:
            self.assertEqual(run.frames[0].rgb.shape, (512, 3))

    def test_frame_sets(self):
        run = Run(self.run_folder)
        self.assertEqual(set(run.frame_sets), {"0", "means"})
        self.assertEqual([len(frames) for frames in run.frame_sets.values()], [3, 5])
        for frame in run.frame_sets["0"]:
            state = run.checkpoints.at(frame.time)
            chosen = np.isin(state.id, frame.id)
            self.assertTrue(60 < len(frame) < 200, len(frame))
            self.assertEqual(frame.position.dtype, np.float32)
            self.assertTrue((frame.position == state.position[chosen].astype(np.float32)).all())
        for frame in run.frame_sets["means"]:
            state = run.checkpoints.at(frame.time)
            self.assertEqual(frame.fraction.shape, (8, 4, 6))
            self.assertEqual(len(frame), 8 * 4 * 6)
            np.testing.assert_allclose(frame.origin, 0.1)
            np.testing.assert_allclose(frame.spacing, 0.2)
            cells = np.clip((state.position / 0.2).astype(int), 0, (7, 3, 5))
            counts, sums = np.zeros((8, 4, 6)), np.zeros((8, 4, 6, 3))
            np.add.at(counts, tuple(cells.T), 1)
            np.add.at(sums, tuple(cells.T), state.velocity)
            np.testing.assert_allclose(frame.fraction, counts / 8, atol=1e-7)
            np.testing.assert_allclose(frame.velocity, sums / np.maximum(counts, 1)[..., None], rtol=1e-5, atol=1e-6)

    @unittest.skipIf("VTK" in WITHOUT, "without VTK")
    def test_for_vtk(self):
        run = Run(self.run_folder)
        for frame in run.frames[-1], run.vtkhdf[-1], run.frame_sets["0"][-1]:
            cloud = frame.to_vtk()
            self.assertEqual(cloud.GetNumberOfVerts(), len(frame))
            self.assertEqual(cloud.GetPoint(7), tuple(frame.position[7]))
            self.assertEqual(cloud.GetPointData().GetArray("id").GetValue(7), frame.id[7])
        cells = run.frame_sets["means"][-1]
        grid = cells.to_vtk()
        self.assertEqual(grid.GetDimensions(), (8, 4, 6))
        place = grid.GetPoint(grid.FindPoint(0.7, 0.5, 0.3))
        np.testing.assert_allclose(place, [0.7, 0.5, 0.3], rtol=1e-6)
        number = grid.FindPoint(0.7, 0.5, 0.3)
        self.assertEqual(grid.GetPointData().GetArray("fraction").GetValue(number), cells.fraction[3, 2, 1])
        self.assertEqual(grid.GetPointData().GetArray("velocity").GetTuple3(number), tuple(cells.velocity[3, 2, 1]))

    @unittest.skipIf("VTK" in WITHOUT, "without VTK")
    def test_solids_that_stay_and_those_that_move(self):
        """One obstacle of each kind and a body: all are in the frame, where they are."""
        more = """
[[obstacle]]
type = "box"
center = [0.2, 0.2, 0.1]
size = [0.2, 0.2, 0.2]
[[body]]
type = "box"
center = [0.5, 0.4, 0.9]
size = [0.3, 0.3, 0.2]
density = 400
"""
        (self.folder / "more.toml").write_text(SCENE + more)
        self.run_well(1, "more.toml", "--output", "more", "--set", "time.end=0.2")
        run = Run(self.folder / "more")
        for frame in run.vtu[-1], run.vtkhdf[-1]:
            surface = frame.solids_to_vtk()
            number = vtk_to_numpy(surface.GetCellData().GetArray("obstacle"))
            corners = vtk_to_numpy(surface.GetPolys().GetConnectivityArray()).reshape(-1, 3)
            self.assertEqual(sorted(set(number)), [0, 1, 2])
            points = vtk_to_numpy(surface.GetPoints().GetData())
            middle = [points[corners[number == k]].reshape(-1, 3) for k in range(3)]
            middle = [(part.min(axis=0) + part.max(axis=0)) / 2 for part in middle]
            np.testing.assert_allclose(middle[0], [1.2, 0.4, 0.42], atol=1e-3)
            np.testing.assert_allclose(middle[1], [0.2, 0.2, 0.1], atol=1e-3)
            np.testing.assert_allclose(middle[2], [run.bodies[axis + "_0"][-1] for axis in "xyz"], atol=0.01)

    def test_frames_by_time(self):
        states = Run(self.run_folder).checkpoints
        for time, nearest in ((-1, 0), (0.04, 0), (0.06, 0.1), (0.1, 0.1), (0.34, 0.3), (9, 0.4)):
            self.assertAlmostEqual(states.at(time).time, nearest)
        self.assertEqual([frame.time for frame in states], sorted(frame.time for frame in states))

    def test_what_cannot_be_read_is_named(self):
        run = Run(self.run_folder)
        with self.assertRaisesRegex(AttributeError, "has no rank; it has"):
            _ = run.checkpoints[0].rank
        with self.assertRaisesRegex(RunError, "nowhere: no such directory"):
            Run(self.folder / "nowhere")
        run.checkpoints[0].path.write_bytes(b"no HDF5")
        with self.assertRaisesRegex(RunError, "checkpoint_000000.h5"):
            _ = Run(self.run_folder).checkpoints
        for frame in run.frames:
            for piece in frame.path.parent.glob("*.vtu"):
                piece.write_bytes(piece.read_bytes()[:700])
        if "VTK" not in WITHOUT:
            with self.assertRaisesRegex(RunError, "pvtu"):
                _ = run.frames[0].position
        (self.run_folder / "series.csv").write_text("step,time\n1,2\n3\n")
        with self.assertRaisesRegex(RunError, "series.csv"):
            _ = run.series

    def test_a_row_that_is_being_written_is_left_out(self):
        with open(self.run_folder / "series.csv", "a") as series:
            series.write("21,0.4")
        self.assertEqual(Run(self.run_folder).series["step"].tolist(), list(range(21)))

    def test_without_vtk(self):
        with unittest.mock.patch.dict(sys.modules, {"vtkmodules.util.numpy_support": None}):
            with self.assertRaisesRegex(RunError, "python3-vtk9"):
                Run(self.run_folder).checkpoints[0].to_vtk()

    def test_scripts_read_runs_by_the_reader_only(self):
        """No script but the reader opens HDF5 to read it, parses XML, or names a table of a run in open()."""
        others = [path for path in POSTPROCESS.glob("*.py") if path.name != "trevi_run.py"]
        self.assertGreater(len(others), 20)
        for path in others:
            with self.subTest(path.name):
                self.assertNotRegex(path.read_text(encoding="utf-8"), r'h5py\.File\((?![^)\n]*"w")|ElementTree|UnstructuredGridReader|'
                                    r'(open|json\.load)[^\n]*(series|obstacles|bodies|gauges|run|np)\.(csv|json)')

    def test_the_plot_of_the_first_page(self):
        code, = re.findall(r"```python\n(.*?)```", (POSTPROCESS.parent / "README.md").read_text(), re.DOTALL)
        for name in re.findall(r'"(\w+)"', code.split(":")[0]):
            self.run_well(1, INPUTS / "fountain_small.toml", "--output", f"out/{name}", "--steps", 6)
        (self.folder / "plot.py").write_text(code)
        subprocess.run(["/usr/bin/python3", "plot.py"], env=os.environ | {"PYTHONPATH": str(POSTPROCESS)}, cwd=self.folder,
                       timeout=TIME_LIMIT, check=True)
        self.assertGreater((self.folder / "plot.png").stat().st_size, 5000)

    def test_overrides(self):
        text = "[a]\nb = 1\n[[c]]\nd = [1, 2]\n# --set a.b=two\n# --set c.0.d=[3]\n# --set e.f.g=1.5\n"
        self.assertEqual(scene_of(text), {"a": {"b": "two"}, "c": [{"d": [3]}], "e": {"f": {"g": 1.5}}})

    def test_notebook(self):
        output = self.folder / "looked.ipynb"
        subprocess.run([POSTPROCESS / "run_notebook.py", POSTPROCESS / "look_at_a_run.ipynb", "--output", output],
                       env=os.environ | {"TREVI_RUN": str(self.run_folder)}, timeout=TIME_LIMIT, check=True)
        outputs = [one for cell in json.loads(output.read_text())["cells"] for one in cell.get("outputs", [])]
        pictures = [one["data"]["image/png"] for one in outputs if "data" in one]
        self.assertEqual(len(pictures), 3)
        for picture in pictures:
            self.assertGreater(len(base64.b64decode(picture)), 5000)


if __name__ == "__main__":
    main()

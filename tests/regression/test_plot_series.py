#!/usr/bin/python3
"""postprocess/plot_series.py on small series: draws what it should, and says clearly what it cannot draw."""

import math
import subprocess
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[2] / "postprocess" / "plot_series.py"
HEADER = ("step,time,dt,substeps,particles,iterations,density_mean,density_max,density_interior,compression_mean,"
          "compression_max,compression_rms,kinetic_energy,potential_energy,momentum_x,momentum_y,momentum_z,com_x,"
          "com_y,com_z,speed_max,top,front,front_q99,drift_max,imbalance,wall_seconds")
PNG = b"\x89PNG\r\n\x1a\n"


def row(step, **values):
    columns = dict.fromkeys(HEADER.split(","), 0.0)
    columns |= {"step": step, "dt": 1 / 60, "density_mean": 975 + 20 * math.exp(-step / 5), "density_interior": 1000.0,
                "kinetic_energy": 1.0e3 * step, "potential_energy": 5.0e5 - 1.0e3 * step} | values
    return ",".join(str(value) for value in columns.values())


class PlotSeries(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, lines):
        (self.folder / name).mkdir()
        (self.folder / name / "series.csv").write_text("".join(line + "\n" for line in lines))
        return self.folder / name

    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *map(str, arguments)], capture_output=True, text=True, check=False)

    def assert_drawn(self, result, png):
        self.assertEqual((result.returncode, result.stdout), (0, f"{png}\n"), result.stderr)
        self.assertEqual(png.read_bytes()[:8], PNG)

    def assert_refused(self, result, words):
        self.assertEqual(result.returncode, 2)
        self.assertIn(words, result.stderr)
        self.assertNotIn("Traceback", result.stderr)

    def test_one_run(self):
        run = self.write("run", [HEADER, *map(row, range(20))])
        self.assert_drawn(self.run_script(run), run / "density.png")

    def test_two_runs_with_energy(self):
        runs = [self.write(name, [HEADER, *map(row, range(20))]) for name in ("a", "b")]
        png = self.folder / "new" / "both.png"
        self.assert_drawn(self.run_script(*runs, "--energy", "--output", png), png)

    def test_rest_density_from_scene(self):
        run = self.write("run", [HEADER, *map(row, range(3))])
        scene = self.folder / "scene.toml"
        scene.write_text("[fluid]\nrest_density = 850.0\n")
        self.assert_drawn(self.run_script(run, "--scene", scene), run / "density.png")
        self.assert_refused(self.run_script(run, "--scene", self.folder / "none.toml"), "none.toml")

    def test_nan_interior_leaves_the_mean(self):
        run = self.write("run", [HEADER, *(row(i, density_interior="nan") for i in range(5))])
        result = self.run_script(run)
        self.assert_drawn(result, run / "density.png")
        self.assertIn("no interior density", result.stderr)

    def test_last_row_cut_short(self):
        run = self.write("run", [HEADER, *map(row, range(5))])
        with open(run / "series.csv", "a") as series:
            series.write(row(5)[:-1])  # all columns, but not all of the last
        self.assert_drawn(self.run_script(run), run / "density.png")

    def test_refusals(self):
        cases = {
            "empty": ([], "is empty"),
            "header": ([HEADER], "0 row(s)"),
            "one": ([HEADER, row(0)], "1 row(s)"),
            "nan": ([HEADER, *(row(i, density_mean="nan") for i in range(3))], "only nan"),
            "words": ([HEADER, row(0), row(1, density_mean="much"), row(2)], "not 27 numbers"),
            "ragged": ([HEADER, row(0), row(1) + ",1", row(2)], "not 27 numbers"),
            "other": (["a,b", "1,2", "3,4"], "no columns"),
        }
        for name, (lines, words) in cases.items():
            with self.subTest(name):
                run = self.write(name, lines)
                self.assert_refused(self.run_script(run), words)
                self.assertFalse((run / "density.png").exists())
        self.assert_refused(self.run_script(self.folder / "absent"), "No such file")


if __name__ == "__main__":
    unittest.main()

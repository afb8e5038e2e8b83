#!/usr/bin/python3
"""ParaView itself opens what a run leaves: particles.pvd and particles.hdf.series with their times, single .hdf frames
and a blow-up's, one rank of the run being empty. Exit code 77: no ParaView here, so nothing was tested.

Needs pvbatch, Xvfb and ParaView's Python modules, in TREVI_PARAVIEW_MODULES or where jobs/paraview_modules.sh puts them.
"""

import json
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

import h5py
import numpy
from matplotlib import image

import runs
from runs import BOX, Folder

MODULES = os.environ.get("TREVI_PARAVIEW_MODULES",
                         str(runs.ROOT / "build/paraview_modules/usr/lib/python3/dist-packages"))
READING = Path(__file__).resolve().with_name("paraview_reading.py")
# Half of the box is dry, and the slabs are of one size, so rank 1 of 2 has no water.
SCENE = BOX.format(low=0.0, high=0.4, height=0.0, top=0.6).replace("[domain]", '[domain]\nslabs = "equal"') + """
[output.vtkhdf]
every_steps = 1
fields = ["velocity", "density", "id", "rank"]
[output.vtu]
every_steps = 1
fields = ["velocity", "density", "id", "rank"]
"""
STEPS, COUNT = 2, 4 * 6 * 6
FIELDS = ["density", "id", "rank", "velocity"]


class ParaView(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.output = cls.folder.path("out")
        runs.run_well(2, cls.folder.scene(SCENE), cls.output, "--steps", STEPS)

    def read(self, *names):
        """By file name, what ParaView makes of it."""
        result = subprocess.run(["xvfb-run", "-a", "pvbatch", str(READING), *names], cwd=self.output, text=True,
                                env={**runs.environment(), "PYTHONPATH": MODULES, "LIBGL_ALWAYS_SOFTWARE": "1"},
                                capture_output=True, timeout=runs.TIMEOUT, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertNotIn("ERR", result.stderr)
        return json.loads(result.stdout)

    def heights(self, step):
        with h5py.File(self.output / f"particles_{step:06d}.hdf") as file:
            self.assertEqual(len(file["VTKHDF/NumberOfPoints"]), 1)  # a partition for each rank that has water
            return numpy.sort(file["VTKHDF/Points"][:, 2])

    def check_frame(self, frame, step):
        self.assertEqual(frame["ids"], list(range(COUNT)))
        self.assertEqual(frame["cells"], COUNT)
        self.assertTrue(set(FIELDS) <= set(frame["arrays"]), frame["arrays"])
        # Points of VTU are in single precision.
        numpy.testing.assert_allclose(frame["heights"], self.heights(step), atol=1e-6)

    def test_series_have_their_times_and_frames_all_the_water(self):
        series, single = ["particles.pvd", "particles.hdf.series"], f"particles_{STEPS:06d}.hdf"
        found = self.read(*series, single)
        for name in series:
            with self.subTest(name):
                numpy.testing.assert_allclose(found[name]["times"], [step / 60 for step in range(STEPS + 1)], atol=1e-12)
                for step, frame in enumerate(found[name]["frames"]):
                    self.check_frame(frame, step)
        self.check_frame(found[single]["frames"][0], STEPS)

    def test_the_tutorials_script_draws(self):
        """As pvbatch runs it, and then saves the picture: not all of one colour."""
        script, picture = self.folder.path("draw.py"), self.folder.path("picture.png")
        state = runs.ROOT / "inputs/tutorial/paraview_state.py"
        script.write_text(f"{state.read_text()}\nsimple.SaveScreenshot({str(picture)!r}, view)\n")
        result = subprocess.run(["xvfb-run", "-a", "pvbatch", str(script), "particles.pvd"], cwd=self.output, text=True,
                                env={**runs.environment(), "PYTHONPATH": MODULES, "LIBGL_ALWAYS_SOFTWARE": "1"},
                                capture_output=True, timeout=runs.TIMEOUT, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertGreater(len(numpy.unique(image.imread(picture)[..., :3].reshape(-1, 3), axis=0)), 20)

    def test_a_blow_up_opens(self):
        output = self.folder.path("blown")
        code, told = runs.run(2, self.folder.path("scene.toml"), output, "--set", "gravity.acceleration=[0,0,-1e308]",
                              "--set", "time.dt=20.0", "--set", "time.end=1000.0", "--set", "time.cfl=0", "--steps", 50)
        self.assertEqual(code, 3, told)
        file, = output.glob("blowup_*.hdf")
        frame, = self.read(str(file))[str(file)]["frames"]
        self.assertEqual(frame["ids"], list(range(COUNT)))


if __name__ == "__main__":
    missing = [program for program in ("pvbatch", "xvfb-run") if not shutil.which(program)]
    if not (Path(MODULES) / "paraview").is_dir():
        missing.append("ParaView's Python modules (jobs/paraview_modules.sh unpacks them)")
    if missing or "VTK" in runs.WITHOUT:
        print("left out: there is no " + ", no ".join(missing or ["VTU output in this build"]))
        sys.exit(77)
    unittest.main()

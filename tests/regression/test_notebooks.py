#!/usr/bin/python3
"""The notebooks of python/notebooks: their code runs to its end, and what they keep of an earlier run is small and of the kind
that they make."""

import json
import os
import subprocess
from pathlib import Path

from program import MPI_SETTINGS, TIME_LIMIT, ProgramTest, main

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.ipynb"))
MODULE = os.environ["TREVI_PYTHON"]  # the folder that has the module
LARGEST = 100_000  # bytes of a notebook


def kinds(path):
    """Of each cell of code, what it has put out."""
    return [[output["output_type"] for output in cell["outputs"]]
            for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]


class Notebooks(ProgramTest):
    def test_they_run(self):
        self.assertGreater(len(NOTEBOOKS), 4)
        for path in NOTEBOOKS:
            with self.subTest(path.stem):
                output = self.folder / path.name
                result = subprocess.run([ROOT / "postprocess/run_notebook.py", path, "--output", output],
                                        capture_output=True, text=True, timeout=TIME_LIMIT, check=False,
                                        env=os.environ | MPI_SETTINGS | {"PYTHONPATH": MODULE})
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(kinds(output), kinds(path), "made anew with run_notebook.py --output")
                self.assertTrue(any("display_data" in kind for kind in kinds(output)), "it draws nothing")

    def test_they_are_small(self):
        for path in NOTEBOOKS:
            with self.subTest(path.stem):
                self.assertLess(path.stat().st_size, LARGEST)

    def test_a_page_tells_of_each(self):
        page = (ROOT / "python/README.md").read_text()
        for path in NOTEBOOKS:
            self.assertIn(f"(notebooks/{path.name})", page)


if __name__ == "__main__":
    main()

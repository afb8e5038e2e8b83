"""Scripts that import the module trevi, as their users have them, under mpirun. No test of its own."""

import os
import subprocess
import textwrap

from program import MPI_SETTINGS, TIME_LIMIT, ProgramTest

MODULE = os.environ["TREVI_PYTHON"]  # the folder that has it

TANK = """
    import sys, numpy as np, trevi
    settings = trevi.Settings()
    settings.domain.min, settings.domain.max = [0, 0, 0], [2, 1, 1.5]
    lattice = 0.1 * (np.stack(np.meshgrid(range(20), range(10), range(5), indexing="ij"), -1).reshape(-1, 3) + 0.5)
"""


class ModuleTest(ProgramTest):
    def run_script(self, ranks, text, *arguments):
        path = self.folder / "script.py"
        path.write_text("\n".join(textwrap.dedent(part) for part in (text if isinstance(text, tuple) else (text,))))
        return subprocess.run([self.mpirun, "-n", str(ranks), "/usr/bin/python3", str(path), *map(str, arguments)],
                              cwd=self.folder, capture_output=True, text=True, timeout=TIME_LIMIT,
                              env=os.environ | MPI_SETTINGS | {"PYTHONPATH": MODULE})

    def run_fine(self, ranks, text, *arguments):
        result = self.run_script(ranks, text, *arguments)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return result.stdout

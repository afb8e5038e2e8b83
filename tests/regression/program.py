"""What the tests of the whole program share: running it on some ranks, with a time limit, in a folder of its own."""

import argparse
import atexit
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

INPUTS = Path(__file__).resolve().parents[2] / "inputs"
WITHOUT = os.environ.get("TREVI_WITHOUT", "").split()  # the parts that the build leaves out: VTK MUSIC SOUND LIVE
if "VTK" in WITHOUT:  # then the frames of the scenes are VTKHDF
    copies = tempfile.TemporaryDirectory()
    INPUTS = Path(shutil.copytree(INPUTS, copies.name, dirs_exist_ok=True))
    for scene in INPUTS.rglob("*.toml"):
        scene.write_text(scene.read_text().replace("[output.vtu]", "[output.vtkhdf]"))
INSTRUCTION_SET = os.environ.get("TREVI_TEST_INSTRUCTION_SET")  # of the pair loops, in all runs: "AVX2" for instance
# s, for one run: a rank that waits for ever is a failure. An emulated processor is slower (jobs/neon.sh).
TIME_LIMIT = float(os.environ.get("TREVI_TEST_TIME_LIMIT", 100))
MPI_SETTINGS = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none"}


def with_instruction_set(trevi):
    """The program, or a stand-in that names it the instruction set that the tests are asked to use."""
    if not INSTRUCTION_SET:
        return trevi
    stand_in = Path(tempfile.mkdtemp()) / "trevi"  # named as the program, by which ranks are found
    atexit.register(shutil.rmtree, stand_in.parent)
    setting = f"--set run.instruction_set={INSTRUCTION_SET}"  # at the end, as --set takes all that follows
    stand_in.write_text(f"#!/bin/sh\nexec '{Path(trevi).resolve()}' \"$@\" {setting}\n")
    stand_in.chmod(0o755)
    return stand_in


class ProgramTest(unittest.TestCase):
    program = trevi = mpirun = None  # set by main(); trevi may be a stand-in for the program

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_trevi(self, ranks, *arguments, folder=None):
        command = [self.mpirun, "-np", ranks] if ranks > 1 else []
        # Of runs side by side one that ends may remove the folder in which another mpirun is about to make its own.
        with tempfile.TemporaryDirectory() as sessions:
            return subprocess.run([str(word) for word in [*command, self.trevi, *arguments]],
                                  cwd=folder or self.folder, capture_output=True, text=True, timeout=TIME_LIMIT,
                                  env={**os.environ, **MPI_SETTINGS, "OMPI_MCA_orte_tmpdir_base": sessions}, check=False)

    def run_well(self, ranks, *arguments):
        result = self.run_trevi(ranks, *arguments, "--progress", "none")
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def contents(self, folder=None):
        """Every file and folder below one, the test's own for instance, with its bytes."""
        return {path: path.read_bytes() if path.is_file() else None for path in (folder or self.folder).rglob("*")}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("trevi", type=Path)
    parser.add_argument("mpirun")
    paths, rest = parser.parse_known_args()
    ProgramTest.program, ProgramTest.mpirun = paths.trevi.resolve(), paths.mpirun
    ProgramTest.trevi = with_instruction_set(ProgramTest.program)
    unittest.main(module="__main__", argv=[sys.argv[0], *rest])

#!/usr/bin/python3
"""Set-up by the scripts of jobs/: a folder that was configured for a run alone and then for the tests compiles nothing of
the program twice, which is so when the commands are the same."""

import argparse
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class SetUp(unittest.TestCase):
    cmake = "cmake"

    def commands(self, folder, *options):
        """{source: command} of the program and its library."""
        subprocess.run([self.cmake, "-S", ROOT, "-B", folder, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", *options], check=True, capture_output=True)
        entries = json.loads((folder / "compile_commands.json").read_text())
        return {entry["file"]: entry["command"] for entry in entries if "/tests/" not in entry["file"]}

    def test_a_second_configuration_changes_no_command(self):
        with tempfile.TemporaryDirectory() as name:
            first = self.commands(Path(name), "-DTREVI_TESTS=OFF")
            self.assertGreater(len(first), 30)  # the library's sources are compiled eight at a time
            self.assertEqual(self.commands(Path(name), "-DTREVI_TESTS=ON"), first)
            self.assertEqual(self.commands(Path(name)), first)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("cmake")
    arguments, rest = parser.parse_known_args()
    SetUp.cmake = arguments.cmake
    unittest.main(argv=[sys.argv[0], *rest])

#!/usr/bin/python3
"""Each study, and each script that runs scenes for a page, has scenes that the program takes: all that a study would run
is read and checked by it, and nothing is run. What is refused is told with its study and its case."""

import contextlib
import importlib
import io
import os
import sys
import unittest
from pathlib import Path
from unittest import mock

os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, os.environ["TREVI_PYTHON"])
POSTPROCESS = Path(__file__).resolve().parents[2] / "postprocess"
sys.path.insert(0, str(POSTPROCESS))

import study  # noqa: E402
import trevi  # noqa: E402

ARGUMENTS = {"study_error": [[], ["--kernels"]], "study_motion": [["--large"]], "study_periodic": [[], ["--tanks"]],
             "study_vessels": [["--seeds", "1", "1"]]}
# What no scene depends on, and takes long: theory beside a run, and points by which volumes are counted.
QUICKER = {"study_bodies": {"decay": lambda *_, **__: (None, None, None)}, "study_vessels": {"FINE": 0.06}}
FINDINGS = {"study_stability": "an equality pulls particles into clumps"}  # what is refused is a row there


class Asked(Exception):
    """In place of a run."""


class Ended(Exception):
    """Nothing is left of a study but what it would make of its runs."""


class Asking:
    """What studies do with the program, of which nothing is left but the question whether it takes a scene."""

    def __init__(self):
        self.asked, self.refused = 0, []  # how many scenes, and what the program says

    def launch(self, _, scene, __, settings, time_limit):
        self.asked += 1
        try:
            trevi._read_scene(str(scene), [str(setting) for setting in settings], None)
        except trevi.InputError as error:
            self.refused.append(str(error))
        raise Asked

    def simulate(self, *arguments, **more):
        """For a script that has no cases: what it makes of any numbers is not looked at."""
        with contextlib.suppress(Asked):
            study.simulate_states(*arguments, **more)
        return Ones(), 0, ""

    def in_turn(self, work, cases, _=1):
        for case in cases:
            refused = len(self.refused)
            with contextlib.suppress(Asked):
                work(case)
            self.refused[refused:] = [f"{case}: {error}" for error in self.refused[refused:]]
        yield from ()


class Ones(dict):
    def __missing__(self, _):
        return [1.0] * 10


def end(*_):
    raise Ended


class Studies(unittest.TestCase):
    def ask(self, name, arguments):
        """Asks about all scenes of a study."""
        asking = Asking()
        with mock.patch.multiple(study, launch=asking.launch, in_turn=asking.in_turn, write_table=end):
            script = importlib.reload(importlib.import_module(name))
            if name == "validate":
                script.simulate = asking.simulate
            if hasattr(script, "draw"):
                script.draw = end
            vars(script).update(QUICKER.get(name, {}))
            with mock.patch("sys.argv", [name, "/dev/null", *arguments]), contextlib.redirect_stdout(io.StringIO()), \
                    contextlib.redirect_stderr(io.StringIO()), contextlib.suppress(Asked, Ended, SystemExit):
                script.main()
        self.assertGreater(asking.asked, 0, f"{name}: runs no scene, or not by study.py")
        refused = [error for error in asking.refused if name not in FINDINGS or FINDINGS[name] not in error]
        self.assertEqual(refused, [], name)

    def test_scenes_are_taken(self):
        for path in sorted(POSTPROCESS.glob("*.py")):
            text = path.read_text(encoding="utf-8")
            if "def main" not in text or not any(f"{way}(" in text for way in ("launch", "simulate", "run_motion")):
                continue
            for arguments in ARGUMENTS.get(path.stem, [[]]):
                with self.subTest(path.stem, arguments=arguments):
                    self.ask(path.stem, arguments)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

#!/usr/bin/env python3
"""Scaling study: arguments that are refused, and a table and a model from made-up runs whose answers are known."""

import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "postprocess"))

from scaling_metrics import metrics, shares, transfer_seconds  # noqa: E402
from scaling_model import (Basin, Block, Costs, Node, best_shape, efficiency, exchange_bytes, messages, slabs,  # noqa: E402
                           traffic, windows)

STUDY, TABLES = ROOT / "jobs" / "scaling.sh", ROOT / "postprocess" / "scaling.py"
SHAPES = ROOT / "postprocess" / "scaling_shapes.py"


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=60, check=False)


class Arguments(unittest.TestCase):
    def test_bad_ones_are_refused_with_the_reason(self):
        for arguments, reason in ((["--ranks", "1 two"], "'two'"), (["--ranks", "1x"], "'1x'"), (["--studies", "string"], "'string'"),
                                  (["--repeats"], "--repeats"), (["--program", "/nowhere"], "/nowhere"), (["x"], "x")):
            result = run(STUDY, *arguments)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(reason, result.stderr)

    def test_help_names_each_option(self):
        text = run(STUDY, "--help").stdout
        for option in ("--studies", "--ranks", "--counted", "--million", "--repeats", "--output", "--program", "--no-tables"):
            self.assertIn(option, text)


class ArrayJob(unittest.TestCase):
    def submitted(self, task, nodes):
        """What jobs/scaling.sbatch gives to jobs/scaling.sh as that task of an array."""
        with tempfile.TemporaryDirectory() as folder:
            study = Path(folder) / "jobs/scaling.sh"
            study.parent.mkdir()
            study.write_text('#!/bin/sh\necho "$OMPI_MCA_rmaps_base_mapping_policy $*"\n')
            study.chmod(0o755)
            slurm = {"SLURM_SUBMIT_DIR": folder, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_NNODES": str(nodes),
                     "SLURM_JOB_ID": "7", "SPLITS": "64x1 8x8"}
            return subprocess.run(["bash", str(ROOT / "jobs/scaling.sbatch"), "--million"], capture_output=True, text=True,
                                  timeout=60, check=False, env={**os.environ, **slurm})

    def test_a_task_runs_one_split_of_its_nodes(self):
        self.assertRegex(self.submitted(0, 2).stdout, r"^ppr:64:node:PE=1 .*--ranks 128x1 --no-tables .*--million\n$")
        self.assertRegex(self.submitted(1, 4).stdout, r"^ppr:8:node:PE=8 .*--ranks 32x8 --no-tables ")

    def test_a_task_without_a_split_is_refused(self):
        result = self.submitted(2, 1)
        self.assertEqual(result.returncode, 2)
        self.assertIn("SPLITS", result.stderr)


class Tables(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def write(self, place, ranks, wall):
        report = {"steps": 10, "particles": 1000, "wall_seconds": wall, "halo_wait_seconds": [0.1] * ranks,
                  "imbalance": {"mean": 1.0, "max": 1.0}, "cut_moves": 0, "halo_messages_per_step": 4.0,
                  "halo_bytes_per_step": 400.0, "bytes_per_particle": 300.0}
        (self.path / place).mkdir(parents=True)
        (self.path / place / "run.json").write_text(json.dumps(report), encoding="utf-8")

    def test_efficiency_is_by_the_fastest_and_by_the_median(self):
        for number, (one, two) in enumerate(((10, 8), (11, 6), (14, 9))):
            self.write(f"strong/own/np1-{number}", 1, one)
            self.write(f"strong/own/np2-{number}", 2, two)
            self.write(f"strong/own/np1x2-{number}", 1, two + 1)
        result = run(TABLES, self.path)
        self.assertEqual(result.returncode, 0, result.stderr)
        header, one, threads, two = [line.split(",") for line in (self.path / "scaling.csv").read_text().splitlines()]
        row = dict(zip(header, two, strict=True))
        self.assertEqual((row["efficiency_fastest"], row["efficiency_median"]), ("0.833", "0.688"))
        row = dict(zip(header, threads, strict=True))
        self.assertEqual((row["ranks"], row["threads"], row["efficiency_fastest"]), ("1", "2", "0.714"))
        self.assertEqual(dict(zip(header, one, strict=True))["ms_per_step_fastest"], "1000.0")
        self.assertTrue((self.path / "scaling.png").exists())

    def test_what_is_no_run_is_refused(self):
        self.assertEqual(run(TABLES, self.path).returncode, 2)
        self.write("strong/own/np1-1", 1, 1)
        (self.path / "strong/own/np1-1/run.json").write_text("{}", encoding="utf-8")
        result = run(TABLES, self.path)
        self.assertEqual(result.returncode, 2)
        self.assertIn("run.json", result.stderr)


    def test_constants_of_no_run_are_refused(self):
        for text in ("{}", "[1]", "no json", '{"particle": "fast"}'):
            (self.path / "constants.json").write_text(text, encoding="utf-8")
            result = run(SHAPES, self.path / "a.csv", self.path / "a.png", "--constants", self.path / "constants.json")
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("constants.json", result.stderr)
            self.assertFalse((self.path / "a.csv").exists())


class Metrics(unittest.TestCase):
    """Two ranks that compute 8 and 6 s of 10, beside one that takes 12 s for the same water."""

    ALONE = {"steps": 10, "particles": 1000, "threads": 1, "step_seconds": [12.0], "waiting_seconds": [0.0], "phases": []}
    TWO = {"steps": 10, "particles": 1000, "threads": 1, "step_seconds": [10.0, 10.0], "waiting_seconds": [2.0, 4.0],
           "reduction_seconds": [0.5, 1.5], "halo_wait_seconds": [1.0, 2.0], "halo_messages_per_step": 200.0,
           "halo_bytes_per_step": 2e9, "phases": [{"name": "Reductions", "calls": 50},
                                                  {"name": "Migrate", "seconds": {"mean": 0.25}}]}
    NETWORK = {"latency": 1e-4, "bandwidth": 1e10, "reduction": 2e-4}

    def test_efficiencies_are_those_of_their_definitions(self):
        found = metrics(self.TWO, self.ALONE, self.NETWORK)
        for name, value in (("load_balance", 7 / 8), ("communication", 0.8), ("parallel_efficiency", 0.7),
                            ("computation", 12 / 14), ("global_efficiency", 0.6)):
            self.assertAlmostEqual(found[name], value, msg=name)
        self.assertAlmostEqual(found["serialisation"] * found["transfer"], found["communication"])

    def test_transfer_is_what_messages_and_reductions_take(self):
        transfer = 10 * 100 * 1e-4 + 10 * 1e9 / 1e10 + 50 * 2e-4
        self.assertAlmostEqual(transfer_seconds(self.TWO, self.NETWORK), transfer)
        self.assertAlmostEqual(metrics(self.TWO, None, self.NETWORK)["transfer"], (10 - transfer) / 10)
        slow = {**self.NETWORK, "latency": 1.0}  # more than anybody waits: then messages are hidden
        self.assertAlmostEqual(transfer_seconds(self.TWO, slow), 2)
        self.assertAlmostEqual(metrics(self.TWO, None, slow)["serialisation"], 1)

    def test_shares_are_of_the_time_of_all_ranks(self):
        self.assertEqual(shares(self.TWO), {"waiting_percent": 30, "reductions_percent": 10, "exchanges_percent": 15,
                                            "migration_percent": 2.5})


class Model(unittest.TestCase):
    COSTS = Costs(particle=500e-9, cell=1e-9, latency=2e-6, bandwidth=12e9, reduction=2e-6)

    def test_traffic_is_that_of_test_traffic_cpp(self):
        basin = Basin(length=34, width=4, depth=10, air=6)  # its still_scene
        coarse = 16 * 8 * 100 + 40 * (8 * 1 + 8 * 15)
        heights = 4 * 4
        self.assertEqual(exchange_bytes(basin), 64 + 88 * 80 + heights + coarse)
        self.assertEqual(exchange_bytes(basin, filters=3), 64 + (88 + 28) * 80 + heights + coarse)
        self.assertEqual(messages(basin), 1 + 10 + 8 + 15)

    def test_traffic_of_shared_slabs_is_that_of_test_traffic_cpp(self):
        basin = Basin(length=34, width=8, depth=10, air=6)
        slabs_beside, within, across = 2 * 1 * 4, 2 * 1 * 17, 4  # rows of planes, 2 slabs of 2 parts
        around, upper = slabs_beside + within + across, slabs_beside / 2 + within / 2 + across / 4
        size = around * (32 + 88 * 40 + 4 + 8 * 800 + 112 * 10) + upper * 56 * 10 + slabs_beside * 80
        size += (within + across) * (72 * 8 + 33 * 10)
        self.assertEqual(traffic(basin, Block(2, 2, 17, 4, 2, 2, True)), (size, 12 * (11 + 7 + 14) + 5 * 7 + 4 + 8 * 6))

    def test_the_rule_for_ranks_is_that_of_the_program(self):
        rows = [line.split(",") for line in (ROOT / "tests/solver/ranks_by_model.csv").read_text().splitlines()[1:]]
        for length, width, depth, air, ranks, *shape in ((int(cell) for cell in row) for row in rows):
            with self.subTest(length=length, ranks=ranks):
                self.assertEqual(list(best_shape(Basin(length, width, depth, air), ranks)), shape)

    def test_cuts_inside_slabs_go_on_where_slabs_end(self):
        basin = Basin(100, 100, 100)
        self.assertIsNone(slabs(basin, 100, self.COSTS))
        self.assertLess(windows(basin, (20, 20), self.COSTS).total(), slabs(basin, 50, self.COSTS).total())

    def test_slabs_end_at_one_plane_a_rank(self):
        basin = Basin(100, 100, 100)
        self.assertIsNotNone(slabs(basin, 50, self.COSTS))
        self.assertIsNone(slabs(basin, 51, self.COSTS))

    def test_efficiency_falls_with_ranks_and_is_one_without_a_network(self):
        basin = Basin(1024, 100, 100)
        steps = [efficiency(basin, n, slabs(basin, n, self.COSTS), self.COSTS) for n in (1, 4, 16, 64, 256)]
        self.assertEqual(steps, sorted(steps, reverse=True))
        free = self.COSTS._replace(latency=0.0, bandwidth=1e300, reduction=0.0, cell=0.0)
        self.assertAlmostEqual(efficiency(basin, 64, slabs(basin, 64, free), free), 1)

    def test_threads_share_rows_but_not_planes_nor_what_the_first_does_alone(self):
        basin = Basin(128, 128, 100)  # 64 planes of 64 rows
        free = Costs(particle=500e-9, cell=0.0, latency=0.0, bandwidth=1e300, reduction=0.0)
        self.assertAlmostEqual(efficiency(basin, 64, slabs(basin, 64, free, 64), free, 64), 1)
        self.assertAlmostEqual(efficiency(basin, 64, slabs(basin, 64, free, 128), free, 128), 0.5)
        particles = basin.particles() / 64
        slow = slabs(basin, 64, free._replace(by_planes=10e-9, serial=1e-9, migration=5e-9), 64)
        self.assertAlmostEqual(slow.planes, 10e-9 * particles)
        self.assertAlmostEqual(slow.serial, 6e-9 * particles)

    def test_memory_of_a_node_is_shared_by_its_ranks(self):
        basin, costs = Basin(128, 128, 100), self.COSTS._replace(traffic=3000.0, cell=0.0)
        steps = [slabs(basin, 64, costs, 64 // k, Node(k, memory=100e9)) for k in (1, 64)]
        self.assertAlmostEqual(steps[1].rows, 64 * 3000 * basin.particles() / 64 / 100e9)
        self.assertLess(steps[0].rows, steps[1].rows)


if __name__ == "__main__":
    unittest.main()

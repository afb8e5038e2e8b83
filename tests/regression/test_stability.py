#!/usr/bin/python3
"""The small half of jobs/study_stability.sh with pass marks: what the default must not do, whatever the scene."""

import math
import os
import sys
from pathlib import Path

from program import INPUTS, MPI_SETTINGS, ProgramTest, main

sys.path.append(str(Path(__file__).resolve().parents[2] / "postprocess"))
import study  # noqa: E402
import study_stability  # noqa: E402

os.environ.update(MPI_SETTINGS)
QUICK = {"dt, column": ("1/60 s", "1/30 s", "1/10 s"), "dt, dam break": ("1/30 s", "1/10 s"), "layers": ("10", "20"),
         "drop": ("2 m", "20 m"), "spacing": ("0.0125 m",), "tank length": ("0.84 m",), "epsilon 0": ("column", "one"),
         "iterations, column": ("1", "2", "16"), "h/s": ("1.5", "2.5"), "pump": ("10.0 m/s", "100.0 m/s"),
         "overlap": ("tenth of s", "coincident"), "few": ("one", "two", "in a corner")}


# Bounds, and what the worst of two disturbed starts on each instruction set, with densities of either kernel, came to.
# The report's preset, which gains energy and loses depth, breaks them in 19 of the 25 cases.
FASTEST = 5  # times what gravity or the pump can give; 2.04, coincident blocks, and 1.55 in passive scenes
GAIN = 0.05  # of the energy, water that starts at rest; 0.016 with a single iteration, else 0.001
DEPTH = 0.9  # of what the volume of the water gives; 0.951, ten layers


class Stability(ProgramTest):
    def run_case(self, scene, settings):
        columns, code, message = study.simulate(self.trevi, INPUTS / "stress" / f"{scene}.toml", settings)
        self.assertEqual(code, 0, message)
        return columns

    def test_quick_cases_are_stable(self):
        found = 0
        for case in study_stability.all_cases():
            if case.name not in QUICK.get(case.group, ()):
                continue
            found += 1
            with self.subTest(group=case.group, case=case.name):
                self.check_case(case, self.run_case(case.scene, case.settings))
        self.assertEqual(found, sum(map(len, QUICK.values())))

    def check_case(self, case, columns):
        self.assertEqual(len(set(columns["particles"])), 1)
        self.assertTrue(all(map(math.isfinite, study.energies(columns))))
        self.assertLess(max(columns["speed_max"][1:]), FASTEST * case.speed)
        if case.passive and columns["compression_max"][0] <= 0.01:
            self.assertLess(study.energy_gain(columns, case.spacing), GAIN)
        depth = columns["particles"][0] * case.spacing**3 / case.floor
        if depth > 2 * case.spacing:  # a single particle has none to lose
            self.assertGreater(columns["com_z"][-1], DEPTH * depth / 2)

    def test_start_lattice_is_at_rest_density(self):
        columns = self.run_case("column", ["time.end=0.17", "domain.max=[1.0,1.0,4.0]", "particles.0.max=[1.0,1.0,2.0]"])
        self.assertLess(columns["compression_max"][0], 1e-5)
        self.assertLess(max(columns["top"][:11]), columns["top"][0] + 0.005)  # no pop

    def test_coincident_particles_part(self):
        # Two particles in one place, in the air; their density tells whether they still are.
        place = [f"particles.{k}.{end}" for k in (0, 1) for end in ("min=[1.0,1.0,2.0]", "max=[1.1,1.1,2.1]")]
        columns = self.run_case("overlap", [*place, "time.end=0.1"])
        self.assertLess(columns["density_max"][-1], 0.9995 * columns["density_max"][0])

    def test_shifts_along_the_constraints_own_gradient_add_no_energy(self):
        # Five layers at 1/120 s: with densities of Poly6 and gradients of Spiky they gain 3.8 to 5.7 %, with one kernel
        # for both nothing, from three disturbed starts on each instruction set.
        shallow = study_stability.column("", "", layers=5, steps_per_second=120, settings=["fluid.density_kernel=spiky"])
        columns = self.run_case(shallow.scene, shallow.settings)
        self.assertLess(study.energy_gain(columns), 1e-3)

    def test_column_rests(self):
        columns = self.run_case("column", ["viscosity.c=0.001", "domain.max=[1.0,1.0,6.0]", "particles.0.max=[1.0,1.0,4.0]"])
        # Three disturbed starts on each instruction set, either kernel: 0.0007 to 0.0008, 0.972 to 0.986, 0.9e-4 to 3.9e-4.
        self.assertLess(study.mean(columns["compression_mean"][1:]), 0.01)
        self.assertLess(math.fabs(columns["com_z"][-1] / 2.0 - 1), 0.05)
        self.assertLess(columns["kinetic_energy"][-1] / study.mass_of(columns), 5e-3)  # a speed of 0.1 m/s
        self.assertLess(study.energy_gain(columns), 0.005)


if __name__ == "__main__":
    main()

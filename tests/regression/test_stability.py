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
                columns = self.run_case(case.scene, case.settings)
                self.assertEqual(study_stability.verdict(case, columns, 0), "stable")
                self.assertEqual(set(columns["particles"]), {columns["particles"][0]})
        self.assertEqual(found, sum(map(len, QUICK.values())))

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
        # Five layers at 1/120 s: with densities of Poly6 and gradients of Spiky they gain 5.7 %.
        shallow = study_stability.column("", "", layers=5, steps_per_second=120, settings=["fluid.density_kernel=spiky"])
        columns = self.run_case(shallow.scene, shallow.settings)
        self.assertLess(study.energy_gain(columns), 1e-3)
        self.assertLess(columns["kinetic_energy"][-1] / study.mass_of(columns), 0.1)

    def test_column_rests(self):
        columns = self.run_case("column", ["viscosity.c=0.001", "domain.max=[1.0,1.0,6.0]", "particles.0.max=[1.0,1.0,4.0]"])
        self.assertLess(study.mean(columns["compression_mean"][1:]), 0.01)
        # 2.4 % in a column twice as wide (inputs/stress/column.toml); walls cost height.
        self.assertLess(math.fabs(columns["com_z"][-1] / 2.0 - 1), 0.03)
        self.assertLess(columns["kinetic_energy"][-1] / study.mass_of(columns), 1e-3)


if __name__ == "__main__":
    main()

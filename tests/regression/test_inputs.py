#!/usr/bin/python3
"""Every scene in inputs/ is understood, or asks for a part that this build lacks and is told so; and the small ones run to their end without losing a particle."""

import csv

from program import INPUTS, WITHOUT, ProgramTest, main


class Scenes(ProgramTest):
    def test_every_scene_passes_a_dry_run(self):
        scenes = sorted(INPUTS.rglob("*.toml"))
        self.assertGreater(len(scenes), 10)
        for scene in scenes:
            with self.subTest(scene.name):
                result = self.run_trevi(1, scene, "--dry-run")
                if any(f"TREVI_WITH_{part}=ON" in result.stderr for part in WITHOUT):
                    self.assertEqual(result.returncode, 2)
                else:
                    self.assertEqual(result.returncode, 0, result.stderr)
                    self.assertIn("particles", result.stdout)

    def test_small_scenes_run_to_their_end(self):
        scenes = sorted(INPUTS.glob("*_small.toml"))
        self.assertGreater(len(scenes), 5)
        for scene in scenes:
            with self.subTest(scene.name):
                self.run_well(2, scene, "--output", scene.stem)
                with open(self.folder / scene.stem / "series.csv", newline="", encoding="utf-8") as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual({row["particles"] for row in rows}, {rows[0]["particles"]})
                if "[[fountain]]" in scene.read_text():
                    self.assertGreater(max(float(row["top"]) for row in rows), float(rows[0]["top"]) + 0.5)


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""Bad inlets and drains through the whole program, as test_bad_input.py has it of the rest."""

from bad_scenes import GOOD, RefusedTest
from program import main


class BadFlow(RefusedTest):
    def test_inlets_in_solids(self):
        ball = "\n".join(GOOD) + "\n[[obstacle]]\ntype = 'sphere'\ncenter = [0.5, 0.5, 0.3]\nradius = 0.2\n"
        inlet = "[[inlet]]\ncenter = [0.65, 0.5, 0.3]\nradius = 0.15\nspeed = 1\n"
        self.assert_all_refused([*((at, text + inlet, ["scene.toml"],
                                    [f"scene.toml:{at} at (", "move it out of there"]) for at, text in (
                ("20: [[inlet]] center: the opening is in obstacle 0", ball),
                ("21: [[inlet]] center: the opening is in body 0", ball.replace("obstacle", "body") + "mass = 20\n"))),
            ("anderson", ball + "[density]\nmethod = 'anderson'\n", ["scene.toml"],
             ["scene.toml:21: [density] method: ", "no regard to obstacles"])], rank_counts=(1, 2))

    def test_openings_in_walls(self):
        opening = ("\n".join(GOOD)
                   + "\n[gravity]\n[[inlet]]\ntype = 'rectangle'\ncenter = [0.05, 0.5, 0.25]\nsize = [0.4, 0.4]\n"
                   "direction = [1, 0, 0]\nprofile = '0.5 + z'\n")
        drain = "\n".join(GOOD) + "\n[gravity]\n[[drain]]\nmin = [1.1, 0, 0]\nmax = [2, 1, 0.9]\nlevel = 0.5\n"
        bad = [("an expression", opening.replace("+ z", "+ q"), ["[[inlet]] profile: ", "give an expression of z, t"]),
               ("no number", opening.replace("+ z", "/ t"),
                ["[[inlet]] profile: ", "is not a finite number at z = 0.25 m, t = 0"]),
               ("at its top", opening.replace("0.5 + z", "z < 0.3 ? 1 : 0/0"),
                ["[[inlet]] profile: ", "is not a finite number at z = 0."]),
               *((f"{what[:6]} later", opening.replace("0.5 + z", f"t < 0.005 ? 1 : {value}"),
                  ["scene.toml:22: [[inlet]] profile: ", what])
                 for value, what in (("0/0", "is not a finite number at z = 0.1 m, t = 0.01 s"),
                                     ("1e5", "over the opening at 0.01 s"))),
               ("too fast", opening.replace("+ z", "+ 1e9"), ["[[inlet]] profile: ", "check the units"]),
               ("a speed, too", opening + "speed = 1\n", ["[[inlet]] profile: speed is given, too"]),
               ("askew", opening.replace("[1, 0, 0]", "[1, 0.1, 0]"), ["[[inlet]] direction: must lead straight out"]),
               ("away from the wall", opening.replace("0.05, 0.5", "0.5, 0.5"),
                ["[[inlet]] center: must be half a spacing"]),
               ("a level above", opening + "level = 0.9\n", ["[[inlet]] level: must be in the opening"]),
               ("without gravity", opening.replace("[gravity]", ""),
                ["inlet: with a profile or a level it needs the projection"]),
               ("both", drain + "flow = 1\n", ["[[drain]] flow: level is given, too"]),
               ("no wall", drain.replace("[2, 1, 0.9]", "[1.9, 1, 0.9]"),
                ["[[drain]] level: needs a box that lies on one"]),
               ("short", drain.replace("[1.1,", "[1.9,"), ["[[drain]] level: needs a box that reaches 0.8 m"]),
               ("a level outside", drain.replace("= 0.5", "= 0.95"), ["[[drain]] level: must be in the box"])]
        self.assert_all_refused([(name, text, ["scene.toml"], words) for name, text, words in bad], rank_counts=(1, 2))
        # 4 - 3.2 is a rounding error less than 0.8.
        long_enough = drain.replace("max = [2, 1, 1]", "max = [4, 1, 1]").replace("[1.1,", "[3.2,")
        (self.folder / "scene.toml").write_text(long_enough.replace("[2, 1, 0.9]", "[4, 1, 0.9]"))
        self.run_well(1, "scene.toml", "--dry-run")


if __name__ == "__main__":
    main()

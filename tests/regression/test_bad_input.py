#!/usr/bin/python3
"""Bad input through the whole program, on one and on two ranks: exit code 2, the message names file, line and key and
is printed once, nothing is written, and no rank is left waiting."""

import os
import subprocess
import unittest

import h5py
import numpy

from bad_scenes import GOOD, RefusedTest, scene_of_file, scene_with
from program import MPI_SETTINGS, TIME_LIMIT, WITHOUT, main

# name -> (line, its replacement, where and what the message must say)
BAD_LINES = {
    "unknown key": (5, "spacing = 0.1\nspacin = 0.1", ["scene.toml:6:", "spacin"]),
    "unknown table": (14, "[output.series]\nevery_steps = 1\n[swirl]", ["scene.toml:16:", "swirl"]),
    "wrong type": (5, "spacing = 'wide'", ["scene.toml:5:", "spacing"]),
    "negative spacing": (5, "spacing = -0.1", ["scene.toml:5:", "spacing"]),
    "cells past counting": (3, "max = [9000, 9000, 10000]", ["scene.toml:3:", "max", "2.25e+09 cells"]),
    "h > box": (6, "kernel_radius = 1.5", ["scene.toml:6:", "kernel_radius"]),
    "particles outside": (10, "max = [1, 1.4, 0.5]", ["scene.toml:10:", "particles", "max"]),
    "dt = 0": (12, "dt = 0", ["scene.toml:12:", "dt"]),
    "zero particles": (10, "max = [1, 0.01, 0.5]", ["scene.toml:", "particles"]),
    "nan": (12, "dt = nan", ["scene.toml:12:", "dt"]),
    "infinite velocity": (9, "min = [0, 0, 0]\nvelocity = [inf, 0, 0]", ["scene.toml:10:", "velocity"]),
    "not toml": (12, "dt = = 3", ["scene.toml:12"]),
    "one dimension": (2, "dimensions = 1\nmin = [0, 0, 0]", ["scene.toml:2:", "dimensions", "at least 2"]),
    "four dimensions": (2, "dimensions = 4\nmin = [0, 0, 0]", ["scene.toml:2:", "dimensions", "must be 2 or 3"]),
    "a pair in space": (3, "max = [2, 1]", ["scene.toml:3:", "max", "3 finite numbers"]),
    "a long name": (14, f"[[output.frames]]\nname = '{'a' * 300}'",
                    ["scene.toml:15:", "[[output.frames]] name", "at most 200"]),
    "no digit before the point": (12, "dt = .01", ["scene.toml:12: ", "digits on both sides of a point; write 0.01"]),
    "no digit behind it": (3, "max = [2, 1., 1]  # m", ["scene.toml:3: ", "write 1.0\n"]),
    "nor before an exponent": (12, "dt = -1.e-2", ["scene.toml:12: ", "write -1.0e-2"]),
}


class BadInput(RefusedTest):
    def test_good_scene_runs(self):
        (self.folder / "scene.toml").write_text("\n".join(GOOD))
        self.run_well(2, "scene.toml")
        self.assertEqual(len((self.folder / "out/scene/series.csv").read_text().splitlines()), 4)

    def test_what_two_dimensions_have_not(self):
        flat = [line.replace("min = [0, 0, 0]", "min = [0, 0]") for line in GOOD]
        flat[1] = "dimensions = 2\nmin = [0, 0]"
        ball = "[[obstacle]]\ntype = 'sphere'\ncenter = [1, 0.5]\nradius = 0.2"
        rod = "[[obstacle]]\ntype = 'cylinder'\ncenter = [1, 0.5]\nradius = 0.2\n"
        cases = {"periodic y": (3, "periodic = ['y']", ["scene.toml:5:", "periodic", "one spacing thick"]),
                 "slabs across y": (3, "slab_axis = 'y'", ["scene.toml:5:", "slab_axis", "leave it out"]),
                 "velocity along y": (10, "velocity = [1, 1, 0]", ["scene.toml:12:", "velocity", "0 along y"]),
                 "three texts": (10, "velocity = ['x', 'x', '0']", ["scene.toml:12:", "velocity", "two texts"]),
                 "gravity along y": (15, "[gravity]\nacceleration = [0, 1, -9]", ["scene.toml:18:", "acceleration"]),
                 "ball": (15, ball, ["scene.toml:18:", "type", 'type = "cylinder"']),
                 "rod across": (15, rod + "axis = [1, 0, 0]", ["scene.toml:21:", "axis", "along y"]),
                 "a height": (15, rod + "height = 0.2", ["scene.toml:21:", "height", "goes on along y; leave it out"]),
                 "turned out of the plane": (15, rod + "rotate = [10, 0, 0]", ["scene.toml:21:", "rotate", "about y"]),
                 "round basin": (15, "[[obstacle]]\ntype = 'basin'\ncenter = [1, 0.5]\nradius = 0.3\nheight = 0.3",
                                 ["scene.toml:18:", "type", "give size"])}
        self.assert_all_refused([(name, "\n".join([*flat[:line], text, *flat[line:]]) + "\n", ["scene.toml"], words)
                                 for name, (line, text, words) in cases.items()])

    def test_a_file_off_the_plane(self):
        def cloud(folder):
            with h5py.File(folder / "cloud.h5", "w") as file:
                file["particles/position"] = numpy.array([[0.5, 0, 0.5], [0.6, 0.01, 0.5]])
        self.assert_all_refused([("off the plane", scene_of_file().replace("[domain]", "[domain]\ndimensions = 2"),
                                  ["scene.toml"], ["cloud.h5", "row 1", "write 0 for y"], cloud)])

    def test_each_bad_line(self):
        self.assert_all_refused([(name, scene_with(line, text), ["scene.toml"], words)
                                 for name, (line, text, words) in BAD_LINES.items()])

    def test_all_problems_at_once(self):
        text = scene_with(12, "dt = -1").replace("spacing = 0.1", "spacing = 'x'") + "[walls]\nbounce = 2\n"
        self.assert_all_refused([("all", text, ["scene.toml", "--set", "time.end=-3"],
                                  ["scene.toml:5:", "scene.toml:12:", "scene.toml:17:", "bounce", "time.end"])])

    def test_command_line(self):
        good = "\n".join(GOOD)
        self.assert_all_refused([(f"{k}", good, arguments, words) for k, (arguments, words) in enumerate((
            (["none.toml"], ["none.toml"]),
            ([], ["usage"]),
            (["scene.toml", "--set", "time.dt"], ["time.dt"]),
            (["scene.toml", "--set", "time.dt=.01"], ["--set time.dt=.01: ", "write 0.01"]),
            (["scene.toml", "--set", "time.dt=1.e-2"], ["--set time.dt=1.e-2: ", "write 1.0e-2"]),
            (["scene.toml", "--set", "domain.max=[2, 1, .5]"], ["--set domain.max=[2, 1, .5]: ", "write 0.5"]),
            (["scene.toml", "--set", "fluid.colour=3"], ["fluid.colour"]),
            (["scene.toml", "--fast"], ["--fast"]),
            (["scene.toml", "--steps", "-3"], ["--steps:"]),
            (["scene.toml", "--steps", "99999999999999999999"], ["--steps:", "999999999999999"]),
            (["scene.toml", "--restart", ""], ["--restart:", "empty"]),
            (["scene.toml", "-dry-run"], ["did you mean --dry-run?"]),
            (["scene.toml", "-output=k"], ["did you mean --output=k?"]),
            (["scene.toml", "-options_file", "none"], ["none: cannot be read"]),
            (["/dev/zero"], ["/dev/zero: holds more than 64 MB"]),
            (["."], [".: cannot be read", "Is a directory"]),
            (["scene.toml", "--restart", "none.h5"], ["none.h5"]),
            (["scene.toml", "--restart", "scene.toml"], ["scene.toml"]),
        ))])

    def test_a_pipe_that_nobody_writes_to(self):
        self.assert_all_refused([("pipe", "", ["scene.toml"], ["scene.toml: a pipe that nobody has written to"],
                                  lambda folder: ((folder / "scene.toml").unlink(), os.mkfifo(folder / "scene.toml")))],
                                rank_counts=(2,))

    def test_a_pipe_that_is_written_to(self):
        (self.folder / "scene.toml").write_text("\n".join(GOOD))
        command = 'exec "$0" --dry-run <(sleep 1; cat scene.toml)'
        run = subprocess.run(["bash", "-c", command, str(self.trevi)], cwd=self.folder,
                             env={**os.environ, **MPI_SETTINGS}, capture_output=True, text=True, timeout=TIME_LIMIT,
                             check=False)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_a_preview_replaces_previews_only(self):
        text = "\n".join(GOOD) + "\n[[fountain]]\ncenter = [0.5, 0.5]\n"
        self.assert_all_refused([("scene", text, ["scene.toml", "--preview", "scene.toml"],
                                  ["--preview scene.toml", "is no preview"])])
        (self.folder / "scene.toml").write_text(text)
        for _ in range(2):
            self.run_well(1, "scene.toml", "--preview", "curves.csv")

    def test_a_forgotten_stop_file(self):
        def prepare(folder):
            (folder / "out/scene").mkdir(parents=True)
            (folder / "out/scene/stop").touch()
        self.assert_all_refused([("stop", "\n".join(GOOD), ["scene.toml"], ["out/scene/stop:", "remove it"], prepare)])

    def test_output_that_cannot_be(self):
        def file(name):
            def prepare(folder):
                path = folder / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()
            return prepare
        self.assert_all_refused([(name, "\n".join(GOOD), ["scene.toml", *arguments], words, prepare)
                                 for name, arguments, words, prepare in (
            ("a file", ["--output", "o"], ["o: cannot be the folder", "is a file", "--output"], file("o")),
            ("a file for frames", [], ["out/scene/vtu: cannot be the folder"], file("out/scene/vtu")),
            ("too long", ["--output", "o" * 300], ["File name too long", "--output"], None),
            ("frames of another run", [], ["another run (vtu/particles_000000.pvtu)"],
             file("out/scene/vtu/particles_000000.pvtu")),
        )])

    def test_more_memory_than_there_is(self):
        text = "\n".join(GOOD).replace("spacing = 0.1", "spacing = 0.001").replace("radius = 0.2", "radius = 0.002")
        (self.folder / "scene.toml").write_text(text)
        limited = subprocess.run(["bash", "-c", 'ulimit -v 8000000; exec "$0" "$@"', self.trevi, "scene.toml"],
                                 cwd=self.folder, env={**os.environ, **MPI_SETTINGS}, capture_output=True, text=True,
                                 timeout=TIME_LIMIT, check=False)
        self.assertEqual(limited.returncode, 2, limited.stderr)
        self.assertRegex(limited.stderr,
                         r"scene.toml: 500000000 particles on this machine need 40.0 GB, and .* are free")
        self.assertFalse((self.folder / "out").exists())

    def test_more_ranks_than_planes(self):
        text = "\n".join(GOOD).replace("max = [2, 1, 1]", "max = [1, 1, 1]")
        self.assert_all_refused([("planes", text, ["scene.toml"], ["scene.toml:3: [domain] max: ", "5 cell planes",
                                                                   "6 ranks", 'ranks = "auto"'])], rank_counts=(6,))

    def test_ranks_that_cannot_be(self):
        cases = {"a word": ("'car'", [3, "two whole numbers", '"auto"']),
                 "three": ("[1, 1, 1]", [3, "two whole numbers"]),
                 "parts of ranks": ("[0.5, 4]", [3, "two whole numbers"]), "none": ("[0, 2]", [3, "two whole numbers"]),
                 "too few": ("[1, 1]", [3, "are 1 ranks, and this run has 2", "set domain.ranks"]),
                 "too many": ("[2, 2]", [3, "are 4 ranks, and this run has 2", "start it on 4"])}
        self.assert_all_refused([(name, scene_with(2, f"min = [0, 0, 0]\nranks = {value}"), ["scene.toml"],
                                  [f"scene.toml:{line}: [domain] ranks: ", *words])
                                 for name, (value, (line, *words)) in cases.items()], rank_counts=(2,))
        text = scene_with(2, "min = [0, 0, 0]\nranks = [1, 6]")
        self.assert_all_refused([("rows", text, ["scene.toml"], ["scene.toml:3: [domain] ranks: ", "5 rows", "6 parts",
                                                                 "use at most 5"])], rank_counts=(6,))
        text = scene_with(2, "min = [0, 0, 0]\nranks = 'auto'").replace("max = [2, 1, 1]", "max = [0.6, 0.6, 1]")
        text = text.replace("max = [1, 1, 0.5]", "max = [0.6, 0.6, 0.5]")
        self.assert_all_refused([("cells", text, ["scene.toml"], ["scene.toml:3: [domain] ranks: ", "3 cell planes",
                                                                  "10 ranks"])], rank_counts=(10,))

    def test_parts_that_are_not_built(self):
        fountain = "\n[[fountain]]\ncenter = [1, 0.5]\nspeed_range = [1, 2]\nmusic = 'song."
        cases = {"VTK": ("\n[output.vtu]\nevery = 1", [], ["[output.vtu]", "[output.vtkhdf]"]),
                 "MUSIC": (fountain + "mid'", [], ["[[fountain]] music", "song.mid", "leave"]),
                 "SOUND": (fountain + "wav'", [], ["[[fountain]] music", "song.wav", ".txt"]),
                 "LIVE": ("", ["--view", "localhost:5555"], ["--view", "leave"])}
        if not WITHOUT:
            self.skipTest("all parts are built")
        for part in WITHOUT:
            if part == "SOUND" and "MUSIC" in WITHOUT:
                continue
            more, arguments, words = cases[part]
            self.assert_all_refused([(part, "\n".join(GOOD) + more, ["scene.toml", *arguments],
                                      [f"-DTREVI_WITH_{part}=ON", *words],
                                      lambda folder: [(folder / f"song.{end}").touch() for end in ("mid", "wav")])])

    @unittest.skipIf("VTK" in WITHOUT, "this build reads no meshes")
    def test_meshes(self):
        corners = [(x, y, z) for x in (0.3, 0.7) for y in (0.3, 0.7) for z in (0.1, 0.4)]
        broken = [("nan", y, z) if k == 3 else (x, y, z) for k, (x, y, z) in enumerate(corners)]
        far = [("1e39", y, z) if k == 3 else (x, y, z) for k, (x, y, z) in enumerate(corners)]
        faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6),
                 (0, 6, 4), (1, 5, 7), (1, 7, 3)]

        def obj(points):
            return "".join([f"v {x} {y} {z}\n" for x, y, z in points]
                           + ["f " + " ".join(str(k + 1) for k in face) + "\n" for face in faces]).encode()

        def stl(count):
            numbers = numpy.zeros((12, 50), numpy.uint8)
            numbers[:, 12:48] = numpy.array(corners, "<f4")[numpy.array(faces)].reshape(12, 9).view(numpy.uint8)
            return bytes(80) + numpy.array([count], "<u4").tobytes() + numbers.tobytes()

        def ply(count, corner, points=corners):
            head = (f"ply\nformat ascii 1.0\nelement vertex {count}\n"
                    "property float x\nproperty float y\nproperty float z\n"
                    "element face 12\nproperty list uchar int vertex_indices\nend_header\n")
            return "".join([head, *(f"{x} {y} {z}\n" for x, y, z in points), f"3 0 1 {corner}\n",
                            *(f"3 {a} {b} {c}\n" for a, b, c in faces[1:])]).encode()

        def bytes_of_ply(count, order="<"):
            kind = b"binary_little_endian" if order == "<" else b"binary_big_endian"
            head = ply(count, 3).split(b"end_header")[0].replace(b"ascii", kind)
            numbers = numpy.zeros((12, 13), numpy.uint8)
            numbers[:, 0], numbers[:, 1:] = 3, numpy.array(faces, order + "i4").view(numpy.uint8)
            return head + b"end_header\n" + numpy.array(corners, order + "f4").tobytes() + numbers.tobytes()
        text = "\n".join(GOOD) + "\n[[obstacle]]\ntype = 'mesh'\npath = '{}'\n"

        def case(name, data, words):
            return (name, text.format(name), ["scene.toml"], [f"scene.toml:16: [[obstacle]] path: {name}:", *words],
                    lambda folder: (folder / name).write_bytes(data))
        self.assert_all_refused([
            case("nan.obj", obj(broken), ["nan.obj:4: a vertex is not three finite numbers"]),
            case("far.obj", obj(far), ["far.obj:4: a vertex is not three finite numbers"]),
            case("word.obj", obj(corners).replace(b"v 0.7", b" v\tO.7", 1), ["word.obj:5: a vertex is not three"]),
            case("tail.obj", obj(corners).replace(b"0.4\n", b"0.4x\n", 1), ["tail.obj:2: a vertex is not three"]),
            case("nan.ply", ply(8, 3, broken), ["vertex 3 (line 13) has x = nan, which is no finite number"]),
            case("word.ply", ply(8, 3).replace(b"0.3 0.3 0.1", b"abc 0.3 0.1"), ['line 10: "abc" is no number']),
            case("short.ply", ply(8, 3)[:-3] + b"\n", ["line 29 ends before all of face 11 is told"]),
            case("long.ply", ply(8, "3 4"), ["line 18 has more than face 0"]),
            case("many.ply", ply(8, 3).replace(b"3 0 1 3", b"200 0 1 3"), ["line 18 ends before all of face 0"]),
            case("fewer.ply", ply(8, 3)[:-16], ['it ends after 10 of the 12 of "element face"']),
            case("more.ply", ply(7, 3, corners[:7]), ["vertex_indices = 7, which is no vertex of it"]),
            case("rest.ply", ply(8, 3).replace(b"face 12", b"face 9"), ["more in it than the 8 vertices and 9 faces"]),
            case("flat.ply", ply(8, 3).replace(b"property float z\n", b""), ["its vertices have no z"]),
            case("listed.ply", ply(8, 3).replace(b"float z", b"list uchar int w\nproperty float z"), ['a list, "w"']),
            case("bytes.ply", ply(8, 3).replace(b"ascii", b"binary_little_endian"), ["cannot be read as a mesh"]),
            case("half.ply", bytes_of_ply(8)[:-10], ['it ends after 11 of the 12 of "element face"']),
            case("crowd_of_bytes.ply", bytes_of_ply(9), ["cannot be read as a mesh"]),
            case("solid.stl", b"solid" + stl(10)[5:], ["says that it has 10 triangles", "bytes for 12;"]),
            case("hole.obj", obj(corners).replace(b"0.4\n", b"\0\0\0\n", 1), ["hole.obj:2: a vertex is not three"]),
            case("hole.ply", ply(8, 3).replace(b"0.3 0.3 0.1", b"\0\0\0 0.3 0.1"), ["is no number"]),
            case("part.ply", ply(8, 2.5), ["vertex_indices = 2.5, which is no whole number"]),
            case("fewer.stl", stl(10), ["says that it has 10 triangles", "bytes for 12;"]),
            case("false.stl", stl(4_000_000_000), ["says that it has 4000000000 triangles", "bytes for 12;"]),
            case("cut.stl", stl(12)[:-70], ["says that it has 12 triangles", "bytes for 10 and a part;"]),
            case("crowd.ply", ply(4_000_000_000, 3), ['its "element vertex 4000000000" is more than its']),
            case("less.ply", ply(-8, 3), ['its "element vertex -8"']),
            case("far.ply", ply(8, 77), ["face 0 (line 18) has vertex_indices = 77, which is no vertex of it"]),
            case("text.ply", b"hello\n", ["cannot be read as a mesh"]),
            case("empty.ply", b"", ["cannot be read as a mesh: it does not begin as a PLY file"]),
            case("headless.ply", b"ply\nformat ascii 1.0\nend_header\n", ["not one of vertices and then of faces"]),
            case("open.obj", obj(corners)[:-8], ["not closed: 3 open edges"]),
            case("sheet.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n", ["encloses no volume"]),
            case("empty.obj", b"", ["holds no triangles"])], rank_counts=(2,))
        ball = "\n[[obstacle]]\ntype = 'sphere'\ncenter = [1, 0.5, 0.5]\nradius = 0.1\n"
        speck = "\n[[obstacle]]\ntype = 'mesh'\npath = 'box.obj'\nscale = 1e-30\n"
        self.assert_all_refused([
            ("twins", "\n".join(GOOD) + ball + ball, ["scene.toml"], ["same as that of line", "would count twice"]),
            ("speck", "\n".join(GOOD) + speck, ["scene.toml"], ["less than a thousandth of the spacing"],
             lambda folder: (folder / "box.obj").write_bytes(obj(corners)))], rank_counts=(2,))
        (self.folder / "circle.ply").symlink_to("circle.ply")
        with (self.folder / "endless.stl").open("wb") as file:
            file.truncate(2**43)
        for name, words in (("circle.ply", "no such file"),
                            ("endless.stl", "triangles of so large a file need 35184.4 GB")):
            (self.folder / "scene.toml").write_text(text.format(name))
            refused = self.run_trevi(2, "scene.toml")
            self.assertEqual(refused.returncode, 2, refused.stderr)
            self.assertIn(f"scene.toml:16: [[obstacle]] path: {name}: {words}", refused.stderr)
        for name, data in (("whole.stl", stl(12)), ("solid.stl", b"solid" + stl(12)[5:]), ("whole.ply", ply(8, 3)),
                           ("bytes.ply", bytes_of_ply(8) + b"\n"), ("turned.ply", bytes_of_ply(8, ">")),
                           ("whole.obj", obj(corners))):
            (self.folder / name).write_bytes(data)
            (self.folder / "scene.toml").write_text(text.format(name))
            self.run_well(2, "scene.toml", "--output", name + ".out")

    def test_motions(self):
        text = ("\n".join(GOOD) + "\n[[obstacle]]\ntype = 'sphere'\ncenter = [0.5, 0.5, 0.3]\nradius = 0.2\n"
                "motion = 'way.csv'\n")
        self.assert_all_refused([(name, text, ["scene.toml"], ["scene.toml:16: [[obstacle]] motion: way.csv:", *words],
                                  lambda folder, data=data: (folder / "way.csv").write_bytes(data))
                                 for name, data, words in (
            *((name, b"0,0.5,0.5,0.3\n" + line, ["2: not four numbers"])
              for name, line in (("nan", b"1,nan,0,0\n"), ("time", b"nan,0,0,0\n"))),
            ("letters of another kind", b"\xe9\xff\n0,0.5,0.5,0.3\n", ["1: not four numbers"]),
            ("backwards", b"\xef\xbb\xbf1,0.5,0.5,0.3\n0,0.5,0.5,0.3\n", ["2: not later than the line before"]),
            ("far", b"0,0.5,0.5,0.3\n0.01,1e300,0.5,0.3\n", ["2: further from the line before than 10000 m/s"]),
            ("alone", b"0,0.5,0.5,0.3\n", ["fewer than two times and places"]))], rank_counts=(2,))

        rod = ("\n".join(GOOD) + "\n[[obstacle]]\ntype = 'cylinder'\ncenter = [0.5, 0.5, 0.3]\n"
               "radius = 0.1\nheight = 0.2\n")
        self.assert_all_refused([(f"axis {axis}", f"{rod}axis = [0, {axis}, {axis}]\n", ["scene.toml"],
                                  ["scene.toml:21: [[obstacle]] axis: must not be zero"])
                                 for axis in ("0", "1.7e308")], rank_counts=(1,))
        for k, axis in enumerate(("1e-200", "1e308")):  # directions like any other
            (self.folder / "scene.toml").write_text(f"{rod}axis = [0, {axis}, {axis}]\n")
            self.run_well(1, "scene.toml", "--output", f"axis{k}")
        ball = "\n".join(GOOD) + "\n[[obstacle]]\ntype = 'sphere'\ncenter = [0.5, 0.5, 0.3]\nradius = 0.2\n"
        self.assert_all_refused([(key, f"{ball}{key} = [0, 1e300, 0]\n", ["scene.toml"],
                                  [f"scene.toml:20: [[obstacle]] {key}: must be at most 10000"])
                                 for key in ("velocity", "angular_velocity")], rank_counts=(2,))
        self.assert_all_refused([
            ("far away", f"{ball}motion = [[0, 1e300, 0, 0], [1, 1e300, 0, 0]]\n", ["scene.toml"],
             ["scene.toml:20: [[obstacle]] motion: must be two times and places"]),
            ("large", ball.replace("\nradius = 0.2", "\nradius = 1e5"), ["scene.toml"],
             ["scene.toml:16: [[obstacle]]: it is 2e+05 m long", "make it smaller"]),
            ("larger", ball.replace("\nradius = 0.2", "\nradius = 1e300"), ["scene.toml"],
             ["scene.toml:16: [[obstacle]]: it is 2e+300 m long", "make it smaller"])], rank_counts=(1, 2))

    def test_what_bodies_and_files_of_obstacles_show(self):
        good = "\n".join([*GOOD, "[gravity]\n"])
        ball = good + "[[body]]\ntype = 'sphere'\ncenter = [1.5, 0.5, 0.5]\nradius = 0.2\n"
        line = ball + "density = 500\nmooring = {{anchor = [1.5, 0.5, {}], stiffness = 10{}}}\n"
        drain = good + "[[drain]]\nmin = [1.1, 0, 0]\nmax = [2, 1, 0.9]\nlevel = 0.5\n[[obstacle]]\ntype = 'box'\n"
        bad = [("heavy", ball + "mass = 1e300\n", ["scene.toml:17: [[body]]: ", "check the units of mass"]),
               ("far", line.format("1e200", ""), ["scene.toml:17: [[body]]: ", "whose anchor is inf m away"]),
               ("long", line.format("0.5", ", length = 1e300"), ["scene.toml:17: [[body]]: ", "a length of 1e+300 m"]),
               ("in", drain + "center = [1.6, 0.5, 0.1]\nsize = [1, 1, 1]\n",
                [":17: [[drain]] level: obstacle 0 is in its"])]
        for k, ranks in ((0, 3), (2, 5)):
            self.assert_all_refused([(name, text, ["scene.toml"], words) for name, text, words in bad[k:k + 2]],
                                    (ranks,))

    def test_gauges_once_obstacles_are_known(self):
        text = "\n".join(GOOD) + "\n[[obstacle]]\ntype = 'sphere'\ncenter = [0.5, 0.5, 0.3]\nradius = {}\n[[gauge]]\n{}"
        disc = "type = 'pressure'\nradius = 0.1\ncenter = [0.5, 0.5, {}]\nnormal = [0, 0, {}]\n".format
        inside = "type = '{}'\ncenter = [0.5, 0.5, 0.3]\n".format
        self.assert_all_refused([(gauge, text.format(radius, gauge), ["scene.toml"], [":20: [[gauge]] center: ", words])
                                 for radius, gauge, words in (
                                     *((0.2, disc(*at), "is not on a wall") for at in ((0.7, 1), (0.3, 1), (0.5, -1))),
                                     *((0.9, inside(type), "no water") for type in ("velocity", "height")))], (1, 2))

    def test_particle_files(self):
        inside = numpy.full((40, 3), 0.5)
        outside, broken = inside.copy(), inside.copy()
        outside[7, 1] = 1.5
        broken[39, 2] = numpy.nan

        def file_of(position, ids):
            def write(folder):
                with h5py.File(folder / "cloud.h5", "w") as file:
                    file["particles/position"], file["particles/id"] = position, numpy.array(ids)
            return write

        self.assert_all_refused([(name, scene_of_file(), ["scene.toml"], words, prepare) for name, words, prepare in (
            ("outside", ["outside the box"], file_of(outside, range(40))),
            ("broken", ["cloud.h5"], file_of(broken, range(40))),
            ("twins", ["cloud.h5", "3"], file_of(inside, [*range(39), 3])),
            ("flat", ["cloud.h5"], file_of(inside[:, :2], range(40))),
            ("missing", ["scene.toml:7: [[particles]] path: cloud.h5"], None),
        )])
        if "MUSIC" not in WITHOUT:
            self.assert_all_refused([("music", "\n".join(GOOD)
                                      + "\n[[fountain]]\ncenter = [1, 0.5]\nmusic = 'gone.txt'\n",
                                      ["scene.toml"], ["scene.toml:16: [[fountain]] music: gone.txt: cannot be read"])])


if __name__ == "__main__":
    main()

#!/usr/bin/python3
"""The recipe for Spack (jobs/cluster/spack) against the build: it depends on what CMakeLists.txt looks for, where a part
needs it on that part's variant, with no lower version than CMake asks for; and each part that CMake can leave out is a
variant of the same default.

The recipe is run as Python with a stand-in for Spack, so that what it says is read from it as Spack would.
"""

import re
import sys
import types
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RECIPE = ROOT / "jobs/cluster/spack/packages/trevi/package.py"
# Names that CMake and Spack give the same library. OpenMP comes with the compiler; X11 is only looked for.
SPACK_NAMES = {"MPI": "mpi", "Eigen3": "eigen", "fmt": "fmt", "tomlplusplus": "tomlplusplus", "CLI11": "cli11",
               "nlohmann_json": "nlohmann-json", "PkgConfig": "pkgconfig", "PNG": "libpng", "petsc": "petsc",
               "hdf5": "hdf5", "muparser": "muparser", "libhwy": "highway", "sndfile": "libsndfile", "zmq": "libzmq",
               "zmq.hpp": "cppzmq", "VTK": "vtk"}
NOT_ASKED_FOR = {"OpenMP", "X11"}
# Headers without a file of CMake or pkg-config; Ninja and the compilers are tools.
INCLUDED = {"Random123/philox.h": "random123"}
TOOLS = {"c", "cxx", "cmake", "ninja"}
PARTS = {"TREVI_WITH_VTK": "vtk", "TREVI_WITH_VIEW": "view", "TREVI_WITH_MUSIC": "music", "TREVI_WITH_SOUND": "sound",
         "TREVI_WITH_LIVE": "live"}


class Recipe:
    """What the recipe tells Spack: {package: [(version, variants, when)]}, {variant: default}."""

    def __init__(self, text):
        self.dependencies, self.variants, self.version = {}, {}, None
        stand_in = types.ModuleType("spack.package")
        stand_in.CMakePackage = type("CMakePackage", (), {})
        stand_in.depends_on = self.depends_on
        stand_in.variant = lambda name, default=None, **_: self.variants.update({name: default})
        stand_in.version = lambda number, **_: setattr(self, "version", number)
        for name in ("license", "conflicts", "generator"):
            setattr(stand_in, name, lambda *_, **__: None)
        before = {name: sys.modules.get(name) for name in ("spack", "spack.package")}
        sys.modules.update({"spack": types.ModuleType("spack"), "spack.package": stand_in})
        try:
            exec(compile(text, str(RECIPE), "exec"), {"__file__": str(RECIPE), "__name__": "package"})
        finally:
            for name, module in before.items():
                sys.modules.pop(name) if module is None else sys.modules.update({name: module})

    def depends_on(self, spec, when="", **_):
        name, version, variants = re.fullmatch(r"([a-z][\w-]*?)(?:@([\d.]+):?)?([+~].*)?", spec).groups()
        self.dependencies.setdefault(name, []).append((version, variants or "", when))


def asked_by_cmake(text):
    """{package of Spack: (version, the part that needs it)} of what CMakeLists.txt looks for."""
    found, part = {}, [""]
    for line in text.splitlines():
        line = line.split("#")[0]
        if opened := re.match(r"\s*if\((\w+)", line):
            part.append(opened[1] if opened[1] in PARTS else part[-1])
        if re.match(r"\s*endif\(", line):
            part.pop()
        asked = re.match(r"\s*find_package\((\w+)(?: ([\d.]+))?", line)
        names = [(asked[1], asked[2])] if asked else []
        if modules := re.match(r"\s*pkg_(?:check|search)_modules?\(\w+ REQUIRED IMPORTED_TARGET (.*)\)", line):
            names = [(modules[1].split()[-1], None)]
        if other := re.match(r"\s*find_(?:path|library)\(\w+ ([\w.]+) REQUIRED\)", line):
            names = [(other[1], None)]
        for name, version in names:
            if name not in NOT_ASKED_FOR:
                found[SPACK_NAMES[name]] = (version, PARTS.get(part[-1], ""))
    return found


def numbers(version):
    return [int(part) for part in version.split(".")]


class SpackRecipe(unittest.TestCase):
    def setUp(self):
        self.recipe = Recipe(RECIPE.read_text())
        self.cmake = (ROOT / "CMakeLists.txt").read_text()
        self.asked = asked_by_cmake(self.cmake)

    def test_dependencies_are_those_of_the_build(self):
        included = {package for header, package in INCLUDED.items()
                    if any(header in source.read_text() for source in (ROOT / "src").rglob("*.[ch]pp"))}
        self.assertEqual(set(self.recipe.dependencies) - TOOLS, set(self.asked) | included)
        self.assertEqual(TOOLS - set(self.recipe.dependencies), set())

    def test_a_part_that_is_left_out_needs_nothing(self):
        for package, (_, part) in self.asked.items():
            with self.subTest(package):
                whens = [when for _, _, when in self.recipe.dependencies[package]]
                self.assertIn(f"+{part}" if part else "", whens)

    def test_versions_are_not_below_those_of_the_build(self):
        for package, (version, _) in self.asked.items():
            given = [stated for stated, _, _ in self.recipe.dependencies[package] if stated]
            if version:
                with self.subTest(package):
                    self.assertTrue(given, f"CMake asks for {version} of it")
                    self.assertGreaterEqual(numbers(given[0]), numbers(version))
        cmake = re.search(r"cmake_minimum_required\(VERSION ([\d.]+)\)", self.cmake)[1]
        self.assertEqual(self.recipe.dependencies["cmake"][0][0], cmake)

    def test_libraries_have_mpi_and_real_numbers(self):
        self.assertIn("+mpi", self.recipe.dependencies["hdf5"][0][1])
        self.assertIn("~complex+double", self.recipe.dependencies["petsc"][0][1])

    def test_variants_are_the_parts(self):
        options = set(re.findall(r"option\((TREVI_WITH_\w+)", self.cmake)) - {"TREVI_WITH_PYTHON"}
        self.assertEqual(options, set(PARTS))
        self.assertEqual(set(self.recipe.variants), set(PARTS.values()))
        text = RECIPE.read_text()
        self.assertEqual(set(re.search(r"parts = \((.*?)\)", text)[1].replace('"', "").split(", ")), set(PARTS.values()))

    def test_version_is_that_of_the_project(self):
        self.assertEqual(self.recipe.version, re.search(r"project\(trevi VERSION ([\d.]+)", self.cmake)[1])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""Builds tests/embed against an install tree of this build, as somebody outside would, and runs it on 1 and 2 ranks. What
fountain.cpp fills by hand has the bits and the rows of the scene beside it.

The tree is moved after it was made, and the programs in it must still run: nothing may point into the build folder.
"""

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np


def call(*command, **more):
    run = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=250, **more)
    if run.returncode:
        sys.exit(f"{' '.join(map(str, command))}: exit code {run.returncode}\n{run.stdout}{run.stderr}")
    return run.stdout


def install(cmake, build, work):
    """The install tree, away from where it was made."""
    call(cmake, "--install", build, "--prefix", work / "first")
    tree = work / "moved"
    (work / "first").rename(tree)
    wanted = ["bin/trevi", "include/trevi/session.hpp", "lib*/cmake/Trevi/TreviConfig.cmake",
              "share/trevi/inputs/fountain.toml", "share/trevi/inputs/ode_to_joy.txt",
              "share/trevi/examples/embed/main.cpp"]
    missing = [name for name in wanted if not any(tree.glob(name))]
    if missing:
        sys.exit(f"not installed: {', '.join(missing)}")
    for text in tree.rglob("*.cmake"):
        if str(build) in text.read_text():
            sys.exit(f"{text} points into the build folder")
    return tree


def check_programs(tree, mpiexec):
    # The build's own library must not be found by accident.
    needed = call("ldd", tree / "bin/trevi")
    own = next(line for line in needed.splitlines() if "libtrevi.so" in line)
    if str(tree) not in os.path.realpath(own.split("=>")[1].split()[0]):
        sys.exit(f"bin/trevi loads another library: {own}")
    call(mpiexec, "-n", 2, tree / "bin/trevi", tree / "share/trevi/inputs/falling_cube_small.toml", "--dry-run")


def check_python(tree, mpiexec):
    """The module finds the library of the tree, if it was built."""
    folder = tree / "lib/python3/dist-packages"
    if not folder.exists():
        return
    script = "import sys, trevi; s = trevi.make_solver(trevi.read_scene(sys.argv[1])); s.run(steps=3); sys.stdout.write(f'{s.steps}\\n')"
    said = call(mpiexec, "-n", 2, "/usr/bin/python3", "-c", script, tree / "share/trevi/inputs/falling_cube_small.toml",
                env=os.environ | {"PYTHONPATH": str(folder)})
    if said != "3\n3\n":
        sys.exit(f"the Python module says {said}")


def check_embed(arguments, tree, work):
    outside = shutil.copytree(tree / "share/trevi/examples/embed", work / "outside")
    call(arguments.cmake, "-S", outside, "-B", work / "build", f"-DCMAKE_PREFIX_PATH={tree}",
         f"-DCMAKE_CXX_COMPILER={arguments.compiler}", f"-DCMAKE_CXX_FLAGS={arguments.flags}")
    call(arguments.cmake, "--build", work / "build")
    said = {ranks: call(arguments.mpiexec, "-n", ranks, work / "build/embed") for ranks in (1, 2)}
    if not said[1].strip() or said[1] != said[2]:
        sys.exit(f"1 and 2 ranks print\n{said[1]}and\n{said[2]}")
    print(said[1], end="")


def run_of(folder):
    """The last state of a run in the order of its ids, and its rows but for the time and the balance of this machine."""
    with h5py.File(folder / "checkpoint_000030.h5") as file:
        state = [file[f"particles/{name}"][:] for name in ("id", "position", "velocity")]
    with open(folder / "series.csv", encoding="utf-8") as file:
        rows = [{key: cell for key, cell in row.items() if key not in ("imbalance", "wall_seconds")} for row in csv.DictReader(file)]
    return state, rows


def check_fountain(arguments, tree, work):
    scene = tree / "share/trevi/examples/embed/fountain.toml"
    call(arguments.mpiexec, "-n", 2, tree / "bin/trevi", scene, "--output", work / "scene")
    expected, rows = run_of(work / "scene")
    for ranks in (1, 2):
        folder = work / f"fountain_{ranks}"
        call(arguments.mpiexec, "-n", ranks, work / "build/fountain", folder)
        state, told = run_of(folder)
        if not all(np.array_equal(one, other) for one, other in zip(state, expected)):
            sys.exit(f"fountain.cpp has other bits than fountain.toml on {ranks} ranks")
        if told != rows or len(rows) != 7:
            sys.exit(f"fountain.cpp has other rows than fountain.toml on {ranks} ranks:\n{told}\n{rows}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="folder of the build")
    parser.add_argument("mpiexec")
    parser.add_argument("--cmake", default="cmake")
    parser.add_argument("--compiler", default="c++")
    parser.add_argument("--flags", default="", help="of the compiler, as the build has them")
    arguments = parser.parse_args()
    os.environ.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1",
                      OMPI_MCA_hwloc_base_binding_policy="none")
    # The output folder of a run must not land in the build, and the tree must not lie in it when it is searched.
    with tempfile.TemporaryDirectory(prefix="trevi_embed_") as folder:
        work = Path(folder).resolve()
        tree = install(arguments.cmake, arguments.build.resolve(), work)
        check_programs(tree, arguments.mpiexec)
        check_python(tree, arguments.mpiexec)
        check_embed(arguments, tree, work)
        check_fountain(arguments, tree, work)


if __name__ == "__main__":
    main()

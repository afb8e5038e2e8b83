"""Spack's recipe of Trevi: what is built is the checkout that this file is in.

spack repo add jobs/cluster/spack && spack install trevi
"""

from pathlib import Path

from spack.package import *


class Trevi(CMakePackage):
    """Water by position based fluids on any number of MPI ranks: the same bits on any number of ranks and threads, exact
    restart, and a stated error for each second of run time."""

    git = f"file://{Path(__file__).resolve().parents[5]}"
    license("BSD-3-Clause")
    version("2.0.0", branch="main")

    variant("vtk", default=True, description="VTU output")
    variant("view", default=False, when="+vtk", description="the viewer trevi-view")
    variant("music", default=True, description="fountains that play scores, MIDI files and live sound")
    variant("sound", default=True, when="+music", description="fountains that follow sound files")
    variant("live", default=True, description="runs that can be watched live")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("eigen@3.4")
    depends_on("petsc@3.18:~complex+double~int64")
    depends_on("hdf5@1.10:+mpi")
    depends_on("highway@1.0.3:")
    depends_on("fmt@9:")
    depends_on("tomlplusplus@3.3:")
    depends_on("cli11@2.1:")
    depends_on("nlohmann-json@3.11:")
    depends_on("random123")
    depends_on("muparser")
    depends_on("libpng")
    depends_on("vtk@9.1:+mpi~python", when="+vtk")
    depends_on("vtk+opengl2", when="+view")
    depends_on("libsndfile", when="+sound")
    depends_on("libzmq", when="+live")
    depends_on("cppzmq", when="+live")
    conflicts("%gcc@:11", msg="Trevi is written in C++20: GCC 12 or Clang 14 and later")

    generator("ninja")

    def cmake_args(self):
        parts = ("vtk", "view", "music", "sound", "live")
        return [self.define_from_variant(f"TREVI_WITH_{part.upper()}", part) for part in parts] + [
            self.define("TREVI_WITH_PYTHON", False),
            self.define("TREVI_TESTS", False),
        ]

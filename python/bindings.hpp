// The parts of the Python module, each of which adds its classes.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl_bind.h>

#include "trevi/scene.hpp"

// Lists that are changed in place, and not copied on every access.
PYBIND11_MAKE_OPAQUE(std::vector<trevi::ObstacleSettings>)
PYBIND11_MAKE_OPAQUE(std::vector<trevi::BodySettings>)
PYBIND11_MAKE_OPAQUE(std::vector<trevi::DampingSettings>)
PYBIND11_MAKE_OPAQUE(std::vector<trevi::GaugeSettings>)
PYBIND11_MAKE_OPAQUE(std::vector<trevi::FountainSettings>)
PYBIND11_MAKE_OPAQUE(std::vector<trevi::InletSettings>)
PYBIND11_MAKE_OPAQUE(std::vector<trevi::DrainSettings>)

namespace trevi::python {

namespace py = pybind11;

void bind_settings(py::module_& module);
void bind_solids(py::module_& module);
void bind_flow(py::module_& module);
void bind_output(py::module_& module);
void bind_forcing(py::module_& module);
void bind_solver(py::module_& module);

/// That of an mpi4py communicator, or of all ranks for None.
MPI_Comm comm_of(const py::object& comm);

}  // namespace trevi::python

// The module trevi._trevi: begins MPI, PETSc and the threads when it is imported, and ends them when Python does, after
// all solvers. Import it on all ranks.
#include <cstdlib>
#include <memory>
#include <string>

#include "base/memory.hpp"
#include "base/simd.hpp"
#include "bindings.hpp"
#include "solver.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi::python {

namespace {

// Of the process; mpi4py may have begun MPI before.
struct Process {
  std::unique_ptr<Mpi> mpi;
  std::unique_ptr<Session> session;
};
Process process;

void begin() {
  static std::string name = "trevi";
  static char* arguments[] = {name.data(), nullptr};
  static int count = 1;
  static char** values = arguments;
  const Denormals denormals;
  give_freed_memory_back();  // PETSc has been loaded with the module
  process.mpi = std::make_unique<Mpi>(count, values);
  process.session = std::make_unique<Session>(MPI_COMM_WORLD);
  const int fair = process.session->fair_threads();
  if (std::getenv("OMP_NUM_THREADS") == nullptr) Session::use_threads(fair);
}

void end() {
  const Denormals denormals;
  close_all_solvers();
  process.session.reset();
  process.mpi.reset();
}

}  // namespace

MPI_Comm comm_of(const py::object& comm) {
  if (comm.is_none()) return MPI_COMM_WORLD;
  if (!py::hasattr(comm, "py2f")) throw InputError("comm: must be a communicator of mpi4py, or None for all ranks");
  return MPI_Comm_f2c(comm.attr("py2f")().cast<MPI_Fint>());
}

}  // namespace trevi::python

PYBIND11_MODULE(_trevi, module) {
  using namespace trevi;
  using namespace trevi::python;
  module.doc() = "Water by position based fluids; see help(trevi).";
  const py::object failed = py::register_exception<RunError>(module, "RunError", PyExc_RuntimeError);
  py::register_exception<InputError>(module, "InputError", PyExc_ValueError);
  py::register_exception<BlowUp>(module, "BlowUp", failed.ptr());
  begin();
  module.attr("__version__") = TREVI_VERSION;
  module.attr("rank") = rank_of(MPI_COMM_WORLD);
  module.attr("size") = size_of(MPI_COMM_WORLD);
  bind_settings(module);
  bind_forcing(module);
  bind_solver(module);
  module.def("use_threads", &Session::use_threads, py::arg("count"),
             "Threads that share the loops of this rank, from the next solver on; results do not depend on it. Before "
             "it is called OMP_NUM_THREADS, or a fair part of this machine's cores.");
  module.def("threads", &Session::threads, "Threads of the next solver on this rank.");
  py::module_::import("atexit").attr("register")(py::cpp_function(&end));
}

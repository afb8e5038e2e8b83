// Stands in for vtu.cpp in a build without VTK.
#include "trevi/base/error.hpp"
#include "trevi/output/vtu.hpp"

namespace trevi {

std::unique_ptr<Observer> make_vtu_writer(MPI_Comm, VtuOptions) {
  throw InputError(
      "[output.vtu]: this build has no VTK; configure with -DTREVI_WITH_VTK=ON, or use [output.vtkhdf] or "
      "[output.checkpoint]");
}

std::string vtk_version() { return "absent"; }

}  // namespace trevi

// Stands in for vtu.cpp in a build without VTK.
#include "io/frames/vtu.hpp"
#include "trevi/error.hpp"

namespace trevi {

void require_vtk() {
  throw InputError(
      "[output.vtu], or format = \"vtu\": this build has no VTK; configure with -DTREVI_WITH_VTK=ON (it needs "
      "libvtk9-dev), or use [output.vtkhdf], which ParaView opens, too");
}

std::unique_ptr<Observer> make_vtu_writer(MPI_Comm, FrameOptions) {
  require_vtk();
  return nullptr;
}

std::string vtk_version() { return "absent"; }

}  // namespace trevi

// Stands in for mesh_file.cpp in a build without VTK.
#include "io/frames/mesh_file.hpp"
#include "trevi/error.hpp"

namespace trevi {

TriangleMesh read_mesh_file(const std::string& path) {
  throw InputError(path +
                   ": this build has no VTK to read meshes with; configure with -DTREVI_WITH_VTK=ON (it needs "
                   "libvtk9-dev), or use the other shapes");
}

}  // namespace trevi

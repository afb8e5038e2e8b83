#include "io/mesh_file.hpp"

#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>

#include "io/vtk_error_text.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

template <class Reader>
vtkSmartPointer<vtkPolyData> read_by(const std::string& path) {
  vtkNew<Reader> reader;
  vtkNew<VtkErrorText> errors;
  reader->AddObserver(vtkCommand::ErrorEvent, errors);
  reader->SetFileName(path.c_str());
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  triangles->SetInputConnection(reader->GetOutputPort());
  triangles->Update();
  if (!errors->empty()) throw InputError(path + ": cannot be read as a mesh: " + errors->text());
  return triangles->GetOutput();
}

vtkSmartPointer<vtkPolyData> read_surface(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) throw InputError(path + ": no such file; give the path of a mesh");
  const std::string ending = ending_of(path);
  if (ending == ".stl") return read_by<vtkSTLReader>(path);
  if (ending == ".obj") return read_by<vtkOBJReader>(path);
  if (ending == ".ply") return read_by<vtkPLYReader>(path);
  throw InputError(path + ": unknown kind of mesh; give a file ending in .stl, .obj or .ply");
}

}  // namespace

TriangleMesh read_mesh_file(const std::string& path) {
  const vtkSmartPointer<vtkPolyData> surface = read_surface(path);
  TriangleMesh mesh;
  std::map<std::array<Real, 3>, std::int32_t> number;
  vtkNew<vtkIdList> corners;
  for (vtkIdType cell = 0; cell < surface->GetNumberOfCells(); ++cell) {
    surface->GetCellPoints(cell, corners);
    if (corners->GetNumberOfIds() != 3) continue;
    std::array<std::int32_t, 3> triangle{};
    for (vtkIdType k = 0; k < 3; ++k) {
      std::array<Real, 3> p{};
      surface->GetPoint(corners->GetId(k), p.data());
      const auto [place, is_new] = number.try_emplace(p, static_cast<std::int32_t>(mesh.points.size()));
      if (is_new) mesh.points.emplace_back(p[0], p[1], p[2]);
      triangle[static_cast<std::size_t>(k)] = place->second;
    }
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    mesh.triangles.push_back(triangle);
  }
  if (mesh.triangles.empty()) throw InputError(path + ": holds no triangles; give a closed surface");
  return mesh;
}

}  // namespace trevi

#include "io/frames/mesh_file.hpp"

#include <vtkExecutive.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkTriangleFilter.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <system_error>

#include "base/memory.hpp"
#include "io/frames/ply_file.hpp"
#include "io/frames/vtk_error_text.hpp"
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
  vtkNew<VtkErrorText> errors, warnings;  // warnings are not reported
  reader->AddObserver(vtkCommand::WarningEvent, warnings);
  reader->AddObserver(vtkCommand::ErrorEvent, errors);
  reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, errors);
  reader->SetFileName(path.c_str());
  vtkNew<vtkTriangleFilter> triangles;
  triangles->PassVertsOff();
  triangles->PassLinesOff();
  triangles->SetInputConnection(reader->GetOutputPort());
  triangles->Update();
  if (!errors->empty()) throw InputError(path + ": cannot be read as a mesh: " + errors->text());
  return triangles->GetOutput();
}

// 80 bytes of any text, the number of triangles, and 50 bytes for each of them. A text file begins with "solid"; so may
// a binary file, but its number of triangles contains a zero byte.
void check_binary_stl(const std::string& path) {
  constexpr std::uintmax_t head = 84, triangle = 50;
  std::ifstream file(path, std::ios::binary);
  std::array<unsigned char, head> bytes{};
  const auto is_text = [](const auto& begin) {
    return std::memcmp(begin.data(), "solid", 5) == 0 && std::find(begin.begin(), begin.end(), 0) == begin.end();
  };
  if (!file.read(reinterpret_cast<char*>(bytes.data()), head) || is_text(bytes)) return;
  std::uintmax_t count = 0;
  for (std::size_t k = 4; k-- > 0;) count = 256 * count + bytes[80 + k];
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size < head + triangle * count || size >= head + triangle * (count + 1)) {
    const std::uintmax_t there = size - head;
    throw InputError(path + ": says that it has " + std::to_string(count) + " triangles, and has bytes for " +
                     std::to_string(there / triangle) + (there % triangle > 0 ? " and a part" : "") +
                     "; copy or save it again");
  }
}

// VTK reads invalid parts of a vertex as 0, and numbers that are too large as the largest number.
void check_obj(const std::string& path) {
  constexpr double largest = 1e30;
  std::ifstream file(path);
  std::string line, word;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    if (!(words >> word) || word != "v") continue;
    int count = 0;
    bool are_numbers = true;
    while (words >> word && word.front() != '#') {
      double value = 0;
      are_numbers = are_numbers && is_number(word, value) && std::abs(value) < largest;
      ++count;
    }
    if (!are_numbers || count < 3)
      throw InputError(path + ":" + std::to_string(number) + ": a vertex is not three finite numbers; mend the file");
  }
}

vtkSmartPointer<vtkPolyData> read_surface(const std::string& path) {
  std::error_code ignored;  // of circular links, for instance
  if (!std::filesystem::is_regular_file(path, ignored))
    throw InputError(path + ": no such file, or it is a folder; give the path of a mesh");
  constexpr double bytes_per_byte = 4;  // memory of VTK and of ours
  require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)),
                 path + ": triangles of so large a file", "make it coarser");
  const std::string ending = ending_of(path);
  if (ending == ".stl") {
    check_binary_stl(path);
    return read_by<vtkSTLReader>(path);
  }
  if (ending == ".obj") {
    check_obj(path);
    return read_by<vtkOBJReader>(path);
  }
  if (ending == ".ply") {
    check_ply(path);
    return read_by<vtkPLYReader>(path);
  }
  throw InputError(path + ": unknown kind of mesh; give a file ending in .stl, .obj or .ply");
}

}  // namespace

TriangleMesh read_mesh_file(const std::string& path) {
  const vtkSmartPointer<vtkPolyData> surface = read_surface(path);
  // Corners are counted with 32 bits, and the mesh goes to all ranks in one message of less than 2 GB.
  constexpr vtkIdType max_triangles = 25'000'000;
  if (surface->GetNumberOfCells() > max_triangles)
    throw InputError(path + ": holds more than 25 million triangles; make it coarser");
  TriangleMesh mesh;
  std::map<std::array<Real, 3>, std::int32_t> number;
  vtkNew<vtkIdList> corners;
  for (vtkIdType cell = 0; cell < surface->GetNumberOfCells(); ++cell) {
    surface->GetCellPoints(cell, corners);
    if (corners->GetNumberOfIds() != 3) continue;
    std::array<std::int32_t, 3> triangle{};
    for (vtkIdType k = 0; k < 3; ++k) {
      std::array<Real, 3> p{};
      if (corners->GetId(k) < 0 || corners->GetId(k) >= surface->GetNumberOfPoints())
        throw InputError(path + ": triangle " + std::to_string(cell) +
                         " names a corner that is not there; mend the file");
      surface->GetPoint(corners->GetId(k), p.data());
      if (!std::all_of(p.begin(), p.end(), [](Real x) { return std::isfinite(x); }))
        throw InputError(path + ": a corner of triangle " + std::to_string(cell) +
                         " is no finite number; mend the file");
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

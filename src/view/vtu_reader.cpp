// VTU frames: the .pvtu names one piece per rank, each read by VTK. Likewise surfaces of obstacles, .vtp.
#include <fmt/format.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <charconv>
#include <filesystem>
#include <fstream>
#include <new>
#include <regex>

#include "base/memory.hpp"
#include "io/frames/vtk_error_text.hpp"
#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"
#include "view/frame_reader.hpp"

namespace trevi {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw InputError(path + ": damaged or cut short (" + why + "); use another copy, or delete its line in the list");
}

/// The number after each `name="` in a text must be a count of things that a file of this size can hold.
void check_counts(const std::string& path, std::string_view text, std::string_view name, double size) {
  constexpr double min_bytes = 4, max_compression = 1100;  // of a point or a cell; of zlib
  for (std::size_t at = 0; (at = text.find(name, at)) != std::string_view::npos;) {
    at += name.size();
    std::int64_t count = -1;
    const auto [end, problem] = std::from_chars(text.data() + at, text.data() + text.size(), count);
    const bool good = problem == std::errc() && end != text.data() + text.size() && *end == '"';
    if (good && count >= 0 && min_bytes * static_cast<double>(count) <= max_compression * size) continue;
    fail(path,
         fmt::format("{}{}\" in a file of {}", name, text.substr(at, text.substr(at, 24).find('"')), bytes_text(size)));
  }
}

// VTK trusts the counts in a piece without checking the file's size, and takes a count below 0 for a size.
void check_claims(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto size = static_cast<double>(fs::file_size(path));
  for (std::string line; std::getline(file, line) && line.find("<AppendedData") == std::string::npos;) {
    for (const char* name : {"NumberOfPoints=\"", "NumberOfCells=\"", "NumberOfTuples=\""})
      check_counts(path, line, name, size);
  }
}

/// Read by vtkXMLUnstructuredGridReader or vtkXMLPolyDataReader.
template <class Reader>
auto read_piece(const std::string& path) {
  if (!fs::exists(path)) throw InputError(path + ": is listed but not there; copy the directory whole");
  check_claims(path);
  vtkNew<Reader> reader;
  vtkNew<VtkErrorText> errors;
  reader->AddObserver(vtkCommand::ErrorEvent, errors);
  reader->SetReaderErrorObserver(errors);
  reader->SetParserErrorObserver(errors);
  reader->SetFileName(path.c_str());
  reader->Update();
  if (!errors->empty()) fail(path, errors->text());
  if (reader->GetOutput() == nullptr || reader->GetOutput()->GetPoints() == nullptr) fail(path, "no points in it");
  return vtkSmartPointer(reader->GetOutput());
}

/// Appends the tuples of a field; none if the piece has none, or one of another width.
template <class T, std::size_t Width>
void append(std::vector<std::array<T, Width>>& to, vtkDataArray* field) {
  if (field == nullptr || field->GetNumberOfComponents() != static_cast<int>(Width)) return;
  const std::size_t first = to.size();
  to.resize(first + static_cast<std::size_t>(field->GetNumberOfTuples()));
  double tuple[Width] = {};
  for (std::size_t k = first; k < to.size(); ++k) {
    field->GetTuple(static_cast<vtkIdType>(k - first), tuple);
    for (std::size_t a = 0; a < Width; ++a) to[k][a] = static_cast<T>(tuple[a]);
  }
}

template <class T>
void append(std::vector<T>& to, vtkDataArray* field) {
  std::vector<std::array<T, 1>> values;
  append(values, field);
  for (const auto& value : values) to.push_back(value[0]);
}

void append_piece(RawFrame& raw, vtkUnstructuredGrid* grid) {
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<float, 3>> velocities;
  append(points, grid->GetPoints()->GetData());
  vtkPointData* fields = grid->GetPointData();
  append(velocities, fields->GetArray("velocity"));
  for (const auto& p : points) raw.position.emplace_back(p[0], p[1], p[2]);
  for (const auto& v : velocities) raw.speed.push_back(std::hypot(v[0], v[1], v[2]));
  append(raw.density, fields->GetArray("density"));
  append(raw.id, fields->GetArray("id"));
  append(raw.rgb, fields->GetArray("rgb"));
  raw.rank_counts.push_back(static_cast<std::int64_t>(points.size()));
}

std::vector<std::string> pieces_of(const std::string& path) {
  if (path.ends_with(".vtu")) return {path};
  if (!fs::exists(path)) throw InputError(path + ": is listed but not there; copy the directory whole");
  const std::string text = read_text(path);
  if (text.find("</VTKFile>") == std::string::npos) fail(path, "no </VTKFile>");
  std::vector<std::string> pieces;
  static const std::regex piece("<Piece\\s+Source=\"([^\"]*)\"");
  for (std::sregex_iterator it(text.begin(), text.end(), piece), end; it != end; ++it)
    pieces.push_back((fs::path(path).parent_path() / (*it)[1].str()).string());
  if (pieces.empty()) fail(path, "no <Piece Source=...>");
  return pieces;
}

}  // namespace

RawFrame read_vtu_frame(const std::string& path) {
  RawFrame raw;
  for (const std::string& piece : pieces_of(path)) {
    try {
      append_piece(raw, read_piece<vtkXMLUnstructuredGridReader>(piece));
    } catch (const std::bad_alloc& error) {
      fail(piece, text_of(error));
    }
  }
  return raw;
}

TriangleMesh read_vtp_surface(const std::string& path) {
  const vtkSmartPointer<vtkPolyData> surface = read_piece<vtkXMLPolyDataReader>(path);
  TriangleMesh mesh;
  std::array<double, 3> p{};
  for (vtkIdType k = 0; k < surface->GetNumberOfPoints(); ++k) {
    surface->GetPoint(k, p.data());
    mesh.points.emplace_back(p[0], p[1], p[2]);
  }
  vtkNew<vtkIdList> corners;
  for (vtkIdType k = 0; k < surface->GetNumberOfCells(); ++k) {
    surface->GetCellPoints(k, corners);
    std::array<std::int32_t, 3> triangle{};
    for (int c = 0; c < 3; ++c) {
      const vtkIdType point = corners->GetNumberOfIds() == 3 ? corners->GetId(c) : -1;
      if (point < 0 || point >= surface->GetNumberOfPoints()) fail(path, "a cell that is no triangle of its points");
      triangle[static_cast<std::size_t>(c)] = static_cast<std::int32_t>(point);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace trevi

#include "io/frames/vtu.hpp"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVersion.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <filesystem>
#include <numeric>
#include <type_traits>

#include "io/frames/vtk_compressor.hpp"
#include "io/frames/vtk_error_text.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// How VTK represents a type of number, in memory and in its files.
struct NumberType {
  int type;
  const char* name;
};

static_assert(std::is_same_v<GlobalId, long>, "ids are lent to VTK as long, its Int64 here");

NumberType number_type(Scalar scalar) {
  switch (scalar) {
    case Scalar::uint8:
      return {VTK_UNSIGNED_CHAR, "UInt8"};
    case Scalar::int32:
      return {VTK_INT, "Int32"};
    case Scalar::int64:
      return {VTK_LONG, "Int64"};
    case Scalar::float32:
      return {VTK_FLOAT, "Float32"};
    case Scalar::float64:
      break;
  }
  return {VTK_DOUBLE, "Float64"};
}

/// A VTK array that reads `rows` where they are; they must outlive it.
vtkSmartPointer<vtkDataArray> borrowed(RowFormat format, const void* rows, std::size_t count) {
  auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(number_type(format.scalar).type));
  array->SetNumberOfComponents(format.components);
  // VTK asks for a pointer to non-const; with save = 1 it neither changes nor frees data that a writer only reads.
  if (count > 0) array->SetVoidArray(const_cast<void*>(rows), static_cast<vtkIdType>(count) * format.components, 1);
  return array;
}

void add_vertex_cells(vtkUnstructuredGrid* grid, std::size_t count) {
  vtkNew<vtkTypeInt32Array> offsets, points;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(count) + 1);
  points->SetNumberOfValues(static_cast<vtkIdType>(count));
  std::iota(offsets->GetPointer(0), offsets->GetPointer(0) + count + 1, 0);
  std::iota(points->GetPointer(0), points->GetPointer(0) + count, 0);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, points);
  grid->SetCells(VTK_VERTEX, cells);
}

void write_piece(const std::string& path, vtkUnstructuredGrid* grid) {
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  vtkNew<VtkCompressor> compressor;
  compressor->SetCompressionLevel(1);  // higher levels cost several times the time for a few percent
  compressor->expect(grid);
  vtkNew<VtkErrorText> errors, echoes;  // the pipeline repeats what the writer has said
  writer->AddObserver(vtkCommand::ErrorEvent, errors);
  writer->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, echoes);
  writer->SetCompressor(compressor);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetHeaderTypeToUInt64();
  writer->SetFileName(path.c_str());
  writer->SetInputData(grid);
  const bool good = writer->Write() != 0 && writer->GetErrorCode() == vtkErrorCode::NoError;
  if (good) return;
  throw RunError(fmt::format("{}: cannot write ({}) {}", path, free_space(path), errors->text()));
}

class VtuWriter : public FrameWriter {
 public:
  VtuWriter(MPI_Comm comm, FrameOptions options)
      : FrameWriter(comm, std::move(options), {"VtuFrames", vtu_list, vtu_folder, {vtu_frames, vtu_pieces}}) {}

 private:
  void write(const Frame& frame, const std::string& path) override {
    all_or_none(comm(), [&] { write_own_piece(frame, piece_path(path, rank_of(comm()))); });
    on_root(comm(), [&] { replace_file(path, frame_text(path)); });
  }

  /// For the frame `path`, which ends in .pvtu.
  static std::string piece_path(const std::string& path, int rank) {
    return fmt::format("{}_{}.vtu", path.substr(0, path.rfind('.')), rank);
  }

  void write_own_piece(const Frame& frame, const std::string& path) const {
    const std::size_t count = frame.particles.id.size();
    vtkNew<vtkPoints> points;
    const RowFormat format = point_format(options().single_points);
    const Rows places = point_rows(frame.particles.position, options().single_points);
    points->SetDataType(number_type(format.scalar).type);
    points->SetData(borrowed(format, places.get(), count));
    vtkNew<vtkUnstructuredGrid> grid;
    grid->SetPoints(points);
    add_vertex_cells(grid, count);
    std::vector<Rows> lent;  // the grid borrows them until the piece is written
    for (const OutputField* field : fields()) {
      lent.push_back(rows_of(*field, frame));
      const auto array = borrowed(field->format, lent.back().get(), count);
      array->SetName(field->name);
      grid->GetPointData()->AddArray(array);
    }
    write_piece(path, grid);
  }

  std::string frame_text(const std::string& path) const {
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "  <PUnstructuredGrid GhostLevel=\"0\">\n    <PPointData>\n";
    for (const OutputField* field : fields()) {
      text += fmt::format("      <PDataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"/>\n",
                          number_type(field->format.scalar).name, field->name, field->format.components);
    }
    text += fmt::format(
        "    </PPointData>\n    <PPoints>\n"
        "      <PDataArray type=\"{}\" Name=\"Points\" NumberOfComponents=\"3\"/>\n    </PPoints>\n",
        number_type(point_format(options().single_points).scalar).name);
    for (int rank = 0; rank < size_of(comm()); ++rank) {
      const std::string piece = std::filesystem::path(piece_path(path, rank)).filename().string();
      text += fmt::format("    <Piece Source=\"{}\"/>\n", piece);
    }
    return text + "  </PUnstructuredGrid>\n</VTKFile>\n";
  }
};

}  // namespace

void require_vtk() {}

std::unique_ptr<Observer> make_vtu_writer(MPI_Comm comm, FrameOptions options) {
  return std::make_unique<VtuWriter>(comm, std::move(options));
}

std::string vtk_version() { return vtkVersion::GetVTKVersion(); }

}  // namespace trevi

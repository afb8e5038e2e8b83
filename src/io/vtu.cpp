#include "io/vtu.hpp"

#include <fmt/format.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLongArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkVersion.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <type_traits>

#include "io/files.hpp"
#include "io/pvd.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// How a point array stands in the .pvtu; the pieces must agree with it.
struct ArrayFormat {
  const char* name;
  const char* type;
  int components;
};

static_assert(std::is_same_v<GlobalId, long>, "ids are lent to VTK as long, its Int64 here");

constexpr ArrayFormat array_formats[] = {
    {"velocity", "Float32", 3}, {"density", "Float32", 1}, {"id", "Int64", 1},
    {"rank", "Int32", 1},       {"rgb", "UInt8", 3},
};

/// A VTK array that reads `values` where they are; they must outlive it.
template <class Array, class T>
vtkNew<Array> borrowed(const T* values, std::size_t count, int components) {
  vtkNew<Array> array;
  array->SetNumberOfComponents(components);
  // VTK asks for a pointer to non-const; with save = 1 it neither changes nor frees what a writer only reads.
  if (count > 0) array->SetArray(const_cast<T*>(values), static_cast<vtkIdType>(count) * components, 1);
  return array;
}

/// A VTK array of its own that holds `values` converted.
template <class Array, class T>
vtkNew<Array> converted(const T* values, std::size_t count, int components) {
  vtkNew<Array> array;
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(count));
  using Value = typename Array::ValueType;
  std::transform(values, values + count * static_cast<std::size_t>(components), array->GetPointer(0),
                 [](T value) { return static_cast<Value>(value); });
  return array;
}

const Real* numbers(const std::vector<Vec3>& field) { return reinterpret_cast<const Real*>(field.data()); }

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

/// Keeps what VTK would print and turns it into the text of an exception.
class ErrorText : public vtkCommand {
 public:
  static ErrorText* New() { return new ErrorText; }
  void Execute(vtkObject*, unsigned long, void* data) override {
    // The first error is the cause; later ones only pass it on.
    if (data != nullptr && text_.empty()) text_ = static_cast<const char*>(data);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

void write_piece(const std::string& path, vtkUnstructuredGrid* grid) {
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  vtkNew<ErrorText> errors, echoes;  // the pipeline repeats what the writer has said
  writer->AddObserver(vtkCommand::ErrorEvent, errors);
  writer->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, echoes);
  writer->SetCompressorTypeToZLib();
  writer->SetCompressionLevel(1);  // higher levels cost several times the time for a few percent
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetHeaderTypeToUInt64();
  writer->SetFileName(path.c_str());
  writer->SetInputData(grid);
  const bool good = writer->Write() != 0 && writer->GetErrorCode() == vtkErrorCode::NoError;
  if (good) return;
  throw RunError(fmt::format("{}: cannot write ({}) {}", path, free_space(path), errors->text()));
}

class VtuWriter : public Observer {
 public:
  VtuWriter(MPI_Comm comm, VtuOptions options) : comm_(comm), rank_(rank_of(comm)), options_(std::move(options)) {
    for (const std::string& field : options_.fields) check_field(field);
    on_root(comm_, [&] { open(); });
    MPI_Bcast(&last_step_, 1, MPI_INT64_T, 0, comm_);
  }

  bool due(const Clock& clock) const override { return clock.step > last_step_ && options_.schedule.due(clock); }
  bool wants_density() const override { return wanted("density"); }

  void observe(const Frame& frame) override {
    const std::int64_t step = frame.clock.step;
    all_or_none(comm_, [&] { write_own_piece(frame); });
    on_root(comm_, [&] {
      replace_file(folder() + frame_name(step), frame_text(step));
      list_->add(frame.clock, "vtu/" + frame_name(step));
    });
    last_step_ = step;
  }

 private:
  static void check_field(const std::string& field) {
    if (std::none_of(std::begin(array_formats), std::end(array_formats),
                     [&](const ArrayFormat& format) { return field == format.name; })) {
      throw InputError("[output.vtu] fields: unknown field \"" + field + "\"; use velocity, density, id, rank or rgb");
    }
  }

  void open() {
    std::filesystem::create_directories(folder());
    if (options_.restart_step) {
      set_aside_after(folder(), "particles_", ".pvtu", *options_.restart_step);
      set_aside_after(folder(), "particles_", "_#.vtu", *options_.restart_step);
    }
    list_.emplace(options_.directory + "/particles.pvd", options_.restart_step);
    last_step_ = list_->last_step();
  }

  bool wanted(const std::string& field) const {
    return std::find(options_.fields.begin(), options_.fields.end(), field) != options_.fields.end();
  }

  std::string folder() const { return options_.directory + "/vtu/"; }
  std::string frame_name(std::int64_t step) const { return "particles_" + step_digits(step) + ".pvtu"; }
  std::string piece_name(std::int64_t step, int rank) const {
    return fmt::format("particles_{}_{}.vtu", step_digits(step), rank);
  }

  void write_own_piece(const Frame& frame) const {
    const Particles& particles = frame.particles;
    const std::size_t count = particles.id.size();
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetData(borrowed<vtkDoubleArray>(numbers(particles.position), count, 3));
    vtkNew<vtkUnstructuredGrid> grid;
    grid->SetPoints(points);
    add_vertex_cells(grid, count);
    // The colours are made here and borrowed by the grid, so they stay alive until the piece is written.
    const std::vector<Rgb> colours = wanted("rgb") ? colours_of(options_.colour, particles) : std::vector<Rgb>{};
    add_arrays(grid->GetPointData(), frame, colours);
    write_piece(folder() + piece_name(frame.clock.step, rank_), grid);
  }

  void add_arrays(vtkPointData* data, const Frame& frame, const std::vector<Rgb>& colours) const {
    const Particles& particles = frame.particles;
    const std::size_t count = particles.id.size();
    const auto add = [&](const char* name, vtkDataArray* array) {
      array->SetName(name);
      data->AddArray(array);
    };
    if (wanted("velocity")) add("velocity", converted<vtkFloatArray>(numbers(particles.velocity), count, 3));
    if (wanted("density")) {
      require(frame.density.size() == count, "[output.vtu] density was not computed for this frame");
      add("density", converted<vtkFloatArray>(frame.density.data(), count, 1));
    }
    if (wanted("id")) add("id", borrowed<vtkLongArray>(particles.id.data(), count, 1));
    if (wanted("rank")) {
      const std::vector<int> ranks(count, rank_);
      add("rank", converted<vtkIntArray>(ranks.data(), count, 1));
    }
    if (wanted("rgb")) {
      const auto* bytes = reinterpret_cast<const unsigned char*>(colours.data());
      add("rgb", borrowed<vtkUnsignedCharArray>(bytes, count, 3));
    }
  }

  std::string frame_text(std::int64_t step) const {
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "  <PUnstructuredGrid GhostLevel=\"0\">\n    <PPointData>\n";
    for (const ArrayFormat& format : array_formats) {
      if (!wanted(format.name)) continue;
      text += fmt::format("      <PDataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"/>\n", format.type,
                          format.name, format.components);
    }
    text +=
        "    </PPointData>\n    <PPoints>\n"
        "      <PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n    </PPoints>\n";
    for (int rank = 0; rank < size_of(comm_); ++rank) {
      text += fmt::format("    <Piece Source=\"{}\"/>\n", piece_name(step, rank));
    }
    return text + "  </PUnstructuredGrid>\n</VTKFile>\n";
  }

  MPI_Comm comm_;
  int rank_;
  VtuOptions options_;
  std::optional<PvdFile> list_;  ///< rank 0 only
  std::int64_t last_step_ = -1;  ///< of the last frame listed
};

}  // namespace

void require_vtk() {}

std::unique_ptr<Observer> make_vtu_writer(MPI_Comm comm, VtuOptions options) {
  return std::make_unique<VtuWriter>(comm, std::move(options));
}

std::string vtk_version() { return vtkVersion::GetVTKVersion(); }

}  // namespace trevi

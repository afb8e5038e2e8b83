// VTU frames, read back with VTK's own reader, with an empty rank among the writers.
#include <vtkCellArray.h>
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "frames.hpp"
#include "io/frames/vtk_compressor.hpp"
#include "io/frames/vtu.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"

namespace trevi {
namespace {

void expect_frame(const std::string& path, const Particles& all) {
  vtkNew<vtkXMLPUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkUnstructuredGrid* grid = reader->GetOutput();
  const auto count = static_cast<vtkIdType>(all.id.size());
  ASSERT_EQ(grid->GetNumberOfPoints(), count);
  ASSERT_EQ(grid->GetNumberOfCells(), count);
  for (const char* name : {"velocity", "density", "id", "rank", "rgb"}) {
    ASSERT_NE(grid->GetPointData()->GetArray(name), nullptr) << name;
  }
  vtkDataArray* ids = grid->GetPointData()->GetArray("id");
  EXPECT_EQ(ids->GetDataTypeSize(), 8);
  EXPECT_EQ(grid->GetPointData()->GetArray("rgb")->GetDataType(), VTK_UNSIGNED_CHAR);
  for (vtkIdType i = 0; i < count; ++i) {
    const std::size_t row = row_of(all, id_of(ids, i));
    ASSERT_LT(row, all.id.size());
    EXPECT_EQ(Vec3(grid->GetPoint(i)), all.position[row]);
    EXPECT_EQ(grid->GetCellType(i), VTK_VERTEX);
    EXPECT_EQ(grid->GetPointData()->GetArray("density")->GetTuple1(i),
              static_cast<float>(1000 + all.position[row].x()));
    EXPECT_EQ(grid->GetPointData()->GetArray("velocity")->GetTuple3(i)[2], static_cast<float>(all.velocity[row].z()));
    EXPECT_EQ(grid->GetPointData()->GetArray("rgb")->GetTuple3(i)[0], rainbow(all.hue[row])[0]);
  }
}

void write_frames(const FrameOptions& options, const Particles& all, std::int64_t first, std::int64_t last) {
  const Particles mine = my_part(all);
  std::vector<Real> density;
  for (const Vec3& p : mine.position) density.push_back(1000 + p.x());
  const auto writer = make_vtu_writer(world, options);
  EXPECT_TRUE(writer->wants_density());
  for (Clock clock{first, 0.1, 1}; clock.step <= last; ++clock.step) {
    if (writer->due(clock)) writer->observe(frame_of(clock, mine, density));
  }
}

TEST_F(Output, VtuFramesReadBackWithAnEmptyRank) {
  const Particles all = whole_cloud(500);
  write_frames(frame_options(folder()), all, 0, 12);
  for (const char* step : {"000000", "000005", "000010"}) {
    expect_frame(path(std::string("vtu/particles_") + step + ".pvtu"), all);
  }
  write_frames(frame_options(folder()), whole_cloud(0), 0, 0);
  expect_frame(path("vtu/particles_000000.pvtu"), whole_cloud(0));
}

TEST_F(Output, VtuIsTheSameBytesOnAnyNumberOfThreads) {
  const Particles all = whole_cloud(300000, 3);  // several batches of blocks
  const auto texts = on_threads(path("vtu/particles_000000_0.vtu"), [&] {
    on_root(world, [&] { fs::remove_all(path("particles.pvd")); });
    write_frames(frame_options(folder()), all, 0, 0);
  });
  EXPECT_GT(texts[0].size(), 24 * all.id.size() / static_cast<std::size_t>(size_of(world)) / 2);
  EXPECT_TRUE(texts[0] == texts[1] && texts[0] == texts[2]);
}

/// Points, a field and a vertex cell for each point, as VtuWriter has them.
void fill(vtkUnstructuredGrid* grid, vtkIdType count) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  vtkNew<vtkFloatArray> field;
  field->SetName("field");
  vtkNew<vtkTypeInt32Array> offsets, connectivity;
  for (vtkIdType i = 0; i < count; ++i) {
    points->SetPoint(i, std::sin(i), std::cos(i), 1.0 / static_cast<double>(i + 1));
    field->InsertNextValue(static_cast<float>(std::sin(7 * i)));
    connectivity->InsertNextValue(static_cast<int>(i));
    offsets->InsertNextValue(static_cast<int>(i));
  }
  offsets->InsertNextValue(static_cast<int>(count));
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, connectivity);
  grid->SetPoints(points);
  grid->SetCells(VTK_VERTEX, cells);
  grid->GetPointData()->AddArray(field);
}

std::string written_with(vtkDataCompressor* compressor, vtkUnstructuredGrid* grid, const std::string& path) {
  compressor->SetCompressionLevel(1);
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetCompressor(compressor);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetFileName(path.c_str());
  writer->SetInputData(grid);
  EXPECT_NE(writer->Write(), 0);
  return text_of(path);
}

TEST_F(Output, VtkCompressorKnowsAllBlocksAndGivesThoseOfVtk) {
  if (rank_of(world) != 0) return;
  vtkNew<vtkUnstructuredGrid> grid, same, once_more;  // a writer leaves a note on the arrays, which the next one writes
  for (vtkUnstructuredGrid* one : {grid.Get(), same.Get(), once_more.Get()}) fill(one, 200001);
  vtkNew<vtkZLibDataCompressor> theirs;
  const std::string expected = written_with(theirs, grid, path("theirs.vtu"));
  vtkNew<VtkCompressor> told, untold;
  told->expect(same);
  EXPECT_TRUE(written_with(told, same, path("told.vtu")) == expected);
  EXPECT_EQ(told->unexpected_blocks(), 0);
  EXPECT_TRUE(written_with(untold, once_more, path("untold.vtu")) == expected);
  EXPECT_GT(untold->unexpected_blocks(), 200);
}

TEST_F(Output, VtuRestartSetsLaterFramesAside) {
  const Particles all = whole_cloud(50);
  FrameOptions options = frame_options(folder());
  write_frames(options, all, 0, 12);
  barrier();
  options.restart_step = 7;
  write_frames(options, all, 7, 9);
  barrier();
  EXPECT_TRUE(fs::exists(path("vtu/particles_000010.pvtu.stale")));
  EXPECT_TRUE(fs::exists(path("vtu/particles_000010_0.vtu.stale")));
  EXPECT_FALSE(fs::exists(path("vtu/particles_000010_0.vtu")));
  EXPECT_EQ(text_of(path("particles.pvd")).find("000010"), std::string::npos);
  barrier();
  write_frames(options, all, 7, 10);
  barrier();
  expect_mentions(text_of(path("particles.pvd")), {"timestep=\"0.5\"", "timestep=\"1\"", "000010.pvtu"});
  expect_frame(path("vtu/particles_000010.pvtu"), all);
}

TEST_F(Output, VtuRestartKeepsWhatIsWholeOfACutList) {
  const Particles all = whole_cloud(50);
  FrameOptions options = frame_options(folder());
  write_frames(options, all, 0, 7);
  barrier();
  on_root(world, [&] {
    const std::string text = text_of(path("particles.pvd"));
    std::ofstream(path("particles.pvd")) << text.substr(0, text.find("000005") + 3);
  });
  options.restart_step = 7;
  write_frames(options, all, 7, 10);
  barrier();
  const std::string list = text_of(path("particles.pvd"));
  expect_mentions(list, {"000000.pvtu", "000010.pvtu", "</VTKFile>"});
  EXPECT_EQ(list.find("000005"), std::string::npos);
}

TEST_F(Output, VtuFailuresReachAllRanks) {
  FrameOptions options = frame_options(folder());
  options.fields.push_back("vorticity");
  expect_mentions(input_error_of([&] { make_vtu_writer(world, options); }), {"unknown output field", "vorticity"});
  options.fields = {"id"};
  const auto writer = make_vtu_writer(world, options);
  EXPECT_FALSE(writer->wants_density());
  if (rank_of(world) == 0) fs::remove_all(path("vtu"));
  barrier();
  EXPECT_THROW(writer->observe(frame_of(Clock{}, my_part(whole_cloud(5)))), RunError);
}

}  // namespace
}  // namespace trevi

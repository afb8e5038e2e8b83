// VTKHDF frames, read back with VTK's own reader (which brings a serial HDF5 of its own), with an empty rank among the
// writers.
#include <vtkDataArray.h>
#include <vtkHDFReader.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "frames.hpp"
#include "io/frames/blowup.hpp"
#include "io/frames/vtkhdf.hpp"

namespace trevi {
namespace {

/// What VTK reads; the reader owns it.
struct Reading {
  vtkNew<vtkHDFReader> reader;
  explicit Reading(const std::string& path) {
    EXPECT_NE(reader->CanReadFile(path.c_str()), 0) << path;
    reader->SetFileName(path.c_str());
    reader->Update();
  }
  vtkUnstructuredGrid* grid() { return vtkUnstructuredGrid::SafeDownCast(reader->GetOutputDataObject(0)); }
  vtkDataArray* array(const char* name) { return grid()->GetPointData()->GetArray(name); }
};

void expect_frame(const std::string& path, const Particles& all) {
  Reading reading(path);
  ASSERT_NE(reading.grid(), nullptr) << path;
  const auto count = static_cast<vtkIdType>(all.id.size());
  ASSERT_EQ(reading.grid()->GetNumberOfPoints(), count);
  ASSERT_EQ(reading.grid()->GetNumberOfCells(), count);
  for (const char* name : {"velocity", "density", "id", "rank", "rgb"}) ASSERT_NE(reading.array(name), nullptr) << name;
  EXPECT_EQ(reading.array("id")->GetDataTypeSize(), 8);
  EXPECT_EQ(reading.array("rgb")->GetDataType(), VTK_UNSIGNED_CHAR);
  std::vector<int> seen(all.id.size(), 0);
  for (vtkIdType i = 0; i < count; ++i) {
    const std::size_t row = row_of(all, id_of(reading.array("id"), i));
    ASSERT_LT(row, all.id.size());
    ++seen[row];
    EXPECT_EQ(Vec3(reading.grid()->GetPoint(i)), all.position[row]);
    EXPECT_EQ(reading.grid()->GetCellType(i), VTK_VERTEX);
    EXPECT_EQ(reading.grid()->GetCell(i)->GetPointId(0), i);
    EXPECT_EQ(reading.array("density")->GetTuple1(i), static_cast<float>(1000 + all.position[row].x()));
    EXPECT_EQ(reading.array("velocity")->GetTuple3(i)[2], static_cast<float>(all.velocity[row].z()));
    EXPECT_EQ(reading.array("rgb")->GetTuple3(i)[0], rainbow(all.hue[row])[0]);
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
}

void write_frames(const FrameOptions& options, const Particles& all, std::int64_t first, std::int64_t last) {
  const Particles mine = my_part(all);
  std::vector<Real> density;
  for (const Vec3& p : mine.position) density.push_back(1000 + p.x());
  const auto writer = make_vtkhdf_writer(world, options);
  EXPECT_TRUE(writer->wants_density());
  for (Clock clock{first, 0.1, 1}; clock.step <= last; ++clock.step) {
    if (writer->due(clock)) writer->observe(frame_of(clock, mine, density));
  }
  barrier();
}

/// Name and time of each frame that the series lists.
std::vector<std::pair<std::string, double>> listed(const std::string& path) {
  const auto series = nlohmann::json::parse(text_of(path));
  EXPECT_EQ(series.at("file-series-version"), "1.0");
  std::vector<std::pair<std::string, double>> frames;
  for (const auto& file : series.at("files")) frames.emplace_back(file.at("name"), file.at("time"));
  return frames;
}

TEST_F(Output, VtkHdfFramesReadBackWithAnEmptyRank) {
  const Particles all = whole_cloud(500);
  write_frames(frame_options(folder()), all, 0, 12);
  if (rank_of(world) == 0) {
    for (const char* step : {"000000", "000005", "000010"}) {
      expect_frame(path(std::string("particles_") + step + ".hdf"), all);
    }
    const auto frames = listed(path("particles.hdf.series"));
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames[1], std::make_pair(std::string("particles_000005.hdf"), 0.5));
    EXPECT_FALSE(fs::exists(path("particles_000010.hdf.tmp")));
  }
}

TEST_F(Output, VtkHdfIsTheSameBytesOnAnyNumberOfThreads) {
  const Particles all = whole_cloud(50000, 3);
  const auto texts = on_threads(path("particles_000000.hdf"), [&] {
    if (rank_of(world) == 0) fs::remove_all(path("particles.hdf.series"));
    barrier();
    write_frames(frame_options(folder()), all, 0, 0);
  });
  EXPECT_GT(texts[0].size(), 56 * all.id.size());
  EXPECT_TRUE(texts[0] == texts[1] && texts[0] == texts[2]);
}

TEST_F(Output, VtkHdfWithoutParticles) {
  write_frames(frame_options(folder()), whole_cloud(0), 0, 0);
  if (rank_of(world) == 0) {
    Reading reading(path("particles_000000.hdf"));
    ASSERT_NE(reading.grid(), nullptr);
    EXPECT_EQ(reading.grid()->GetNumberOfPoints(), 0);
  }
}

TEST_F(Output, VtkHdfRestartSetsLaterFramesAside) {
  const Particles all = whole_cloud(50);
  FrameOptions options = frame_options(folder());
  write_frames(options, all, 0, 12);
  options.restart_step = 7;
  write_frames(options, all, 7, 9);
  EXPECT_TRUE(fs::exists(path("particles_000010.hdf.stale")));
  EXPECT_FALSE(fs::exists(path("particles_000010.hdf")));
  EXPECT_EQ(listed(path("particles.hdf.series")).size(), 2U);
  barrier();
  write_frames(options, all, 7, 10);
  const auto frames = listed(path("particles.hdf.series"));
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[2], std::make_pair(std::string("particles_000010.hdf"), 1.0));
  if (rank_of(world) == 0) expect_frame(path("particles_000010.hdf"), all);
}

TEST_F(Output, VtkHdfInAMissingFolderFailsOnAllRanks) {
  FrameOptions options = frame_options(folder());
  options.fields = {"id"};
  const auto writer = make_vtkhdf_writer(world, options);
  EXPECT_FALSE(writer->wants_density());
  barrier();
  if (rank_of(world) == 0) fs::remove_all(folder());
  barrier();
  EXPECT_THROW(writer->observe(frame_of(Clock{}, my_part(whole_cloud(5)))), RunError);
}

TEST_F(Output, BlowUpFileOpensWhateverIsInIt) {
  Particles all = whole_cloud(60);
  all.predicted = all.position;
  all.velocity[7].setConstant(std::numeric_limits<Real>::quiet_NaN());
  Particles mine = my_part(all);
  for (std::size_t k = 0; k < mine.id.size(); ++k) {
    if (mine.id[k] == all.id[7]) mine.predicted[k].setConstant(std::numeric_limits<Real>::infinity());
  }
  const std::string file = write_blowup(world, folder(), {37, mine, "rank 0, step 37: so it went"});
  EXPECT_EQ(file, path("blowup_000037.h5"));
  if (rank_of(world) != 0) return;
  Reading reading(path("blowup_000037.hdf"));
  ASSERT_NE(reading.grid(), nullptr);
  ASSERT_EQ(reading.grid()->GetNumberOfPoints(), 60);
  int bad = 0;
  for (vtkIdType i = 0; i < 60; ++i) {
    const std::size_t row = row_of(all, id_of(reading.array("id"), i));
    EXPECT_EQ(Vec3(reading.grid()->GetPoint(i)), all.position[row]);
    bad += std::isnan(reading.array("velocity")->GetTuple3(i)[0]) &&
           std::isinf(reading.array("predicted")->GetTuple3(i)[0]);
  }
  EXPECT_EQ(bad, 1);
}

}  // namespace
}  // namespace trevi

// [[output.frames]]: what is selected against brute force, means over cells against brute force, and what VTK's reader
// makes of the files, with an empty rank among the writers.
#include <vtkDataArray.h>
#include <vtkHDFReader.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>

#include <set>

#include "base/hash.hpp"
#include "frames.hpp"
#include "io/frames/frame_sets.hpp"
#include "io/writers.hpp"

namespace trevi {
namespace {

constexpr Real h = 0.2;

Settings cube() {
  Settings settings;
  settings.domain = {Vec3::Constant(-1), Vec3::Constant(1)};
  settings.fluid.spacing = h / 2;
  settings.fluid.kernel_radius = h;
  settings.output.directory = "unused";
  return settings;
}

FrameSetSettings every_step() {
  FrameSetSettings set;
  set.schedule.every_steps = 1;
  return set;
}

Real density_at(const Vec3& p) { return 1000 + p.x(); }

std::vector<Real> densities(const Particles& particles) {
  std::vector<Real> density;
  for (const Vec3& p : particles.position) density.push_back(density_at(p));
  return density;
}

/// Writes frames of the steps from `first` to `last` that are due, with all ranks' particles.
void write_frames(MPI_Comm comm, const Settings& settings, const Particles& mine, const WriterOptions& options,
                  std::pair<std::int64_t, std::int64_t> steps = {0, 0}) {
  const std::vector<Real> density = densities(mine);
  const auto writers = make_writers(comm, settings, options);
  for (Clock clock{steps.first, 0.1, 1}; clock.step <= steps.second; ++clock.step) {
    for (const auto& writer : writers)
      if (writer->due(clock)) writer->observe(frame_of(clock, mine, density));
  }
}

WriterOptions writer_options(const std::string& folder, GlobalId particles) {
  WriterOptions options;
  options.directory = folder;
  options.particles = particles;
  return options;
}

/// What VTK reads; the reader owns it.
struct Reading {
  vtkNew<vtkHDFReader> reader;
  explicit Reading(const std::string& path) {
    EXPECT_NE(reader->CanReadFile(path.c_str()), 0) << path;
    reader->SetFileName(path.c_str());
    reader->Update();
  }
  vtkUnstructuredGrid* grid() { return vtkUnstructuredGrid::SafeDownCast(reader->GetOutputDataObject(0)); }
  vtkImageData* image() { return vtkImageData::SafeDownCast(reader->GetOutputDataObject(0)); }
};

// ---- particles --------------------------------------------------------------------------------------------------

using Cell = std::array<int, 3>;

Cell cell_of(const Vec3& p) {
  Cell cell{};
  for (const int a : {0, 1, 2})
    cell[static_cast<std::size_t>(a)] = std::clamp(static_cast<int>(std::floor((p[a] + 1) / h)), 0, 9);
  return cell;
}

/// Whether a set holds particle k, by all pairs and without the code of the writers but for the hash.
bool holds(const FrameSetSettings& set, const Particles& all, const std::set<Cell>& wet, std::size_t k) {
  const Vec3& p = all.position[k];
  if (set.box)
    for (const int a : {0, 1, 2})
      if (p[a] < set.box->min[a] || p[a] >= set.box->max[a]) return false;
  if (mix(static_cast<std::uint64_t>(all.id[k])) % static_cast<std::uint64_t>(set.one_in) != 0) return false;
  if (!set.surface) return true;
  const Cell cell = cell_of(p);
  for (int n = 0; n < 27; ++n)
    if (!wet.contains({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1})) return true;
  return false;
}

std::set<GlobalId> selected_by_force(const FrameSetSettings& set, const Particles& all) {
  std::set<Cell> wet;
  for (const Vec3& p : all.position) wet.insert(cell_of(p));
  std::set<GlobalId> ids;
  for (std::size_t k = 0; k < all.id.size(); ++k)
    if (holds(set, all, wet, k)) ids.insert(all.id[k]);
  return ids;
}

/// The ids in a file, each of which is once there, with the values of the cloud.
std::set<GlobalId> ids_in(const std::string& path, const Particles& all, bool single) {
  Reading reading(path);
  std::set<GlobalId> ids;
  if (reading.grid() == nullptr) {
    ADD_FAILURE() << path;
    return ids;
  }
  vtkPointData* const data = reading.grid()->GetPointData();
  const vtkIdType count = reading.grid()->GetNumberOfPoints();
  EXPECT_EQ(reading.grid()->GetNumberOfCells(), count);
  if (count > 0) {
    EXPECT_EQ(reading.grid()->GetPoints()->GetDataType(), single ? VTK_FLOAT : VTK_DOUBLE);
  }
  for (vtkIdType i = 0; i < count; ++i) {
    const GlobalId id = id_of(data->GetArray("id"), i);
    const std::size_t row = row_of(all, id);
    EXPECT_TRUE(ids.insert(id).second) << id << " twice";
    const Vec3 exact = all.position[row], written(reading.grid()->GetPoint(i));
    for (const int a : {0, 1, 2})
      EXPECT_EQ(written[a], single ? static_cast<Real>(static_cast<float>(exact[a])) : exact[a]) << a;
    EXPECT_EQ(reading.grid()->GetCellType(i), VTK_VERTEX);
    EXPECT_EQ(reading.grid()->GetCell(i)->GetPointId(0), i);
    EXPECT_EQ(data->GetArray("density")->GetTuple1(i), static_cast<float>(density_at(exact)));
    EXPECT_EQ(data->GetArray("velocity")->GetTuple3(i)[1], static_cast<float>(all.velocity[row].y()));
  }
  return ids;
}

std::vector<FrameSetSettings> selections() {
  std::vector<FrameSetSettings> sets(6, every_step());
  sets[1].one_in = 8;
  sets[2].surface = true;
  sets[3].box = Box{Vec3(-0.5, -0.4, -1), Vec3(0.3, 0.7, 0.1)};
  sets[4].one_in = 2;
  sets[4].surface = true;
  sets[4].box = Box{Vec3(-1, -1, -1), Vec3(0.5, 1.5, 1.5)};
  sets[5].box = Box{Vec3(0.9, 0.9, 0.9), Vec3(0.90001, 0.90001, 0.90001)};  // nobody
  for (std::size_t k = 0; k < sets.size(); k += 2) sets[k].precision = Precision::single;
  return sets;
}

TEST_F(Output, FrameSetsHoldWhatBruteForceSelects) {
  const Particles all = whole_cloud(4000);
  Settings settings = cube();
  settings.output.frames = selections();
  write_frames(world, settings, my_part(all), writer_options(folder(), 4000));
  barrier();
  if (rank_of(world) != 0) return;
  const std::vector<FrameSetSettings>& sets = settings.output.frames;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    SCOPED_TRACE(k);
    const std::set<GlobalId> expected = selected_by_force(sets[k], all);
    EXPECT_EQ(
        ids_in(path(folder_of(sets[k], k) + "/particles_000000.hdf"), all, sets[k].precision == Precision::single),
        expected);
    EXPECT_EQ(expected.empty(), k == 5);
    EXPECT_EQ(expected.size() == 4000U, k == 0) << "each selection leaves something out";
  }
}

TEST_F(Output, DisjointBoxesHoldEachParticleOnce) {
  Particles all = whole_cloud(3000);
  all.position[5] = Vec3(1, 1, 1);  // on the walls, and on the faces of the boxes
  all.position[6] = Vec3(-1, 0.25, -1);
  all.position[7] = Vec3(0.1, 0.25, -0.3);
  Settings settings = cube();
  const Vec3 cut(0.1, 0.25, -0.3);
  for (int n = 0; n < 8; ++n) {
    Box box = settings.domain;
    for (const int a : {0, 1, 2}) ((n >> a & 1) != 0 ? box.min : box.max)[a] = cut[a];
    settings.output.frames.push_back(every_step());
    settings.output.frames.back().box = box;
  }
  write_frames(world, settings, my_part(all), writer_options(folder(), 3000));
  barrier();
  if (rank_of(world) != 0) return;
  std::multiset<GlobalId> found;
  for (int n = 0; n < 8; ++n) {
    const auto ids = ids_in(path("frames_" + std::to_string(n) + "/particles_000000.hdf"), all, false);
    EXPECT_GT(ids.size(), 0U);
    found.insert(ids.begin(), ids.end());
  }
  EXPECT_EQ(found, std::multiset<GlobalId>(all.id.begin(), all.id.end()));
}

// ---- cells ------------------------------------------------------------------------------------------------------

struct Sums {
  Real particles = 0, density = 0;
  Vec3 velocity = Vec3::Zero();
};

std::map<Cell, Sums> sums_by_force(const Particles& all) {
  std::map<Cell, Sums> sums;
  for (std::size_t k = 0; k < all.id.size(); ++k) {
    Sums& sum = sums[cell_of(all.position[k])];
    sum.particles += 1;
    sum.density += density_at(all.position[k]);
    sum.velocity += all.velocity[k];
  }
  return sums;
}

/// A single cell along y has two points, on its faces.
void expect_means(const std::string& path, const Particles& all, const Cell& first, const Cell& count) {
  std::map<Cell, Sums> sums = sums_by_force(all);
  const bool flat = count[1] == 1;
  const int rows = flat ? 2 : count[1];
  Reading reading(path);
  vtkImageData* const image = reading.image();
  ASSERT_NE(image, nullptr) << path;
  ASSERT_EQ(image->GetNumberOfPoints(), count[0] * rows * count[2]);
  vtkPointData* const data = image->GetPointData();
  for (vtkIdType i = 0; i < image->GetNumberOfPoints(); ++i) {
    const int n = static_cast<int>(i), row = n / count[0] % rows;
    const Cell cell{first[0] + n % count[0], first[1] + (flat ? 0 : row), first[2] + n / count[0] / rows};
    const Real y = flat ? first[1] + row : cell[1] + 0.5;
    const Vec3 middle(image->GetPoint(i)), expected = h * Vec3(cell[0] + 0.5, y, cell[2] + 0.5) - Vec3::Ones();
    EXPECT_LT((middle - expected).norm(), 1e-12);
    const Sums& sum = sums[cell];
    const Real particles = std::max(sum.particles, 1.0);
    EXPECT_NEAR(data->GetArray("fraction")->GetTuple1(i), sum.particles / 8, 1e-7 * particles);
    EXPECT_NEAR(data->GetArray("density")->GetTuple1(i), sum.density / particles, 1e-4);
    for (const int a : {0, 1, 2})
      EXPECT_NEAR(data->GetArray("velocity")->GetTuple3(i)[a], sum.velocity[a] / particles, 1e-6);
  }
}

FrameSetSettings cells_every_step() {
  FrameSetSettings set = every_step();
  set.what = FrameContent::cells;
  set.fields = {"fraction", "velocity", "density"};
  return set;
}

TEST_F(Output, CellMeansAreThoseOfBruteForce) {
  const Particles all = whole_cloud(4000);
  Settings settings = cube();
  settings.output.frames = {cells_every_step(), cells_every_step()};
  settings.output.frames[1].box = Box{Vec3(-0.59, -1, 0.2), Vec3(0.3, -0.8, 9)};
  write_frames(world, settings, my_part(all), writer_options(folder(), 4000));
  barrier();
  if (rank_of(world) != 0) return;
  expect_means(path("frames_0/cells_000000.hdf"), all, {0, 0, 0}, {10, 10, 10});
  expect_means(path("frames_1/cells_000000.hdf"), all, {2, 0, 6}, {5, 1, 4});
}

TEST_F(Output, CellMeansAreTheSameBytesOnAnyRanks) {
  const Particles all = whole_cloud(3000);
  Settings settings = cube();
  settings.output.frames = {cells_every_step()};
  write_frames(world, settings, my_part(all), writer_options(folder(), 3000));
  if (rank_of(world) == 0) {
    fs::create_directories(path("alone"));
    write_frames(MPI_COMM_SELF, settings, all, writer_options(path("alone"), 3000));
    EXPECT_TRUE(text_of(path("frames_0/cells_000000.hdf")) == text_of(path("alone/frames_0/cells_000000.hdf")));
    EXPECT_GT(text_of(path("frames_0/cells_000000.hdf")).size(), 20U * 1000);
  }
  barrier();
}

TEST_F(Output, CellMeansOfNothingAreZero) {
  Settings settings = cube();
  settings.output.frames = {cells_every_step()};
  write_frames(world, settings, my_part(whole_cloud(0)), writer_options(folder(), 0));
  barrier();
  if (rank_of(world) == 0) expect_means(path("frames_0/cells_000000.hdf"), whole_cloud(0), {0, 0, 0}, {10, 10, 10});
}

// ---- files ------------------------------------------------------------------------------------------------------

TEST_F(Output, FrameSetsHaveFoldersSchedulesAndRestartsOfTheirOwn) {
  const Particles all = whole_cloud(100);
  Settings settings = cube();
  settings.output.frames = {every_step(), cells_every_step(), every_step()};
  settings.output.frames[1].schedule.every_steps = 2;
  settings.output.frames[2].name = "thin";
  settings.output.frames[2].one_in = 4;
  settings.output.frames[2].schedule.every_steps = 3;
  WriterOptions options = writer_options(folder(), 100);
  write_frames(world, settings, my_part(all), options, {0, 6});
  barrier();
  EXPECT_TRUE(fs::exists(path("frames_0/particles_000005.hdf")));
  EXPECT_FALSE(fs::exists(path("frames_1/cells_000005.hdf")));
  EXPECT_TRUE(fs::exists(path("frames_thin/particles_000006.hdf")));
  barrier();
  options.restart_step = 4;
  write_frames(world, settings, my_part(all), options, {4, 5});
  barrier();
  EXPECT_TRUE(fs::exists(path("frames_0/particles_000006.hdf.stale")));
  EXPECT_TRUE(fs::exists(path("frames_1/cells_000006.hdf.stale")));
  EXPECT_TRUE(fs::exists(path("frames_thin/particles_000006.hdf.stale")));
  if (rank_of(world) != 0) return;
  const auto last = [&](const std::string& list) { return read_frame_list(path(list)).back().step; };
  EXPECT_EQ(last("frames_0/particles.hdf.series"), 5);
  EXPECT_EQ(last("frames_1/cells.hdf.series"), 4);
  EXPECT_EQ(last("frames_thin/particles.hdf.series"), 3);
}

}  // namespace
}  // namespace trevi

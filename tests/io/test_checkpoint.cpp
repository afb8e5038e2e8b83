// Checkpoints and particle files: the same bytes on any rank count, exact round trips, and a clear word on damaged
// files.
#include <hdf5.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

#include "io/hdf5/checkpoint.hpp"
#include "io/hdf5/hdf5_reader.hpp"
#include "io/hdf5/id_order.hpp"
#include "io/hdf5/particle_file.hpp"
#include "support/output_fixture.hpp"

namespace trevi {
namespace {

// ---- checkpoints ------------------------------------------------------------------------------------------------

const CheckpointInfo info{"[domain]\nmin = [0,0,0]\n# ü\n", "0.1.0", 11};

void write_alone(const std::string& path, const Particles& all, const Clock& clock) {
  if (rank_of(world) == 0) write_checkpoint(MPI_COMM_SELF, path, info, frame_of(clock, all));
  barrier();
}

TEST_F(Output, CheckpointIsTheSameBytesOnAnyRankCount) {
  for (const int count : {0, 3, 1000, 20000}) {
    const Particles all = whole_cloud(count);
    const Clock clock{120, 0.01, 2};
    write_checkpoint(world, path("ranks.h5"), info, frame_of(clock, my_part(all)));
    if (count == 3) std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // a time stamp would differ
    write_alone(path("alone.h5"), part_of(all, 0, 1), clock);
    const std::string content = text_of(path("ranks.h5"));
    EXPECT_GT(content.size(), 56u * static_cast<std::size_t>(count));
    EXPECT_TRUE(content == text_of(path("alone.h5"))) << count << " particles";
    EXPECT_FALSE(fs::exists(path("ranks.h5.tmp")));
    barrier();
  }
}

TEST_F(Output, CheckpointIsTheSameBytesOnAnyNumberOfThreads) {
  const Particles all = whole_cloud(100000, 3), mine = my_part(all);
  const Clock clock{120, 0.01, 2};
  const auto texts =
      on_threads(path("c.h5"), [&] { write_checkpoint(world, path("c.h5"), info, frame_of(clock, mine)); });
  EXPECT_GT(texts[0].size(), 56 * all.id.size());
  EXPECT_TRUE(texts[0] == texts[1] && texts[0] == texts[2]);
}

/// Any order of 200,000 ids below `range`, some of them equal.
std::vector<GlobalId> mixed_ids(GlobalId range) {
  std::mt19937_64 random(static_cast<std::uint64_t>(rank_of(world)));
  std::uniform_int_distribution<GlobalId> any(0, range);
  std::vector<GlobalId> ids(200000);
  for (GlobalId& id : ids) id = any(random);
  return ids;
}

TEST_F(Output, IdOrderIsTheSameOnAnyNumberOfThreads) {
  const int before = thread_count();
  for (const GlobalId range : {GlobalId{1000}, GlobalId{500000}, GlobalId{1} << 31}) {
    const std::vector<GlobalId> ids = mixed_ids(range);
    std::vector<std::vector<LocalId>> moved;
    for (const int threads : {1, 2, 3, 4}) {
      use_threads(threads);
      std::vector<LocalId> index(ids.size());
      for (std::size_t k = 0; k < ids.size(); ++k) index[k] = static_cast<LocalId>(k);
      const IdOrder order(world, ids);
      EXPECT_TRUE(std::is_sorted(order.ids().begin(), order.ids().end()));
      EXPECT_TRUE(order.apply(ids) == order.ids());
      moved.push_back(order.apply(index));
      EXPECT_TRUE(moved.back() == moved.front()) << threads << " threads, ids up to " << range;
    }
  }
  use_threads(before);
}

TEST_F(Output, CheckpointRoundTripIsSortedAndExact) {
  const Particles all = whole_cloud(5001);
  const Clock clock{120, 1.0 / 60, 2};
  write_checkpoint(world, path("c.h5"), info, frame_of(clock, my_part(all)));
  const CheckpointState state = read_checkpoint(world, path("c.h5"));
  EXPECT_EQ(state.step, 120);
  EXPECT_EQ(state.substeps, 2);
  EXPECT_EQ(state.dt, clock.dt);
  EXPECT_EQ(state.time, clock.time());
  EXPECT_EQ(state.info.scene_text, info.scene_text);
  EXPECT_EQ(state.info.program_version, "0.1.0");
  EXPECT_EQ(state.info.seed, 11);
  const RowSlice slice = equal_slice(5001, rank_of(world), size_of(world), 1024);
  EXPECT_EQ(state.rows.total, 5001);
  ASSERT_EQ(state.rows.id.size(), static_cast<std::size_t>(slice.count));
  for (std::size_t k = 0; k < state.rows.id.size(); ++k) {
    const auto row = static_cast<std::size_t>(slice.first) + k;
    EXPECT_EQ(state.rows.id[k], all.id[row]);
    EXPECT_EQ(state.rows.position[k], all.position[row]);
    EXPECT_EQ(state.rows.velocity[k], all.velocity[row]);
    EXPECT_EQ(state.rows.hue[k], all.hue[row]);
  }
}

TEST_F(Output, CheckpointWithoutHueHasNone) {
  Particles all = whole_cloud(10);
  all.has_hue = false;
  all.hue.clear();
  write_checkpoint(world, path("c.h5"), info, frame_of(Clock{0, 0.1, 1}, my_part(all)));
  EXPECT_TRUE(read_checkpoint(world, path("c.h5")).rows.hue.empty());
}

CheckpointOptions checkpoint_options(const std::string& folder, int keep) {
  CheckpointOptions options;
  options.directory = folder;
  options.schedule.every_steps = 10;
  options.keep = keep;
  options.info = info;
  return options;
}

TEST_F(Output, CheckpointsAreKeptRestartedAndSetAside) {
  const Particles mine = my_part(whole_cloud(20));
  CheckpointOptions options = checkpoint_options(folder(), 3);
  {
    CheckpointWriter writer(world, options);
    for (Clock clock{0, 0.1, 1}; clock.step <= 45; ++clock.step) {
      if (writer.due(clock)) writer.observe(frame_of(clock, mine));
    }
    writer.finish(frame_of(Clock{45, 0.1, 1}, mine));
  }
  EXPECT_FALSE(fs::exists(path("checkpoint_000020.h5")));
  for (const char* name : {"checkpoint_000030.h5", "checkpoint_000040.h5", "checkpoint_000045.h5"}) {
    EXPECT_TRUE(fs::exists(path(name))) << name;
  }
  EXPECT_EQ(newest_checkpoints(world, folder()).front(), path("checkpoint_000045.h5"));
  barrier();
  options.restart_step = 30;
  CheckpointWriter writer(world, options);
  EXPECT_FALSE(writer.due(Clock{30, 0.1, 1}));
  EXPECT_TRUE(writer.due(Clock{40, 0.1, 1}));
  EXPECT_TRUE(fs::exists(path("checkpoint_000045.h5.stale")));
  EXPECT_EQ(newest_checkpoints(world, folder()).front(), path("checkpoint_000030.h5"));
}

TEST_F(Output, BlownUpStateDoesNotBecomeTheLastCheckpoint) {
  Particles mine = my_part(whole_cloud(20));
  CheckpointWriter writer(world, checkpoint_options(folder(), 2));
  writer.observe(frame_of(Clock{10, 0.1, 1}, mine));
  if (rank_of(world) == 0) mine.velocity[0].x() = std::numeric_limits<Real>::quiet_NaN();
  writer.finish(frame_of(Clock{15, 0.1, 1}, mine));
  EXPECT_EQ(newest_checkpoints(world, folder()).front(), path("checkpoint_000010.h5"));
}

TEST_F(Output, CheckpointInAMissingFolderFailsOnAllRanks) {
  const Particles mine = my_part(whole_cloud(20));
  EXPECT_THROW(write_checkpoint(world, path("nowhere/c.h5"), info, frame_of(Clock{}, mine)), RunError);
  EXPECT_NE(input_error_of([&] { newest_checkpoints(world, folder()); }).find("--restart FILE"), std::string::npos);
}

// ---- damaged and foreign files ----------------------------------------------------------------------------------

class Damaged : public Output {
 protected:
  void SetUp() override {
    Output::SetUp();
    all = whole_cloud(1000);
    write_checkpoint(world, path("good.h5"), info, frame_of(Clock{1, 0.1, 1}, my_part(all)));
  }
  void write_as(const std::string& name, const std::string& content) {
    if (rank_of(world) == 0) std::ofstream(path(name), std::ios::binary) << content;
    barrier();
  }
  std::string reading(const std::string& name) {
    return input_error_of([&] { read_checkpoint(world, path(name)); });
  }
  /// A copy of the good file on which `change` has worked.
  template <class Change>
  void change_copy(const std::string& name, const Change& change) {
    if (rank_of(world) == 0) {
      fs::copy_file(path("good.h5"), path(name));
      const hid_t file = H5Fopen(path(name).c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
      change(file);
      H5Fclose(file);
    }
    barrier();
  }
  Particles all;
};

void write_table(hid_t file, const char* name, hid_t type, std::vector<hsize_t> shape) {
  const hid_t space = H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr);
  const hid_t dataset = H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  H5Dclose(dataset);
  H5Sclose(space);
}

TEST_F(Damaged, MissingForeignAndTruncatedFiles) {
  const std::string content = text_of(path("good.h5"));
  write_as("text.h5", "not a checkpoint");
  write_as("empty.h5", "");
  write_as("short.h5", content.substr(0, content.size() / 2));
  expect_mentions(reading("none.h5"), {"none.h5", "No such file", "check the path"});
  expect_mentions(reading("text.h5"), {"text.h5", "not an HDF5 file"});
  expect_mentions(reading("empty.h5"), {"empty.h5", "not an HDF5 file"});
  expect_mentions(reading("short.h5"), {"short.h5", "cut short", "truncated", "older checkpoint"});
  expect_mentions(input_error_of([&] { read_checkpoint(world, folder()); }), {folder(), "not an HDF5 file"});
}

TEST_F(Damaged, FlippedBitMeetsTheChecksum) {
  std::string content = text_of(path("good.h5"));
  std::string bytes(24, '\0');
  std::memcpy(bytes.data(), all.position[900].data(), 24);
  const std::size_t at = content.find(bytes);
  ASSERT_NE(at, std::string::npos);
  content[at + 3] = static_cast<char>(content[at + 3] ^ 1);
  write_as("bit.h5", content);
  expect_mentions(reading("bit.h5"), {"bit.h5", "/particles/position", "checksum", "damaged"});
}

TEST_F(Damaged, MissingAndMisshapenParts) {
  change_copy("no_velocity.h5", [](hid_t file) { H5Ldelete(file, "/particles/velocity", H5P_DEFAULT); });
  change_copy("no_position.h5", [](hid_t file) { H5Ldelete(file, "/particles/position", H5P_DEFAULT); });
  change_copy("no_step.h5", [](hid_t file) { H5Adelete(file, "step"); });
  change_copy("no_scene.h5", [](hid_t file) { H5Ldelete(file, "/scene", H5P_DEFAULT); });
  change_copy("shape.h5", [](hid_t file) {
    H5Ldelete(file, "/particles/velocity", H5P_DEFAULT);
    write_table(file, "/particles/velocity", H5T_NATIVE_DOUBLE, {1000, 2});
  });
  change_copy("type.h5", [](hid_t file) {
    H5Ldelete(file, "/particles/id", H5P_DEFAULT);
    write_table(file, "/particles/id", H5T_NATIVE_DOUBLE, {1000});
  });
  change_copy("rows.h5", [](hid_t file) {
    H5Ldelete(file, "/particles/id", H5P_DEFAULT);
    write_table(file, "/particles/id", H5T_NATIVE_INT64, {999});
  });
  expect_mentions(reading("no_velocity.h5"), {"no_velocity.h5", "/particles/velocity", "missing"});
  expect_mentions(reading("no_position.h5"), {"no_position.h5", "/particles/position", "missing"});
  expect_mentions(reading("no_step.h5"), {"no_step.h5", "attribute step", "missing"});
  expect_mentions(reading("no_scene.h5"), {"no_scene.h5", "/scene", "missing"});
  expect_mentions(reading("shape.h5"), {"/particles/velocity", "shape (1000, 2)", "(N, 3)"});
  expect_mentions(reading("type.h5"), {"/particles/id", "wrong type", "integers"});
  expect_mentions(reading("rows.h5"), {"/particles/id", "999 rows", "1000"});
}

// ---- particle files ---------------------------------------------------------------------------------------------

/// A file as a user writes one: single precision and no chunks; ids only when given.
void write_cloud(const std::string& path, const std::vector<float>& position, const std::vector<int>& ids) {
  if (rank_of(world) == 0) {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    H5Gclose(H5Gcreate2(file, "/particles", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    write_table(file, "/particles/position", H5T_NATIVE_FLOAT, {position.size() / 3, 3});
    const hid_t dataset = H5Dopen2(file, "/particles/position", H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, position.data());
    H5Dclose(dataset);
    if (!ids.empty()) {
      write_table(file, "/particles/id", H5T_NATIVE_INT, {ids.size()});
      const hid_t numbers = H5Dopen2(file, "/particles/id", H5P_DEFAULT);
      H5Dwrite(numbers, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, ids.data());
      H5Dclose(numbers);
    }
    H5Fclose(file);
  }
  barrier();
}

TEST_F(Output, ParticleFileDefaultsIdAndVelocity) {
  write_cloud(path("cloud.h5"), {0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9.5f}, {});
  const ParticleRows rows = read_particle_file(world, path("cloud.h5"));
  const RowSlice slice = equal_slice(4, rank_of(world), size_of(world));
  EXPECT_EQ(rows.total, 4);
  ASSERT_EQ(rows.id.size(), static_cast<std::size_t>(slice.count));
  for (std::size_t k = 0; k < rows.id.size(); ++k) {
    EXPECT_EQ(rows.id[k], slice.first + static_cast<GlobalId>(k));
    EXPECT_EQ(rows.velocity[k], Vec3::Zero());
    if (rows.id[k] == 3) {
      EXPECT_EQ(rows.position[k], Vec3(7, 8, 9.5));
    }
  }
}

TEST_F(Output, ParticleFileRejectsBadIdsAndNan) {
  write_cloud(path("twice.h5"), std::vector<float>(15, 1.0f), {7, 3, 9, 4, 7});
  write_cloud(path("nan.h5"), {0, 0, 0, 1, 2, 3, 4, NAN, 6}, {});
  write_cloud(path("unique.h5"), std::vector<float>(15, 1.0f), {7, 3, 9, 4, 0});
  write_cloud(path("negative.h5"), std::vector<float>(15, 1.0f), {7, 3, 9, 4, -7});
  expect_mentions(input_error_of([&] { read_particle_file(world, path("twice.h5")); }),
                  {"twice.h5", "/particles/id", "7 occurs more than once"});
  expect_mentions(input_error_of([&] { read_particle_file(world, path("nan.h5")); }),
                  {"nan.h5", "/particles/position", "row 2", "not finite"});
  expect_mentions(input_error_of([&] { read_particle_file(world, path("negative.h5")); }),
                  {"negative.h5", "/particles/id", "row 4 is -7"});
  EXPECT_NO_THROW(read_particle_file(world, path("unique.h5")));
}

}  // namespace
}  // namespace trevi

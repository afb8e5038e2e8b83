// Series, progress, report, folder, and what the output layer is built on; on any number of ranks.
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/frames/colour.hpp"
#include "io/frames/frame_list_file.hpp"
#include "io/frames/vtkhdf.hpp"
#include "io/hdf5/id_order.hpp"
#include "io/run_directory/files.hpp"
#include "io/run_directory/output_directory.hpp"
#include "io/run_directory/progress.hpp"
#include "io/run_directory/run_report.hpp"
#include "io/tables/series.hpp"
#include "parallel/collective.hpp"
#include "support/output_fixture.hpp"

namespace trevi {
namespace {

// ---- collective failures ----------------------------------------------------------------------------------------

TEST_F(Output, FailureOfOneRankReachesAllWithItsKind) {
  const int last = size_of(world) - 1;
  const auto fail_on_last = [&](auto error) {
    all_or_none(world, [&] {
      if (rank_of(world) == last) throw error;
    });
  };
  EXPECT_THROW(fail_on_last(RunError("disk")), RunError);
  EXPECT_EQ(input_error_of([&] { fail_on_last(InputError("bad key")); }), "bad key");
  EXPECT_NO_THROW(all_or_none(world, [] {}));
}

// ---- texts ------------------------------------------------------------------------------------------------------

H5T_cset_t character_set(const std::string& path, const char* group, const char* name) {
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Hdf5Handle attribute(H5Aopen_by_name(file.id(), group, name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  return H5Tget_cset(type.id());
}

// ParaView 5.11 refuses a VTKHDF file whose Type is in UTF-8, which the reader of VTK 9.1 takes.
TEST_F(Output, TextAttributesAreAsciiWhereThatDoes) {
  VtkHdfFile file(world, path("frame.hdf"), my_part(whole_cloud(20)).position);
  file.file().attribute("plain", std::string("as it is"));
  file.file().attribute("accent", std::string("\u00e0 l'eau"));
  file.close();
  if (rank_of(world) != 0) return;
  EXPECT_EQ(character_set(path("frame.hdf"), "/VTKHDF", "Type"), H5T_CSET_ASCII);
  EXPECT_EQ(character_set(path("frame.hdf"), "/", "plain"), H5T_CSET_ASCII);
  EXPECT_EQ(character_set(path("frame.hdf"), "/", "accent"), H5T_CSET_UTF8);
}

// ---- order by id ------------------------------------------------------------------------------------------------

void expect_global_order(const Particles& all, GlobalId block) {
  const Particles mine = my_part(all);
  const IdOrder order(world, mine.id, block);
  const std::vector<Vec3> position = order.apply(mine.position);
  EXPECT_EQ(order.total(), static_cast<GlobalId>(all.id.size()));
  ASSERT_EQ(position.size(), order.ids().size());
  for (std::size_t k = 0; k < position.size(); ++k) {
    const auto row = static_cast<std::size_t>(order.first_row()) + k;  // the whole cloud is sorted by id
    EXPECT_EQ(order.ids()[k], all.id[row]);
    EXPECT_EQ(position[k], all.position[row]);
  }
  if (block > 1 && rank_of(world) + 1 < size_of(world)) {
    const bool at_end = order.first_row() + static_cast<GlobalId>(order.ids().size()) == order.total();
    EXPECT_TRUE(at_end || order.ids().size() % static_cast<std::size_t>(block) == 0);
  }
}

TEST_F(Output, IdOrderSortsAcrossRanks) {
  for (const int count : {0, 1, 5, 1000}) {
    for (const GlobalId block : {1, 64}) expect_global_order(whole_cloud(count), block);
  }
}

TEST_F(Output, IdOrderServesTheWholeRangeOfIds) {
  Particles all;
  all.id = {std::numeric_limits<GlobalId>::lowest(), -1, 0, std::numeric_limits<GlobalId>::max()};
  all.position.assign(4, Vec3::Ones());
  all.velocity = all.position;
  expect_global_order(all, 1);
}

TEST_F(Output, IdOrderBringsEqualIdsTogether) {
  const std::vector<GlobalId> ids = {42, rank_of(world) + 100};
  const IdOrder order(world, ids);
  const auto here = std::count(order.ids().begin(), order.ids().end(), 42);
  EXPECT_TRUE(here == 0 || here == size_of(world));
}

// ---- series -----------------------------------------------------------------------------------------------------

const char* const documented_columns =
    "step,time,dt,substeps,particles,iterations,density_mean,density_max,density_interior,compression_mean,"
    "compression_max,compression_rms,kinetic_energy,potential_energy,momentum_x,momentum_y,momentum_z,com_x,com_y,com_"
    "z,"
    "speed_max,top,front,front_q99,drift_max,imbalance,wall_seconds";

void run_series(SeriesWriter& series, std::int64_t first, std::int64_t last, Real density) {
  Diagnostics diagnostics;
  diagnostics.density_mean = density;
  diagnostics.density_interior = -std::numeric_limits<Real>::quiet_NaN();
  const FountainState fountains[2] = {{60, 12.5}, {NAN, 0}};
  const Particles none;
  for (Clock clock{first, 1.0 / 3, 1}; clock.step <= last; ++clock.step) {
    if (series.due(clock)) series.observe({clock, none, {}, &diagnostics, fountains});
  }
}

TEST_F(Output, SeriesRowsReadBackExactly) {
  EXPECT_EQ(series_header(0), documented_columns);
  {
    SeriesWriter series(world, {folder(), Schedule{0, 2}, 2, std::nullopt});
    run_series(series, 0, 4, 1000.0 / 3);
  }
  barrier();
  std::istringstream text(text_of(path("series.csv")));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], std::string(documented_columns) + ",note_0,speed_0,note_1,speed_1");
  EXPECT_EQ(lines[3].substr(0, 2), "4,");
  expect_mentions(lines[3], {"333.3333333333333", ",nan,", "60,12.5,nan,0"});
  EXPECT_EQ(lines[3].find("-nan"), std::string::npos);
  EXPECT_EQ(std::count(lines[0].begin(), lines[0].end(), ','), std::count(lines[3].begin(), lines[3].end(), ','));
}

TEST_F(Output, SeriesContinuesAfterARestart) {
  SeriesOptions options{folder(), Schedule{0, 1}, 2, std::nullopt};
  {
    SeriesWriter series(world, options);
    run_series(series, 0, 6, 5);
  }
  const std::string whole = text_of(path("series.csv"));
  barrier();
  if (rank_of(world) == 0) AppendFile(path("series.csv")).write("7,0.1,unfin");  // as a kill leaves it
  barrier();
  options.restart_step = 3;
  {
    SeriesWriter series(world, options);
    EXPECT_FALSE(series.due(Clock{3, 0.1, 1}));
    run_series(series, 3, 6, 5);
  }
  barrier();
  EXPECT_EQ(text_of(path("series.csv")), whole);
  options.fountains = 1;
  expect_mentions(input_error_of([&] { SeriesWriter other(world, options); }), {"series.csv", "another --output"});
}

Diagnostics row_of_energies(Real kinetic, Real potential) {
  Diagnostics row;
  row.particles = 10;
  row.kinetic_energy = kinetic;
  row.potential_energy = potential;
  return row;
}

TEST(EnergyRise, IsTheHighestAboveTheStartAsAFraction) {
  EnergyRise rise(4, 1, 1);  // 40 J for ten particles
  EXPECT_TRUE(std::isnan(rise.fraction()));
  for (const Real kinetic : {10.0, 12.0, 14.0, 6.0}) rise.add(row_of_energies(kinetic, 10));
  EXPECT_DOUBLE_EQ(rise.fraction(), 0.1) << "shallow water counts by a kernel radius";
  EnergyRise deep(1, 1, 1);
  for (const Real potential : {50.0, 40.0, 51.0}) deep.add(row_of_energies(0, potential));
  EXPECT_DOUBLE_EQ(deep.fraction(), 0.02);
  EnergyRise fall(1, 1, 1);
  for (const Real potential : {50.0, 40.0}) fall.add(row_of_energies(0, potential));
  EXPECT_EQ(fall.fraction(), 0);
}

TEST(EnergyRise, WithoutGravityIsAFractionOfTheMotionAtTheStart) {
  EnergyRise moving(0, 0, 1), resting(0, 0, 1), compressed(1, 1, 1);
  for (const Real kinetic : {2.0, 3.0}) moving.add(row_of_energies(kinetic, 0));
  EXPECT_DOUBLE_EQ(moving.fraction(), 0.5);
  for (const Real kinetic : {0.0, 3.0}) resting.add(row_of_energies(kinetic, 0));
  EXPECT_TRUE(std::isnan(resting.fraction()));
  Diagnostics dense = row_of_energies(1, 1);
  dense.compression_mean = 0.011;
  compressed.add(dense);
  EXPECT_TRUE(std::isnan(compressed.fraction()));
  for (const Real kinetic : {30.0, 33.1}) compressed.add(row_of_energies(kinetic, 1));
  EXPECT_DOUBLE_EQ(compressed.fraction(), 0.1) << "begins when the water has come apart";
}

TEST(EnergyRise, IsThatBeyondWhatIsSupplied) {
  EnergyRise pumped(1, 1, 1), gains(1, 1, 1);
  for (const Real supplied : {0.0, 20.0, 40.0}) pumped.add(row_of_energies(supplied * 0.9, 10), supplied);
  EXPECT_EQ(pumped.fraction(), 0);
  for (const Real supplied : {0.0, 20.0, 40.0}) gains.add(row_of_energies(supplied * 1.1, 10), supplied);
  EXPECT_NEAR(gains.fraction(), 4.0 / 44, 1e-12) << "of the largest energy of motion so far";
  EnergyRise still(1, 0, 1, 0.01);  // of rounding alone
  for (const Real supplied : {0.0, -2e-29}) still.add(row_of_energies(0, 0), supplied);
  EXPECT_TRUE(std::isnan(still.fraction()));
  EnergyRise beside(1, 0, 1);  // water at rest without gravity, and a body that spins with 8 J
  for (const Real supplied : {0.0, -1e-15, 1e-15}) beside.add(row_of_energies(0, 0), supplied, 8);
  EXPECT_LT(beside.fraction(), 1e-15) << "bodies are what they have less of but for rounding";
}

// Ten particles of 1 kg a metre apart on 5 m² are 2 m deep: 10 J m⁻¹ at rest, with g = 1.
TEST(EnergyRise, OfTheMotionCountsWhatAWaveHasAboveStillWater) {
  EnergyRise wave(1, 1, 2), still(1, 1, 2), unknown(1, 1, 2);
  for (EnergyRise* one : {&wave, &still}) one->set_tank(5, 1);
  for (const Real kinetic : {1.0, 0.5, 1.37}) wave.add(row_of_energies(kinetic, 10));
  EXPECT_NEAR(wave.fraction_of_motion(), 0.37, 1e-12);
  for (const Real kinetic : {0.0, 0.005}) still.add(row_of_energies(kinetic, 10));
  EXPECT_TRUE(std::isnan(still.fraction_of_motion())) << "hardly anything moves";
  for (const Real kinetic : {1.0, 2.0}) unknown.add(row_of_energies(kinetic, 10));
  EXPECT_TRUE(std::isnan(unknown.fraction_of_motion()));
}

// A run that goes on hears of the rows it keeps, on all ranks, and so knows its start.
TEST_F(Output, SeriesRecallsTheEnergyOfItsStart) {
  SeriesOptions options{folder(), Schedule{0, 1}, 2, std::nullopt};
  const auto write = [&](std::int64_t first, const std::vector<Real>& energies) {
    options.energy = std::make_shared<EnergyRise>(1, 1, 1);
    SeriesWriter series(world, options);
    const Particles particles;
    const std::vector<FountainState> fountains(2);
    for (const Real energy : energies) {
      const Diagnostics row = row_of_energies(energy, 0.5);
      series.observe(Frame{Clock{first++, 0.1, 1}, particles, {}, &row, fountains});
    }
    barrier();
    return options.energy->fraction();
  };
  EXPECT_DOUBLE_EQ(write(0, {99.5, 97.5, 102.5, 109.5}), 0.1);
  options.restart_step = 2;
  EXPECT_DOUBLE_EQ(write(3, {}), 0.03);
  EXPECT_DOUBLE_EQ(write(3, {100.5}), 0.03);
  options.restart_step = 3;
  EXPECT_DOUBLE_EQ(write(4, {103.5}), 0.04);
}

TEST_F(Output, SeriesReportsAFullDisk) {
  // /dev/full takes an open and refuses every write, as a full disk does.
  AppendFile full("/dev/full");
  try {
    full.write("row\n");
    FAIL() << "no error";
  } catch (const RunError& error) {
    expect_mentions(error.what(), {"/dev/full", "No space left on device"});
  }
  EXPECT_THROW(SeriesWriter(world, {path("nowhere"), Schedule{0, 1}, 0, std::nullopt}), RunError);
}

// ---- frames -----------------------------------------------------------------------------------------------------

TEST_F(Output, PvdListsPhysicalTimesAndSurvivesARestart) {
  if (rank_of(world) == 0) {
    FrameListFile list(path("particles.pvd"), std::nullopt);
    for (const std::int64_t step : {0, 5, 10}) {
      list.add(Clock{step, 0.1, 1}, "vtu/particles_" + step_digits(step) + ".pvtu");
    }
    FrameListFile restarted(path("particles.pvd"), 5);
    EXPECT_EQ(restarted.last_step(), 5);
    restarted.add(Clock{7, 0.1, 1}, "vtu/particles_000007.pvtu");
    const std::string text = text_of(path("particles.pvd"));
    expect_mentions(text, {"timestep=\"0\" group=\"\" part=\"0\" file=\"vtu/particles_000000.pvtu\"",
                           "timestep=\"0.5\" group=\"\" part=\"0\" file=\"vtu/particles_000005.pvtu\"",
                           "file=\"vtu/particles_000007.pvtu\"", "</Collection>"});
    EXPECT_EQ(text.find("000010"), std::string::npos);
  }
}

TEST_F(Output, ColoursRunFromRedToViolet) {
  EXPECT_EQ(rainbow(0), (Rgb{255, 0, 0}));
  EXPECT_EQ(rainbow(NAN), (Rgb{255, 0, 0}));
  EXPECT_EQ(rainbow(1), (Rgb{128, 0, 255}));
  EXPECT_EQ(rainbow(7), rainbow(1));
  const Particles all = whole_cloud(5);
  EXPECT_EQ(colours_of({Colour::rainbow_id, 0, 1, 10, 5}, all).size(), 5u);
  EXPECT_EQ(colour_of({Colour::rainbow_x, 0, 1, 10, 5}, all, 0), rainbow(0));
}

// ---- progress, report, folder -----------------------------------------------------------------------------------

/// What Progress prints over `steps` steps; empty on all ranks but 0.
std::string progress_output(ProgressOptions options, std::int64_t steps) {
  std::FILE* sink = std::tmpfile();
  options.sink = sink;
  options.last_step = steps;
  const Particles none;
  {
    Progress progress(world, options);
    for (Clock clock{0, 0.1, 1}; clock.step <= steps; ++clock.step) progress.observe(frame_of(clock, none));
    progress.finish(frame_of(Clock{steps, 0.1, 1}, none));
  }
  std::string text(static_cast<std::size_t>(std::ftell(sink)), '\0');
  std::rewind(sink);
  const std::size_t read = std::fread(text.data(), 1, text.size(), sink);
  std::fclose(sink);
  return text.substr(0, read);
}

TEST_F(Output, ProgressPrintsLittleAndOnRankZeroOnly) {
  ProgressOptions options;
  const std::string lines = progress_output(options, 1000);  // a file is no terminal: lines, 5 s apart
  options.mode = ProgressMode::none;
  EXPECT_EQ(progress_output(options, 1000), "");
  if (rank_of(world) != 0) {
    EXPECT_EQ(lines, "");
  } else {
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 1) << lines;
    expect_mentions(lines, {"100.0%", "step 1000/1000", "t 100.000 s", "ms/step", "ETA 0:00"});
  }
}

TEST_F(Output, ProgressBarStaysOnOneLineOfTheTerminal) {
  for (const int width : {3, 20, 60, 200}) {
    ProgressOptions options;
    options.mode = ProgressMode::bar;
    options.width = width;
    options.bar_interval = 0;
    const std::string text = progress_output(options, 100);
    if (rank_of(world) != 0) continue;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
    EXPECT_EQ(text.back(), '\n');
    std::istringstream drawn(text.substr(1, text.size() - 2));
    for (std::string line; std::getline(drawn, line, '\r');) {
      line = line.substr(0, line.find('\x1b'));
      EXPECT_LT(line.size(), static_cast<std::size_t>(width)) << line;
    }
  }
}

TEST_F(Output, RunReportIsOrderedJsonWithNulls) {
  RunReport report;
  report.exit_reason = "done";
  report.ranks = size_of(world);
  report.scene_hash = scene_hash("a");
  report.steps_per_second = 12.5;
  report.phases = {{"density", 0.5, 0.75, 1.0, 12, 1e9}};
  write_run_report(world, folder(), report);
  const auto json = nlohmann::ordered_json::parse(text_of(path("run.json")));
  EXPECT_EQ(json.begin().key(), "exit_reason");
  EXPECT_EQ(json["scene_hash"], "af63dc4c8601ec8c");  // published test value of FNV-1a 64
  EXPECT_EQ(json["phases"][0]["seconds"]["max"], 1.0);
  EXPECT_TRUE(json["nanoseconds_per_pair"].is_null());
  EXPECT_THROW(write_run_report(world, path("nowhere"), report), RunError);
}

TEST_F(Output, DirectoryOfAnotherRunIsRefused) {
  const std::string run = path("new/run");
  EXPECT_NO_THROW(check_output_directory(world, run, std::nullopt));
  EXPECT_FALSE(fs::exists(run));
  barrier();
  EXPECT_NO_THROW(make_output_directory(world, run));
  EXPECT_NO_THROW(check_output_directory(world, run, std::nullopt));  // made, but nothing ran
  barrier();
  on_root(world, [&] { replace_file(run + "/checkpoint_000003.h5", "of an earlier run"); });
  const std::string message = input_error_of([&] { check_output_directory(world, run, std::nullopt); });
  expect_mentions(message, {run, "checkpoint_000003.h5", "--output", "--restart"});
  EXPECT_NO_THROW(check_output_directory(world, run, run + "/checkpoint_000003.h5"));
  EXPECT_NO_THROW(check_output_directory(world, path("other"), run + "/checkpoint_000003.h5"));
  EXPECT_THROW(check_output_directory(world, run, path("checkpoint_000003.h5")), InputError);
  EXPECT_THROW(make_output_directory(world, "/dev/null/run"), RunError);
}

}  // namespace
}  // namespace trevi

// Settings that a program fills by hand: fountains, inlets, drains and output are those of the scene that says the
// same.
#include "flow_scenes.hpp"
#include "solver/check_input.hpp"

namespace trevi::test {
namespace {

class Filled : public Output {
 protected:
  void SetUp() override {
    Output::SetUp();
    if (rank_of(world) == 0) std::ofstream(path("tune.txt")) << "0 C4 0.2\n0.2 G4 0.2\n";
    barrier();
  }

  Scene scene() const {
    return parse_scene(path("scene.toml"), fountain + more, {"output.directory='" + path("scene") + "'"});
  }

  Settings filled() const;

 private:
  // Besides the inlets and the drain of the fountain.
  const std::string more = R"(
every = 0.1
[[fountain]]
center = [0.4, 0.4]
diameter = 0.3
height = 0.4
direction = [1, 0, 3]
jitter = 0.25
stop = 0.3
music = "tune.txt"
speed_range = [1, 3]
[colour]
by = "rainbow_x"
[output.vtkhdf]
every_steps = 10
fields = ["velocity", "rgb"]
[output.checkpoint]
keep = 1
[random]
seed = 12
)";
};

Settings Filled::filled() const {
  Settings settings;
  settings.domain = {Vec3(0, 0, 0), Vec3(1.6, 0.8, 1.6)};
  settings.dt = 0.0166666667;
  settings.gravity = Vec3(0, 0, -9.8);
  FountainSettings& pump = settings.fountains.emplace_back();
  pump.center[0] = pump.center[1] = 0.4;
  pump.diameter = 0.3;
  pump.height = 0.4;
  pump.direction = Vec3(1, 0, 3);
  pump.jitter = 0.25;
  pump.stop = 0.3;
  pump.music.emplace().source = path("tune.txt");
  pump.music->speed_range = {1, 3};
  InletSettings& below = settings.inlets.emplace_back();
  below.shape = InletShape::rectangle;
  below.center = Vec3(0.4, 0.4, 0.15);
  below.direction = Vec3(0.3, 0, 1);
  below.size[0] = below.size[1] = 0.3;
  below.speed = 2.5;
  below.jitter = 0.5;
  below.recycle = true;
  InletSettings& above = settings.inlets.emplace_back();
  above.center = Vec3(1.0, 0.4, 1.4);
  above.direction = Vec3(1, 0.2, -0.5);
  above.radius = 0.15;
  above.flow = 0.1;
  above.start = 0.1;
  above.stop = 0.45;
  DrainSettings& drain = settings.drains.emplace_back();
  drain.shape = DrainShape::cylinder;
  drain.center = Vec3(1.3, 0.4, 0.2);
  drain.radius = 0.25;
  drain.height = 0.4;
  settings.output.directory = path("filled");
  settings.output.series = Schedule{0.1, 1};
  settings.output.vtkhdf = FrameSettings{{0, 10}, {"velocity", "rgb"}};
  settings.output.checkpoint = CheckpointSettings{{}, 1};
  settings.colour = Colour::rainbow_x;
  settings.seed = 12;
  return settings;
}

/// Series.csv without the columns of this machine's time and balance, which are two in a row.
std::string series_of(const std::string& folder) {
  std::istringstream lines(text_of(folder + "/series.csv"));
  std::string kept;
  std::vector<std::size_t> machine;
  for (std::string line; std::getline(lines, line); kept += '\n') {
    std::istringstream cells(line);
    std::size_t column = 0;
    for (std::string cell; std::getline(cells, cell, ','); ++column) {
      if (cell == "imbalance" || cell == "wall_seconds") machine.push_back(column);
      if (std::find(machine.begin(), machine.end(), column) == machine.end()) kept += cell + ",";
    }
  }
  return kept;
}

// A block as the scene has it, on rank 0 alone.
Particles water() {
  Particles particles;
  for (GlobalId n = 0; rank_of(world) == 0 && n < 16 * 8 * 5; ++n) {
    particles.id.push_back(n);
    const Vec3 place(static_cast<Real>(n % 16), static_cast<Real>(n / 16 % 8), static_cast<Real>(n / 128));
    particles.position.push_back(0.1 * (place + Vec3(0.5, 0.5, 0.5)));
    particles.velocity.push_back(Vec3::Zero());
  }
  return particles;
}

TEST_F(Filled, ByHandTheyAreTheScene) {
  Settings one = checked_and_resolved(scene()), other = checked_and_resolved(filled());
  one.output.directory = other.output.directory;
  EXPECT_TRUE(one == other);
}

TEST_F(Filled, BitsAndFilesAreThoseOfTheScene) {
  const Scene read = scene();
  const std::unique_ptr<Solver> from_scene = make_solver(world, read, initial_particles(world, read));
  const std::unique_ptr<Solver> by_hand = make_solver(world, filled(), water());
  for (Solver* solver : {from_scene.get(), by_hand.get()}) {
    run(*solver, 0.5);
    solver->finish();
  }
  EXPECT_GT(by_hand->flow()->inflow, 0);
  EXPECT_GT(by_hand->flow()->outflow, 0);
  expect_same_bits(gathered(world, by_hand->particles()), gathered(world, from_scene->particles()));
  barrier();
  EXPECT_EQ(series_of(path("filled")), series_of(path("scene")));
  EXPECT_EQ(text_of(path("filled/particles_000030.hdf")), text_of(path("scene/particles_000030.hdf")));
  const CheckpointState state = read_checkpoint(world, path("filled/checkpoint_000030.h5"));
  EXPECT_EQ(state.info.seed, 12);
  EXPECT_EQ(state.flow->inflow, by_hand->flow()->inflow);
  EXPECT_TRUE(state.rows.has_hue);
  EXPECT_EQ(read_checkpoint(world, path("scene/checkpoint_000030.h5")).info.scene_text, read.text);
}

TEST_F(Filled, WithoutAFolderNothingIsWritten) {
  Settings settings = filled();
  settings.output.directory.clear();
  const std::unique_ptr<Solver> solver = make_solver(world, settings, water());
  run(*solver, 0.1);
  solver->finish();
  barrier();
  EXPECT_FALSE(fs::exists(path("filled")));
}

TEST_F(Filled, AFolderWithAnotherRunIsRefused) {
  make_solver(world, filled(), water());
  barrier();
  EXPECT_NE(input_error_of([&] { make_solver(world, filled(), water()); }).find("holds another run"),
            std::string::npos);
}

TEST_F(Filled, WhatCannotBeIsNamed) {
  const auto told = [&](const std::function<void(Settings&)>& spoil) {
    Settings settings = filled();
    settings.output.directory.clear();
    spoil(settings);
    return input_error_of([&] { make_solver(world, settings, water()); });
  };
  const std::vector<std::pair<std::string, std::function<void(Settings&)>>> all = {
      {"fountains[0].center", [](Settings& s) { s.fountains[0].center[1] = -1; }},
      {"fountains[0].direction", [](Settings& s) { s.fountains[0].direction.setZero(); }},
      {"fountains[0].speed", [](Settings& s) { s.fountains[0].speed = NAN; }},
      {"fountains[0].diameter", [](Settings& s) { s.fountains[0].diameter = 0; }},
      {"fountains[0].start", [](Settings& s) { s.fountains[0].start = 1; }},
      {"fountains[0].music.source", [](Settings& s) { s.fountains[0].music->source = "tune.doc"; }},
      {"fountains[0].music: ", [](Settings& s) { s.fountains[0].music->source = "nowhere.txt"; }},
      {"fountains[0].music.speed_range",
       [](Settings& s) {
         s.fountains[0].music->speed_range = {3, 1};
       }},
      {"inlets[1].center", [](Settings& s) { s.inlets[1].center.z() = 1.6; }},
      {"inlets[1].radius", [](Settings& s) { s.inlets[1].radius = 0; }},
      {"inlets[0].size", [](Settings& s) { s.inlets[0].size[1] = NAN; }},
      {"inlets[1].flow", [](Settings& s) { s.inlets[1].flow = -1; }},
      {"inlets[0].recycle", [](Settings& s) { s.drains.clear(); }},
      {"drains[0].radius", [](Settings& s) { s.drains[0].radius = -1; }},
      {"drains[1].max", [](Settings& s) { s.drains.emplace_back(); }},
      {"output.vtkhdf.fields", [](Settings& s) { s.output.vtkhdf->fields = {"speed"}; }},
      {"needs a colour", [](Settings& s) { s.colour.reset(); }},
      {"output.series", [](Settings& s) { s.output.series->every = -1; }},
      {"output.checkpoint.keep", [](Settings& s) { s.output.checkpoint->keep = 0; }},
  };
  for (const auto& [words, spoil] : all) EXPECT_NE(told(spoil).find(words), std::string::npos) << told(spoil);
}

// The same error with a scene names its file and line, whoever makes the solver.
TEST_F(Filled, MusicOfASceneIsToldWithItsLine) {
  if (rank_of(world) == 0) std::ofstream(path("tune.txt")) << "0 H4 0.2\n";
  barrier();
  Scene read = scene();
  const int line =
      static_cast<int>(std::count(
          read.text.begin(), read.text.begin() + static_cast<std::ptrdiff_t>(read.text.find("[[fountain]]")), '\n')) +
      1;
  read.output.directory.clear();
  expect_mentions(input_error_of([&] { make_solver(world, read, water()); }),
                  {fmt::format("scene.toml:{}: [[fountain]] music: ", line), "tune.txt:1"});
}

}  // namespace
}  // namespace trevi::test

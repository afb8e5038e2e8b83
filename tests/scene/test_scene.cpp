// The scene reader: defaults, preset, overrides, several problems at once, and text that is no scene.
// The rules one by one are in test_scene_rules.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sstream>

#include "base/simd.hpp"
#include "scene/scene_place.hpp"
#include "scene_text.hpp"

namespace trevi::test {
namespace {

TEST(Scene, EmptyFileMissesAllThatIsRequired) {
  EXPECT_EQ(problems(""),
            "in/s.toml:1: [domain] min: missing; give the lower corner of the box [x, y, z] in metres\n"
            "in/s.toml:1: [domain] max: missing; give the upper corner of the box [x, y, z] in metres\n"
            "in/s.toml:1: [fluid] spacing: missing; give the lattice spacing in metres\n"
            "in/s.toml:1: particles: missing; add at least one [[particles]] table, a block or a file\n"
            "in/s.toml:1: [time] dt: missing; give the time step in seconds\n"
            "in/s.toml:1: [time] end: missing; give the simulated time in seconds");
}

TEST(Scene, SeveralProblemsAreListedInTheOrderOfTheFile) {
  const std::string text =
      "[time]\ndt = 0\nend = -1\n[fluid]\nspacing = 0\n[domain]\nmin = [0,0,0]\nmax = 3\n"
      "[[particles]]\n[walls]\nbounce = 1\n";
  std::istringstream found(problems(text, {"density.iterations=0", "nonsense"}));
  const std::vector<std::string> starts = {"in/s.toml:2: [time] dt",          "in/s.toml:3: [time] end",
                                           "in/s.toml:5: [fluid] spacing",    "in/s.toml:8: [domain] max",
                                           "in/s.toml:9: [[particles]] min",  "in/s.toml:9: [[particles]] max",
                                           "in/s.toml:11: [walls] bounce",    "--set nonsense",
                                           "--set density.iterations=0: must"};
  std::string line;
  for (const std::string& start : starts) {
    std::getline(found, line);
    EXPECT_EQ(line.find(start), 0u) << line;
  }
  EXPECT_FALSE(std::getline(found, line)) << line;
}

TEST(Scene, AbsentKeysTakeTheDefaultsAndAbsentTablesAreAbsentFeatures) {
  const Scene scene = parse(scene_plus());
  EXPECT_EQ(scene.path, "in/s.toml");
  EXPECT_EQ(scene.name, "s");
  EXPECT_EQ(scene.output.directory, "");
  EXPECT_EQ(scene.directory(), "out/s");
  EXPECT_EQ(scene.steps(), 100);
  EXPECT_EQ(scene.slab_axis, 0);
  EXPECT_EQ(scene.fluid.kernel_radius, 0.2);  // twice the spacing
  EXPECT_EQ(scene.fluid.mass, FluidSettings{}.mass);
  EXPECT_NEAR(scene.density.relaxation, 0.9587 * 2 / 2.70368, 1e-5);  // Spiky, h = 2 spacings
  EXPECT_EQ(scene.density.constraint, DensitySettings{}.constraint);
  EXPECT_FALSE(scene.density.tolerance);
  EXPECT_EQ(scene.walls.reflection, WallSettings{}.reflection);
  EXPECT_FALSE(scene.gravity || scene.tensile || scene.vorticity || scene.viscosity || scene.colour ||
               scene.wall_limit);
  EXPECT_FALSE(scene.output.vtu || scene.output.vtkhdf || scene.output.checkpoint || scene.output.series);
  EXPECT_TRUE(scene.fountains.empty());
  EXPECT_EQ(scene.seed, 1u);
  ASSERT_EQ(scene.particles.size(), 1u);
  EXPECT_EQ(SceneTable("particles", 0).line_in(scene), 6);
  EXPECT_EQ(scene.particles[0].max, Vec3(1, 1, 0.5));
}

TEST(Scene, TheGradientFollowsFromTheKernelOfTheDensity) {
  const auto gradient = [](const std::string& keys) { return parse(scene_plus(), {keys}).fluid.gradient_kernel; };
  EXPECT_EQ(gradient("fluid.density_kernel='spiky'"), "spiky");
  EXPECT_EQ(gradient("fluid.density_kernel='poly6'"), "spiky");  // whose own vanishes at the centre
  EXPECT_EQ(gradient("fluid.density_kernel='wendland_c2'"), "wendland_c2");
  const Scene both = parse(scene_plus(), {"fluid.density_kernel='wendland_c2'", "fluid.gradient_kernel='poly6'"});
  EXPECT_EQ(both.fluid.density_kernel, "wendland_c2");
  EXPECT_EQ(both.fluid.gradient_kernel, "poly6");
  EXPECT_EQ(problems(scene_plus(), {"fluid.density_kernel='wendland'"}),
            "--set fluid.density_kernel='wendland': must be \"poly6\" or \"spiky\" or \"wendland_c2\", got "
            "\"wendland\"; did you mean \"wendland_c2\"?");
}

TEST(Scene, EveryKeyArrives) {
  const Scene scene = parse(scene_plus(
      "cfl = 0.4\n[gravity]\nacceleration = [0, 0, -1]\n[density]\nmethod = 'anderson'\niterations = 9\n"
      "tolerance = 0.01\nrelaxation = 2\nepsilon = 0\nconstraint = 'equality'\nprecision = 'single'\n[walls]\n"
      "restitution = 1\ndensity = 'analytic'\nreflection = 'report'\nfloor_friction = 0.02\n[tensile]\nk = 1\nn = "
      "2\ndq = 0.3\n[vorticity]\n"
      "epsilon = 1\n[viscosity]\nc = 0.0005\n[output]\ndirectory = 'd'\n[output.vtu]\nevery = 1\nevery_steps = 2\n"
      "fields = ['rgb', 'rank']\n[output.vtkhdf]\nevery_steps = 3\n[output.checkpoint]\nkeep = 5\n[output.series]\n"
      "[colour]\nby = 'blue'\n[random]\nseed = 0\n[run]\nwall_limit = '1h30m'\n"
      "[[particles]]\ntype = 'file'\npath = 'a.h5'\n[[particles]]\ntype = 'file'\npath = '/a.h5'\n"
      "[[fountain]]\ncenter = [1, 0.5]\ndirection = [0, 3, 4]\nmusic = 'm.mid'\nspeed_range = [8, 20]\nstop = 2\n"));
  EXPECT_EQ(scene.cfl, 0.4);
  EXPECT_EQ(*scene.gravity, Vec3(0, 0, -1));
  EXPECT_TRUE(scene.density.method == Method::anderson && scene.density.precision == Precision::single);
  EXPECT_TRUE(scene.density.constraint == Constraint::equality && scene.walls.density == WallDensity::analytic);
  EXPECT_EQ(scene.walls.floor_friction, 0.02);
  EXPECT_EQ(scene.density.iterations, 9);
  EXPECT_EQ(scene.density.tolerance, 0.01);
  EXPECT_EQ(scene.density.relaxation, 2);
  EXPECT_EQ(scene.density.epsilon, 0);
  EXPECT_EQ(scene.tensile->n, 2);
  EXPECT_EQ(scene.vorticity, 1);
  EXPECT_EQ(scene.viscosity, 0.0005);
  EXPECT_EQ(scene.output.directory, "d");
  EXPECT_EQ(scene.output.vtu->schedule.every_steps, 2);
  EXPECT_EQ(scene.output.vtu->fields, (std::vector<std::string>{"rgb", "rank"}));
  EXPECT_EQ(scene.output.vtkhdf->fields, FrameSettings{}.fields);
  EXPECT_EQ(scene.output.checkpoint->keep, 5);
  EXPECT_EQ(scene.output.series->every_steps, 1);
  EXPECT_EQ(scene.colour, Colour::blue);
  EXPECT_EQ(scene.wall_limit, 5400);
  EXPECT_EQ(scene.particles.at(1).path, "in/a.h5");
  EXPECT_EQ(scene.particles.at(2).path, "/a.h5");
  EXPECT_LT((scene.fountains.at(0).direction - Vec3(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(scene.fountains[0].music->source, "in/m.mid");
  EXPECT_EQ(scene.fountains[0].music->speed_range.second, 20);
}

TEST(Scene, MusicHasDefaultsByItsKind) {
  const Scene scene = parse(scene_plus(
      "[[fountain]]\ncenter = [1, 0.5]\nspeed = 8\nmusic = 'm.txt'\n[[fountain]]\ncenter = [1, 0.5]\nmusic = 'v.WAV'\n"
      "mapping = 'energy'\n[[fountain]]\ncenter = [1, 0.5]\nmusic = '-'\nfollow = 'pitch'\nrate = 8000\n"
      "[[fountain]]\ncenter = [1, 0.5]\nmusic = '/m.mid'\ntrack = 2\nchannel = 3\nspeed_range = [1, 2]\n"));
  const MusicSettings &text = *scene.fountains.at(0).music, &sound = *scene.fountains.at(1).music,
                      &live = *scene.fountains.at(2).music, &midi = *scene.fountains.at(3).music;
  EXPECT_TRUE(text.kind == MusicKind::score && sound.kind == MusicKind::sound);
  EXPECT_TRUE(live.kind == MusicKind::live && midi.kind == MusicKind::midi);
  EXPECT_EQ(text.speed_range, (std::pair<Real, Real>{4, 8}));
  EXPECT_TRUE(text.follow == Follow::pitch && text.mapping == SpeedMapping::linear);
  EXPECT_TRUE(sound.follow == Follow::loudness && sound.mapping == SpeedMapping::energy);
  EXPECT_TRUE(live.follow == Follow::pitch && live.source == "-" && live.rate == 8000);
  EXPECT_TRUE(midi.source == "/m.mid" && midi.track == 2 && midi.channel == 3);
  EXPECT_EQ(scene.fountains[3].top_speed(), 2);
  EXPECT_FALSE(parse(scene_plus("[[fountain]]\ncenter = [1, 0.5]\n")).fountains[0].music);
}

TEST(Scene, ReportPresetCreatesItsTablesAndYieldsToExplicitKeys) {
  const Scene scene = parse(scene_plus("[density]\npreset = 'report'"));
  EXPECT_TRUE(scene.density.method == Method::jacobi && scene.density.constraint == Constraint::equality);
  EXPECT_EQ(scene.density.iterations, 4);
  EXPECT_EQ(scene.density.relaxation, 1);
  EXPECT_EQ(scene.density.epsilon, 1);
  EXPECT_EQ(scene.fluid.mass, Mass::volume);
  EXPECT_TRUE(scene.walls.density == WallDensity::none && scene.walls.reflection == Reflection::report);
  EXPECT_EQ(scene.walls.restitution, 0.5);
  EXPECT_EQ(scene.cfl, 0);
  EXPECT_TRUE(scene.tensile && scene.tensile->k == 0.001 && scene.tensile->n == 4 && scene.tensile->dq == 0.2);
  EXPECT_EQ(scene.vorticity, 0.002);
  EXPECT_EQ(scene.viscosity, 0.001);
  const Scene other = parse(scene_plus("cfl = 1\n[tensile]\nk = 2\n[vorticity]\nepsilon = 0\n[walls]\nreflection = "
                                       "'normal'\n[density]\nrelaxation = 0.5\npreset = 'report'"),
                            {"fluid.mass='calibrated'"});
  EXPECT_EQ(other.cfl, 1);
  EXPECT_TRUE(other.tensile->k == 2 && other.tensile->n == 4 && other.vorticity == 0.0);
  EXPECT_TRUE(other.walls.reflection == Reflection::normal && other.fluid.mass == Mass::calibrated);
  EXPECT_EQ(other.density.relaxation, 0.5);
  EXPECT_FALSE(parse(scene_plus("[density]\npreset = 'default'")).vorticity);
}

TEST(Scene, ViscosityIsAShareOfAStepOrInUnits) {
  const Scene share = parse(scene_plus("[viscosity]")), units = parse(scene_plus("[viscosity]\nnu = 0.01"));
  EXPECT_TRUE(share.viscosity == 0.001 && !share.kinematic_viscosity);
  EXPECT_TRUE(!units.viscosity && units.kinematic_viscosity == 0.01);
  const Scene report = parse(scene_plus("[viscosity]\nnu = 0.01\n[density]\npreset = 'report'"));
  EXPECT_TRUE(!report.viscosity && report.kinematic_viscosity == 0.01) << "an explicit key wins";
  // What the messages for larger ones name is taken.
  EXPECT_EQ(problems(scene_plus("cfl = 0\n[viscosity]\nnu = 0.243")), "");
  EXPECT_EQ(problems(scene_plus("[viscosity]\nnu = 121")), "");
}

TEST(Scene, SlabAxisIsTheLongestHorizontalOne) {
  EXPECT_EQ(parse(scene_with(3, "max = [2, 2, 9]")).slab_axis, 0);
  EXPECT_EQ(parse(scene_with(3, "max = [2, 3, 9]")).slab_axis, 1);
  EXPECT_EQ(parse(scene_with(3, "max = [2, 3, 9]\nslab_axis = 'x'")).slab_axis, 0);
}

TEST(Scene, WallLimitHasUnits) {
  for (const auto& [text, seconds] : std::vector<std::pair<std::string, Real>>{{"'3h'", 10800},
                                                                               {"'90m'", 5400},
                                                                               {"'45s'", 45},
                                                                               {"'1h1s'", 3601},
                                                                               {"'0.5h'", 1800},
                                                                               {"12", 12},
                                                                               {"1.5", 1.5}})
    EXPECT_EQ(parse(scene_plus("[run]\nwall_limit = " + text)).wall_limit, seconds) << text;
}

TEST(Scene, InstructionSetIsOneOfThisMachine) {
  EXPECT_EQ(parse(scene_plus()).instruction_set, "");
  EXPECT_EQ(instruction_set_names().front(), instruction_set_name());
  for (const std::string& name : instruction_set_names()) {
    EXPECT_EQ(parse(scene_plus("[run]\ninstruction_set = '" + name + "'")).instruction_set, name);
    // As it was called up to 1.0.
    if (name.starts_with("AVX-512")) {
      EXPECT_TRUE(is_instruction_set("AVX3" + name.substr(7)));
    }
  }
}

TEST(SceneOverrides, AreAppliedInOrderAndKeptInTheText) {
  const Scene scene = parse(scene_plus("[[fountain]]\ncenter = [1, 0.5]"),
                            {"density.iterations=8", "density.iterations = 9", "density.method=chebyshev",
                             "fountain.0.speed=12", "particles.0.max=[1, 1, 1]", "run.wall_limit=3h", "time.end=2",
                             "particles.1.type=file", "particles.1.path=data/c.h5", "gravity.acceleration=[0,0,-1]",
                             "output.vtu.every_steps=2", "viscosity={c=0}", "domain.max.2=1.5"});
  EXPECT_EQ(scene.density.iterations, 9);
  EXPECT_EQ(scene.density.method, Method::chebyshev);
  EXPECT_EQ(scene.fountains.at(0).speed, 12);
  EXPECT_EQ(scene.particles.at(0).max, Vec3(1, 1, 1));
  EXPECT_EQ(scene.particles.at(1).path, "in/data/c.h5");
  EXPECT_EQ(SceneTable("particles", 1).line_in(scene), 0);
  EXPECT_EQ(scene.wall_limit, 10800);
  EXPECT_EQ(scene.steps(), 200);
  EXPECT_EQ(*scene.gravity, Vec3(0, 0, -1));
  EXPECT_EQ(scene.output.vtu->schedule.every_steps, 2);
  EXPECT_EQ(scene.viscosity, 0);
  EXPECT_EQ(scene.domain.max.z(), 1.5);
  EXPECT_NE(scene.text.find("\n# --set density.iterations=8\n# --set density.iterations = 9\n"), std::string::npos);
  EXPECT_EQ(parse(scene_plus(), {"fountain.0.center=[1,0]"}).fountains.size(), 1u);
}

TEST(SceneOverrides, AreNamedWhenTheyAreWrong) {
  const auto told = [](const std::string& assignment) { return problems(scene_plus(), {assignment}); };
  EXPECT_EQ(told("density.itertions=8"), "--set density.itertions=8: unknown key; did you mean iterations?");
  EXPECT_EQ(told("densty.iterations=8"), "--set densty.iterations=8: [densty]: unknown table; did you mean density?");
  EXPECT_EQ(told("fluid.spacing=-1"),
            "--set fluid.spacing=-1: must be positive, got -1; give the lattice spacing in metres");
  EXPECT_EQ(told("fluid={spacing=-1}").find("--set fluid={spacing=-1}: [fluid] spacing: must be positive"), 0u);
  EXPECT_EQ(told("fountain.0.speed=1").find("--set fountain.0.speed=1: [[fountain]] center: missing"), 0u);
  EXPECT_EQ(told("particles.0.max=[9,9,9]").find("--set particles.0.max=[9,9,9]: the block is outside"), 0u);
  EXPECT_EQ(told("particles.2.max=1"), "--set particles.2.max=1: no such element; the next new one is particles.1");
  EXPECT_EQ(told("particles.max=1"), "--set particles.max=1: say which [[particles]]: particles.0.key=value");
  EXPECT_EQ(told("density=5").find("--set density=5: must be a table"), 0u);
  for (const std::string bad : {"density.iterations", "", "a=1\nb=2", "# a = 1"})
    EXPECT_NE(told(bad).find("not of the form table.key=value"), std::string::npos) << bad;
  for (const std::string bad :
       {"=5", "density.iterations=", "density..n=1", "[density]=1", "density.method=a b", "a.=x"})
    EXPECT_EQ(told(bad).find("--set " + bad + ": not valid TOML"), 0u) << told(bad);
}

TEST(Scene, ReferenceListsEachKeyOnce) {
  std::istringstream reference(scene_reference());
  std::vector<std::string> lines;
  for (std::string line; std::getline(reference, line);) lines.push_back(line);
  const auto lists = [&](const std::string& key) {
    return std::count_if(lines.begin(), lines.end(),
                         [&](const std::string& line) { return line.starts_with(key + ": "); });
  };
  for (const std::string key :
       {"[domain] slab_axis", "[fluid] spacing", "[[particles]] min", "[[particles]] path", "[time] dt",
        "[density] preset", "[tensile] dq", "[viscosity] c", "[[fountain]] speed_range", "[output] directory",
        "[output.vtkhdf] fields", "[[output.frames]] one_in", "[output.checkpoint] keep", "[output.series] every_steps",
        "[colour] by", "[random] seed", "[run] wall_limit"})
    EXPECT_EQ(lists(key), 1) << key;
}

TEST(Scene, FramesHaveWhatIsWrittenAndDefaults) {
  const Scene scene = parse(scene_plus(
      "[[output.frames]]\nevery_steps = 2\nprecision = 'single'\none_in = 8\nsurface = true\nmin = [0, 0, 0]\nmax = "
      "[1, 0.5, 0.25]\nformat = 'vtu'\nname = 'near'\nfields = []\n[[output.frames]]\nwhat = 'cells'\nevery = 0.5\n"));
  ASSERT_EQ(scene.output.frames.size(), 2U);
  const FrameSetSettings &near = scene.output.frames[0], &cells = scene.output.frames[1];
  EXPECT_TRUE(near.precision == Precision::single && near.surface && near.format == FrameFormat::vtu);
  EXPECT_EQ(near.one_in, 8);
  EXPECT_EQ(near.box->max, Vec3(1, 0.5, 0.25));
  EXPECT_TRUE(near.name == "near" && near.fields->empty() && near.schedule.every_steps == 2);
  EXPECT_TRUE(cells.what == FrameContent::cells && cells.name == "1" && !cells.box);
  EXPECT_EQ(*cells.fields, (std::vector<std::string>{"fraction", "velocity"}));
  EXPECT_EQ(cells.schedule.every, 0.5);
}

TEST(Scene, BrokenTextIsAnInputErrorAndNeverACrash) {
  const std::string whole = scene_plus("[[fountain]]\ncenter = [1, 0.5]\nmusic = \"ü.mid\"\n[output.vtu]\nevery = 1\n");
  std::mt19937 random(7);
  const std::string alphabet = "[]{}=.\"'#,\n\t 0123456789-+einfatrueXx\\\x01\xff\xc3_";
  for (int round = 0; round < 3000; ++round) {
    std::string text = whole.substr(0, random() % (whole.size() + 1));
    for (unsigned change = random() % 4; change > 0 && !text.empty(); --change)
      text[random() % text.size()] = round % 2 ? static_cast<char>(random()) : alphabet[random() % alphabet.size()];
    if (round % 3 == 0)
      for (char& c : text) c = static_cast<char>(random());
    try {
      parse(text, {text.substr(0, 20), "fluid." + text.substr(text.size() / 2, 9)});
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()), "");
    }
  }
}

}  // namespace
}  // namespace trevi::test

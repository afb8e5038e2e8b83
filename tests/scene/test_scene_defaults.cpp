// An absent key and the same key with its default value written out are the same scene, for every key there is.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "kernels/kernels.hpp"
#include "scene_defaults.hpp"
#include "scene_text.hpp"

namespace trevi::test {
namespace {

/// The scene without what tells how it was written.
Scene meaning(const std::string& more, const std::vector<std::string>& overrides = {}) {
  Scene scene = parse(scene_plus(more), overrides);
  scene.text.clear();
  scene.overrides = 0;
  scene.output.directory = scene.directory();
  return scene;
}

void expect_no_change(const std::string& more, const std::vector<std::string>& defaults) {
  const Scene absent = meaning(more);
  for (std::string written : defaults) {
    // Without gravity the default splits steps finer.
    if (written == "time.cfl=2") written = fmt::format("time.cfl={}", absent.cfl);
    EXPECT_TRUE(meaning(more, {written}) == absent) << written << " changes a scene with\n" << more;
  }
  std::vector<std::string> all = defaults;
  std::replace(all.begin(), all.end(), std::string("time.cfl=2"), fmt::format("time.cfl={}", absent.cfl));
  EXPECT_TRUE(meaning(more, all) == absent) << "all of them";
}

TEST(SceneDefaults, WrittenOutChangeNothing) {
  const std::vector<std::string> defaults = defaults_of_all_scenes(meaning(""));
  expect_no_change("", defaults);
  expect_no_change(every_table, defaults);
  expect_no_change(every_table, defaults_of_features);
}

TEST(SceneDefaults, OfTheReportWrittenOutChangeNothing) {
  expect_no_change("[density]\npreset = 'report'", defaults_of_the_report);
}

TEST(SceneDefaults, OfOtherMethodsWrittenOutChangeNothing) {
  for (const char* method : {"jacobi", "anderson"}) {
    const std::string more = fmt::format("[density]\nmethod = '{}'", method);
    expect_no_change(more, {"time.cfl=0", "density.coarse_grid=false", "density.max_shift=0",
                            fmt::format("density.relaxation={}", meaning(more).density.relaxation)});
  }
}

TEST(SceneDefaults, TheRelaxationOfEachKernelCanBeWrittenOut) {
  for (const std::string& kernel : kernel_names()) {
    for (const Real ratio : {1.2, 1.3, 1.5, 2.5, 4.0}) {
      const std::vector<std::string> radius = {fmt::format("fluid.kernel_radius={}", ratio * 0.1),
                                               fmt::format("fluid.density_kernel='{}'", kernel)};
      const Scene absent = meaning("", radius);
      EXPECT_LE(absent.density.relaxation, 2) << kernel << " " << ratio;
      std::vector<std::string> with = radius;
      with.push_back(fmt::format("density.relaxation={}", absent.density.relaxation));
      EXPECT_TRUE(meaning("", with) == absent) << kernel << " " << ratio;
    }
  }
}

/// "[[fountain]] speed" of "fountain.0.speed=10".
std::string label_of(const std::string& assignment) {
  const std::string path = assignment.substr(0, assignment.find('=')), key = path.substr(path.rfind('.') + 1);
  const std::string table = path.substr(0, path.rfind('.'));
  const std::size_t index = table.find(".0");
  return index == std::string::npos ? "[" + table + "] " + key : "[[" + table.substr(0, index) + "]] " + key;
}

// A new key has a line in scene_defaults.hpp, or here.
TEST(SceneDefaults, EveryKeyIsAmongThem) {
  std::set<std::string> known = {"[domain] periodic",
                                 "[domain] ranks",
                                 "[density] tolerance",
                                 "[viscosity] nu",
                                 "[[fountain]] music",
                                 "[[fountain]] track",
                                 "[[fountain]] channel",
                                 "[[inlet]] radius",
                                 "[[inlet]] size",
                                 "[[inlet]] speed",
                                 "[[inlet]] flow",
                                 "[[inlet]] level",
                                 "[[inlet]] profile",
                                 "[[inlet]] music",
                                 "[[inlet]] track",
                                 "[[inlet]] channel",
                                 "[[drain]] min",
                                 "[[drain]] max",
                                 "[[drain]] center",
                                 "[[drain]] axis",
                                 "[[drain]] radius",
                                 "[[drain]] height",
                                 "[[drain]] level",
                                 "[[drain]] flow",
                                 "[[particles]] surface",
                                 "[[obstacle]] size",
                                 "[[obstacle]] radius",
                                 "[[obstacle]] height",
                                 "[[obstacle]] wall",
                                 "[obstacle.motion] amplitude",
                                 "[obstacle.motion] rotation",
                                 "[obstacle.motion] ramp",
                                 "[[obstacle]] scale",
                                 "[[obstacle]] translate",
                                 "[[obstacle]] motion",
                                 "[[body]] size",
                                 "[[body]] radius",
                                 "[[body]] height",
                                 "[[body]] wall",
                                 "[[body]] scale",
                                 "[[body]] translate",
                                 "[[body]] density",
                                 "[[body]] mass",
                                 "[[body]] free",
                                 "[body.mooring] point",
                                 "[body.mooring] length",
                                 "[body.mooring] damping",
                                 "[body.mooring] slack",
                                 "[[wavemaker]] wave",
                                 "[[wavemaker]] period",
                                 "[[wavemaker]] depth",
                                 "[[wavemaker]] direction",
                                 "[[wavemaker]] position",
                                 "[[wavemaker]] ramp",
                                 "[[wavemaker]] second_order",
                                 "[[wavemaker]] absorb",
                                 "[[wavemaker]] spectrum",
                                 "[[wavemaker]] peak_enhancement",
                                 "[[wavemaker]] components",
                                 "[[wavemaker]] seed",
                                 "[[damping]] direction",
                                 "[[gauge]] normal",
                                 "[[gauge]] size",
                                 "[[gauge]] to",
                                 "[[gauge]] count",
                                 "[output.gauges] every",
                                 "[output.vtu] every",
                                 "[output.vtu] every_steps",
                                 "[output.vtkhdf] every",
                                 "[output.vtkhdf] every_steps",
                                 "[[output.frames]] every",
                                 "[[output.frames]] every_steps",
                                 "[[output.frames]] min",
                                 "[[output.frames]] max",
                                 "[output.checkpoint] every",
                                 "[output.checkpoint] every_steps",
                                 "[output.series] every",
                                 "[run] wall_limit",
                                 "[run] threads",
                                 "[run] instruction_set"};
  for (const auto& defaults : {defaults_of_all_scenes(meaning("")), defaults_of_features})
    std::transform(defaults.begin(), defaults.end(), std::inserter(known, known.end()), label_of);
  std::istringstream reference(scene_reference());
  for (std::string line; std::getline(reference, line);) {
    if (line.ends_with("; required")) continue;
    EXPECT_TRUE(known.contains(line.substr(0, line.find(": ")))) << line;
  }
}

}  // namespace
}  // namespace trevi::test

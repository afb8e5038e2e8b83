// Each rule of the scene file has a scene that breaks it, which must be told once, by line and key.
#include <gtest/gtest.h>

#include "scene_text.hpp"

namespace trevi::test {
namespace {

struct BadScene {
  int changed;  ///< the line that is replaced, or `appended`
  std::string replacement;
  std::string place;  ///< "line: label"
  std::string words;  ///< part of the message
};

// GoogleTest looks for this name. NOLINTNEXTLINE(readability-identifier-naming)
void PrintTo(const BadScene& bad, std::ostream* out) { *out << bad.place << " <- " << bad.replacement; }

class BadSceneTest : public testing::TestWithParam<BadScene> {};

TEST_P(BadSceneTest, IsToldOnceByLineAndKey) {
  const BadScene& bad = GetParam();
  const std::string found = problems(scene_with(bad.changed, bad.replacement));
  EXPECT_EQ(found.find("in/s.toml:" + bad.place + ": "), 0u) << found;
  EXPECT_NE(found.find(bad.words), std::string::npos) << found;
  EXPECT_EQ(found.find('\n'), std::string::npos) << "a problem and its consequences are one: " << found;
}

INSTANTIATE_TEST_SUITE_P(
    Box, BadSceneTest,
    testing::Values(
        BadScene{2, "", "1: [domain] min", "missing; give the lower corner"},
        BadScene{3, "", "1: [domain] max", "missing"},
        BadScene{3, "max = [2, 1]", "3: [domain] max", "list of 3 finite numbers, got [2, 1]"},
        BadScene{3, "max = [2, 1, '1']", "3: [domain] max", "got [2, 1, \"1\"]"},
        BadScene{3, "max = [2, 1, inf]", "3: [domain] max", "finite"},
        BadScene{3, "max = [2, 1, nan]", "3: [domain] max", "finite"},
        BadScene{3, "max = [2, 1, 0]", "3: [domain] max", "must be greater than min"},
        BadScene{3, "max = [1e300, 1, 1]", "3: [domain] max", "million kernel radii"},
        BadScene{3, "max = [2, 1, 1]\nperiodic = ['x', 'w']", "4: [domain] periodic", "unknown axis \"w\""},
        BadScene{3, "max = [2, 1, 1]\nperiodic = ['x', 'x']", "4: [domain] periodic", "names \"x\" twice"},
        BadScene{3, "max = [2.1, 1, 1]\nperiodic = ['x']", "4: [domain] periodic", "make it 2 or 2.2 m"},
        BadScene{3, "max = [2, 1, 1]\nperiodic = 'x'", "4: [domain] periodic", "list of texts"},
        BadScene{3, "max = [2, 1, 1]\nperiodic = ['z']\n[walls]\nfloor_friction = 0.1", "4: [domain] periodic",
                 "there is no floor"},
        BadScene{3, "max = [2, 1, 1]\nslab_axis = 'z'", "4: [domain] slab_axis", "\"x\" or \"y\", got \"z\""},
        BadScene{3, "max = [2, 1, 1]\nmiddle = 1", "4: [domain] middle", "unknown key; known here: dimensions"},
        BadScene{3, "max = [2, 1, 1]\nslabaxis = 'x'", "4: [domain] slabaxis", "did you mean slab_axis?"}));

INSTANTIATE_TEST_SUITE_P(
    Fluid, BadSceneTest,
    testing::Values(
        BadScene{5, "", "4: [fluid] spacing", "missing; give the lattice spacing in metres"},
        BadScene{5, "spacing = -0.1", "5: [fluid] spacing", "must be positive, got -0.1; give the lattice spacing"},
        BadScene{5, "spacing = 'a'", "5: [fluid] spacing", "must be a number, got \"a\""},
        BadScene{5, "spacing = true", "5: [fluid] spacing", "must be a number, got true"},
        BadScene{5, "spacing = nan", "5: [fluid] spacing", "must be finite"},
        BadScene{5, "spacing = {a = 1}", "5: [fluid] spacing", "must be a number, got a table"},
        BadScene{5, "spacing = 2020-01-01", "5: [fluid] spacing", "a date"},
        BadScene{5, "spacing = 0.03\nkernel_radius = 0.2", "6: [fluid] kernel_radius", "1.2 to 4 times"},
        BadScene{5, "spacing = 0.1\nrest_density = 0", "6: [fluid] rest_density", "must be positive, got 0"},
        BadScene{5, "spacing = 0.1\nkernel_radius = 0.11", "6: [fluid] kernel_radius",
                 "1.2 to 4 times the spacing 0.1 m"},
        BadScene{5, "spacing = 0.1\nkernel_radius = 0.41", "6: [fluid] kernel_radius", "got 0.41 m"},
        BadScene{5, "spacing = 0.4\nkernel_radius = 1.1", "6: [fluid] kernel_radius",
                 "smallest extent of the box, 1 m"},
        BadScene{5, "spacing = 0.1\nmass = 'volumes'", "6: [fluid] mass", "did you mean \"volume\"?"},
        BadScene{5, "spacing = 0.1\nrest_densty = 1", "6: [fluid] rest_densty", "did you mean rest_density?"}));

INSTANTIATE_TEST_SUITE_P(
    Particles, BadSceneTest,
    testing::Values(
        BadScene{7, "", "6: [[particles]] min", "missing"},  //
        BadScene{8, "", "6: [[particles]] max", "missing"},
        BadScene{8, "max = [1, 1, 0.04]", "8: [[particles]] max", "zero particles"},
        BadScene{8, "max = [1, 1, 0]", "8: [[particles]] max", "greater than min"},
        BadScene{8, "max = [1, 1, 1.01]", "8: [[particles]] max", "outside the box"},
        BadScene{7, "min = [-0.01, 0, 0]", "7: [[particles]] min", "outside the box"},
        BadScene{8, "max = [1, 1, 1]\nvelocity = [1, inf, 0]", "9: [[particles]] velocity", "finite"},
        BadScene{8, "max = [1, 1, 1]\npath = 'x'", "9: [[particles]] path", "known here: type, min, max"},
        BadScene{8, "max = [1, 1, 1]\ntype = 'blok'", "9: [[particles]] type", "did you mean \"block\"?"},
        BadScene{appended, "[[particles]]\ntype = 'file'", "12: [[particles]] path", "missing"},
        BadScene{appended, "[[particles]]\ntype = 'file'\npath = ''", "14: [[particles]] path", "not empty"},
        BadScene{appended, "[[particles]]\ntype = 'file'\npath = 7", "14: [[particles]] path", "must be text"}));

INSTANTIATE_TEST_SUITE_P(Time, BadSceneTest,
                         testing::Values(BadScene{10, "", "9: [time] dt", "missing"},  //
                                         BadScene{11, "", "9: [time] end", "missing"},
                                         BadScene{10, "dt = 0", "10: [time] dt", "must be positive, got 0"},
                                         BadScene{10, "dt = 1e-300", "11: [time] end", "steps are too many"},
                                         BadScene{11, "end = -1", "11: [time] end", "must not be negative, got -1"},
                                         BadScene{11, "end = 0.004", "11: [time] end", "shorter than half a step"},
                                         BadScene{11, "end = 1\ncfl = -0.4", "12: [time] cfl",
                                                  "must not be negative"}));

INSTANTIATE_TEST_SUITE_P(
    Density, BadSceneTest,
    testing::Values(
        BadScene{appended, "[density]\nmethod = 'newton'", "13: [density] method", "\"jacobi\" or \"chebyshev\" or"},
        BadScene{appended, "[density]\niterations = 0", "13: [density] iterations", "must be at least 1, got 0"},
        BadScene{appended, "[density]\niterations = 4.0", "13: [density] iterations",
                 "whole number without a decimal "
                 "point, got 4.0"},
        BadScene{appended, "[density]\niterations = 10001", "13: [density] iterations", "at most 10000"},
        BadScene{appended, "[density]\niterations = 3000000000", "13: [density] iterations", "at most 2147483647"},
        BadScene{appended, "[density]\ntolerance = 0", "13: [density] tolerance", "must be positive"},
        BadScene{appended, "[density]\nrelaxation = 0", "13: [density] relaxation", "must lie in (0, 2], got 0"},
        BadScene{appended, "[density]\nrelaxation = 2.1", "13: [density] relaxation", "must lie in (0, 2], got 2.1"},
        BadScene{appended, "[density]\nepsilon = -1", "13: [density] epsilon", "must not be negative"},
        BadScene{appended, "[density]\nconstraint = 1", "13: [density] constraint", "got 1"},
        BadScene{appended, "[density]\nprecision = 'half'", "13: [density] precision", "\"double\" or \"single\""},
        BadScene{appended, "[density]\npreset = 'paper'", "13: [density] preset", "\"default\" or \"report\""},
        BadScene{appended, "[density]\nitertions = 1", "13: [density] itertions", "did you mean iterations?"},
        BadScene{appended, "[walls]\nrestitution = 1.5", "13: [walls] restitution", "must lie in [0, 1], got 1.5"},
        BadScene{appended, "[walls]\nrestitution = -0.1", "13: [walls] restitution", "must lie in [0, 1]"},
        BadScene{appended, "[walls]\nfloor_friction = -1", "13: [walls] floor_friction", "must not be negative"},
        BadScene{appended, "[walls]\ndensity = 'some'", "13: [walls] density", "\"none\" or \"analytic\""},
        BadScene{appended, "[walls]\nreflection = 'x'", "13: [walls] reflection", "\"normal\" or \"report\""}));

INSTANTIATE_TEST_SUITE_P(
    Features, BadSceneTest,
    testing::Values(
        BadScene{appended, "[tensile]\nn = 0", "13: [tensile] n", "must be at least 1"},
        BadScene{appended, "[tensile]\ndq = 0", "13: [tensile] dq", "must lie in (0, 1), got 0"},
        BadScene{appended, "[tensile]\ndq = 1", "13: [tensile] dq", "must lie in (0, 1), got 1"},
        BadScene{appended, "[tensile]\nk = -1", "13: [tensile] k", "must not be negative"},
        BadScene{appended, "[vorticity]\nepsilon = -1", "13: [vorticity] epsilon", "must not be negative"},
        BadScene{appended, "[viscosity]\nc = 0.0011", "13: [viscosity] c", "XSPH would overshoot"},
        BadScene{appended, "[viscosity]\nnu = -1", "13: [viscosity] nu", "must not be negative"},
        BadScene{appended, "[viscosity]\nc = 0.001\nnu = 0.001", "14: [viscosity] nu", "not both"},
        BadScene{11, "end = 1\ncfl = 0\n[viscosity]\nnu = 0.25", "14: [viscosity] nu",
                 "overshoot in a step of 0.01 s; lower nu to 0.243 or dt to 0.00975, or let time.cfl split"},
        BadScene{appended, "[viscosity]\nnu = 191", "13: [viscosity] nu",
                 "would split steps into more than 500 parts; lower nu to 121 or dt to 0.00638"},
        BadScene{appended, "[viscosity]\nno_slip = true", "13: [viscosity] no_slip", "give nu"},
        BadScene{appended, "[viscosity]\nc = -1", "13: [viscosity] c", "must not be negative"},
        BadScene{5, "spacing = 0.1\nrest_density = 1001\n[viscosity]", "6: [fluid] rest_density",
                 "XSPH would overshoot"},
        BadScene{appended, "[gravity]\nacceleration = -9.8", "13: [gravity] acceleration", "list of 3 finite numbers"},
        BadScene{appended, "[gravity]\ng = 1", "13: [gravity] g", "unknown key"},
        BadScene{appended, "[colour]", "12: [colour] by", "missing"},
        BadScene{appended, "[colour]\nby = 'red'", "13: [colour] by", "rainbow_x"},
        BadScene{appended, "[random]\nseed = -1", "13: [random] seed", "must be at least 0"},
        BadScene{appended, "[run]\nwall_limit = '3 hours'", "13: [run] wall_limit", "must be a time, got \"3 hours\""},
        BadScene{appended, "[run]\nwall_limit = '5m3h'", "13: [run] wall_limit", "must be a time"},
        BadScene{appended, "[run]\nwall_limit = '30'", "13: [run] wall_limit", "must be a time"},
        BadScene{appended, "[run]\nwall_limit = ''", "13: [run] wall_limit", "must be positive"},
        BadScene{appended, "[run]\nwall_limit = '-3h'", "13: [run] wall_limit", "must be positive"},
        BadScene{appended, "[run]\nwall_limit = 0", "13: [run] wall_limit", "must be positive"},
        BadScene{appended, "[run]\nwall_limit = true", "13: [run] wall_limit", "must be a time"},
        BadScene{appended, "[run]\nthreads = 0", "13: [run] threads", "must be at least 1, got 0; give the number"},
        BadScene{appended, "[run]\nthreads = 1025", "13: [run] threads", "must be at most 1024; leave it out"},
        BadScene{appended, "[run]\nthreads = 1.5", "13: [run] threads", "must be a whole number"},
        BadScene{appended, "[run]\ninstruction_set = 'AVX9'", "13: [run] instruction_set",
                 "), got \"AVX9\"; give the instruction set of all loops as run.json names it"},
        BadScene{appended, "[run]\ninstruction_set = 2", "13: [run] instruction_set", "must be text"},
        BadScene{appended, "[tensle]\nk = 1", "12: [tensle]", "unknown table; did you mean tensile?"},
        BadScene{appended, "[[gravity]]", "12: [gravity]", "must be a table"},
        BadScene{appended, "[surface]", "12: [surface]", "unknown table; known here: domain, fluid"},
        BadScene{1, "vorticity = 1\n[domain]", "1: [vorticity]", "must be a table, got 1; write [vorticity]"},
        BadScene{1, "spacing = 1\n[domain]", "1: spacing", "unknown key"}));

BadScene bad_fountain(const std::string& line, const std::string& key, const std::string& words) {
  return {appended, "[[fountain]]\ncenter = [1, 0.5]\n" + line, "14: [[fountain]] " + key, words};
}

const char* const good_inlet = "[[inlet]]\ncenter = [1, 0.5, 0.5]\nspeed = 1\n";  // without its radius, of 3 lines

INSTANTIATE_TEST_SUITE_P(
    Inlet, BadSceneTest,
    testing::Values(
        BadScene{appended, "[[inlet]]\nradius = 0.1\nspeed = 1", "12: [[inlet]] center", "missing"},
        BadScene{appended, good_inlet, "12: [[inlet]] radius", "missing"},
        BadScene{appended,
                 "[gravity]\n[[inlet]]\ntype = 'rectangle'\ncenter = [0.05, 0.5, 0.5]\nsize = [0.4, 0.4]\n"
                 "direction = [1, 0, 0]\nprofile = '1'\n[[inlet]]\ntype = 'rectangle'\ncenter = [0.1, 0.7, 0.3]\n"
                 "size = [0.4, 0.4]\ndirection = [1, 0, 0]\nprofile = '1'",
                 "21: [[inlet]] center", "overlaps that of inlet 0"},
        BadScene{appended, std::string(good_inlet) + "radius = 0", "15: [[inlet]] radius", "must be positive"},
        BadScene{appended, std::string(good_inlet) + "radius = 0.6", "13: [[inlet]] center", "out of the box"},
        BadScene{appended, std::string(good_inlet) + "size = [0.1, 0.1]", "15: [[inlet]] size", "has a radius"},
        BadScene{appended, std::string(good_inlet) + "type = 'rectangle'", "12: [[inlet]] size", "missing"},
        BadScene{appended, std::string(good_inlet) + "type = 'rectangle'\nsize = [0.1, 0]", "16: [[inlet]] size",
                 "must be positive"},
        BadScene{appended, std::string(good_inlet) + "type = 'rectangle'\nsize = [1e9, 1e9]", "13: [[inlet]] center",
                 "check the units"},
        BadScene{appended, "[[inlet]]\ncenter = [1, 0.5, 0.5]\nradius = 1e6\nflow = 1", "13: [[inlet]] center",
                 "check the units"},
        BadScene{appended, "[[inlet]]\ncenter = [1, 0.5, 0.5]\nradius = 1e300\nflow = 1", "13: [[inlet]] center",
                 "check the units"},
        BadScene{appended, std::string(good_inlet) + "radius = 0.1\nflow = 1", "16: [[inlet]] flow", "keep one"},
        BadScene{appended, "[[inlet]]\ncenter = [1, 0.5, 0.5]\nradius = 0.1", "12: [[inlet]] speed",
                 "give speed (m/s), flow"},
        BadScene{appended, "[[inlet]]\ncenter = [1, 0.5, 0.5]\nradius = 0.1\nflow = 1e6", "15: [[inlet]] flow",
                 "widen the opening"},
        BadScene{appended, std::string(good_inlet) + "radius = 0.1\nrecycle = true", "12: inlet", "add [[drain]]"},
        BadScene{appended, std::string(good_inlet) + "radius = 0.1\ndiameter = 1", "16: [[inlet]] diameter", "known"},
        BadScene{appended, std::string(good_inlet) + "radius = 0.1\nstart = 2\nstop = 1", "17: [[inlet]] stop",
                 "later than start"}));

INSTANTIATE_TEST_SUITE_P(
    Drain, BadSceneTest,
    testing::Values(BadScene{appended, "[[drain]]\nmin = [0, 0, 0]", "12: [[drain]] max", "missing"},
                    BadScene{appended, "[[drain]]\nmin = [0, 0, 0]\nmax = [0, 1, 1]", "14: [[drain]] max",
                             "greater than min"},
                    BadScene{appended, "[[drain]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nradius = 1",
                             "15: [[drain]] radius", "cylinder"},
                    BadScene{appended, "[[drain]]\ntype = 'plane'\ncenter = [0, 0, 0]", "12: [[drain]] axis", "normal"},
                    BadScene{appended, "[[drain]]\ntype = 'plane'\ncenter = [0, 0, 0]\naxis = [0, 0, 0]",
                             "15: [[drain]] axis", "must not be zero"},
                    BadScene{appended, "[[drain]]\ntype = 'cylinder'\ncenter = [0, 0, 0]\nradius = 1",
                             "12: [[drain]] height", "missing"},
                    BadScene{appended,
                             "[gravity]\n[[drain]]\nmin = [1.1, 0.1, 0]\nmax = [2, 0.5, 1]\nlevel = 0.5\n"
                             "[[drain]]\nmin = [1, 0.45, 0.5]\nmax = [2, 0.9, 1]\nflow = 0.1",
                             "20: [[drain]] flow", "overlaps that of drain 0"},
                    BadScene{appended, "[gravity]\n[[drain]]\nmin = [1.1, 0, 0]\nmax = [2, 1, 1]\nflow = 1e9",
                             "16: [[drain]] flow", "check the units"},
                    BadScene{appended, "[[drain]]\ntype = 'ball'", "13: [[drain]] type", "\"box\" or \"cylinder\""}));

// Line 12 is the first of what is appended.
const char* const good_ball = "[[obstacle]]\ntype = 'sphere'\ncenter = [1, 0.5, 0.5]\nradius = 0.1\n";

INSTANTIATE_TEST_SUITE_P(
    Gauge, BadSceneTest,
    testing::Values(
        BadScene{appended, "[[gauge]]\ncenter = [1, 0.5, 0]\n[output.series]", "12: [[gauge]] type", "missing"},
        BadScene{appended, "[[gauge]]\ntype = 'depth'\n[output.series]", "13: [[gauge]] type", "\"pressure\""},
        BadScene{appended, "[[gauge]]\ntype = 'height'\n[output.series]", "12: [[gauge]] center", "missing"},
        BadScene{appended, "[[gauge]]\ntype = 'height'\ncenter = [9, 0.5, 0]\n[output.series]", "14: [[gauge]] center",
                 "outside the box"},
        BadScene{appended, "[[gauge]]\ntype = 'height'\ncenter = [1, 0.5, 0]\nradius = 0\n[output.series]",
                 "15: [[gauge]] radius", "must be positive"},
        BadScene{appended, "[[gauge]]\ntype = 'height'\ncenter = [1, 0.5, 0]\nradius = 100\n[output.series]",
                 "15: [[gauge]] radius", "is more than the box is long"},
        BadScene{appended, "[[gauge]]\ntype = 'height'\ncenter = [1, 0.5, 0]\nnormal = [0, 0, 1]\n[output.series]",
                 "15: [[gauge]] normal", "leave it out"},
        BadScene{appended, "[[gauge]]\ntype = 'height'\ncenter = [1, 0.5, 0]", "12: gauge", "add [output.series]"},
        BadScene{appended, "[[gauge]]\ntype = 'pressure'\ncenter = [0, 0.5, 0]\nnormal = [1, 0, 0]\n[output.series]",
                 "12: gauge", "needs an [[obstacle]]"},
        BadScene{appended,
                 "[[gauge]]\ntype = 'pressure'\ncenter = [0, 0.5, 0]\n[output.series]\n[density]\n"
                 "coarse_grid = false",
                 "12: gauge", "needs the projection"},
        BadScene{appended, "[[gauge]]\ntype = 'flow'\ncenter = [1, 0.5, 0.5]\nnormal = [1, 0, 0]\n[output.series]",
                 "12: [[gauge]] size", "missing"},
        BadScene{appended, "[[gauge]]\ntype = 'flow'\ncenter = [1, 0.5, 0.5]\nsize = [1, 1]\n[output.series]",
                 "12: [[gauge]] normal", "missing"},
        BadScene{appended, "[[gauge]]\ntype = 'run_up'\ncenter = [1, 0.5, 0]\nnormal = [1, 0, 0]\n[output.series]",
                 "12: gauge", "needs an [[obstacle]] that stands"},
        BadScene{appended, "[[gauge]]\ntype = 'height'\ncenter = [1, 0.5, 0]\nto = [1.5, 0.5, 0]\n[output.series]",
                 "12: [[gauge]] count", "go together"},
        BadScene{appended,
                 std::string(good_ball) +
                     "[[gauge]]\ntype = 'pressure'\ncenter = [0, 0.5, 0]\nnormal = [0, 0, 0]\n[output.series]",
                 "19: [[gauge]] normal", "must not be zero"}));

INSTANTIATE_TEST_SUITE_P(Obstacle, BadSceneTest,
                         testing::Values(BadScene{appended, std::string(good_ball) + "rotate = [1e300, 0, 0]",
                                                  "16: [[obstacle]] rotate", "at most a million degrees"},
                                         BadScene{appended,
                                                  std::string(good_ball) +
                                                      "motion = {type = 'sine', rotation = [0, 0, 1e300], period = 1}",
                                                  "16: [obstacle.motion] period", "turn faster than 10000 rad/s"}));

// Line 12 is the first of what is appended.
INSTANTIATE_TEST_SUITE_P(
    Waves, BadSceneTest,
    testing::Values(
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'piston'\nheight = 0.1", "13: [[wavemaker]] period",
                 "missing"},
        BadScene{appended, "[[wavemaker]]\ntype = 'piston'\nheight = 0.1\nperiod = 1\nposition = 1",
                 "12: [[wavemaker]] wave", "needs gravity"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'piston'\nheight = 5\nperiod = 1\nposition = 1",
                 "15: [[wavemaker]] height", "waves break"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'piston'\nheight = 0.01\nperiod = 1\nposition = 9",
                 "17: [[wavemaker]] position", "out of the box"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'piston'\nheight = 0.01\nperiod = 1\ndepth = 1.01",
                 "17: [[wavemaker]] depth", "the box is 1 m high"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'flap'\nwave = 'solitary'\nheight = 0.1",
                 "15: [[wavemaker]] wave", "is by a piston"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'flap'\nheight = 0.1\nperiod = 1\ndirection = [1, 1, 0]",
                 "17: [[wavemaker]] direction", "along x or y"},
        BadScene{appended,
                 "[gravity]\n[[wavemaker]]\ntype = 'flap'\nheight = 0.01\nperiod = 1\nposition = 0.5\n"
                 "[[wavemaker]]\ntype = 'piston'\nheight = 0.01\nperiod = 1\nposition = 1",
                 "18: [[wavemaker]] direction", "another [[wavemaker]]"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'flap'\nheight = 0.1\nperiod = 1\nseed = 2",
                 "17: [[wavemaker]] seed", "is for wave = \"irregular\""},
        BadScene{appended, "[[damping]]\nmin = [1, 0, 0]\nmax = [0, 1, 1]\nrate = 1", "14: [[damping]] max",
                 "greater than min"},
        BadScene{appended, "[[damping]]\nmin = [7, 0, 0]\nmax = [8, 1, 1]\nrate = 1\ndirection = [1, 0, 0]",
                 "13: [[damping]] min", "out of the box"},
        BadScene{appended, "[gravity]\n[[wavemaker]]\ntype = 'piston'\nheight = 0.01\nperiod = 1e9\nposition = 1",
                 "16: [[wavemaker]] period", "at most"},
        BadScene{appended, "[[damping]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nrate = -1", "15: [[damping]] rate",
                 "must not be negative"},
        BadScene{appended, "[[damping]]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nrate = 1\ndirection = [0, 0, 1]",
                 "16: [[damping]] direction", "along x or y"}));

INSTANTIATE_TEST_SUITE_P(
    Fountain, BadSceneTest,
    testing::Values(BadScene{appended, "[[fountain]]", "12: [[fountain]] center", "missing"},
                    BadScene{appended, "[[fountain]]\ncenter = [2.1, 0]", "13: [[fountain]] center",
                             "outside the floor"},
                    BadScene{appended, "[fountain]\ncenter = [1, 0]", "12: fountain", "write [[fountain]] above each"},
                    BadScene{1, "fountain = [1]\n[domain]", "1: [[fountain]]", "must be a list of tables"},
                    bad_fountain("direction = [0, 0, 0]", "direction", "must not be zero"),
                    bad_fountain("diameter = 0", "diameter", "must be positive"),
                    bad_fountain("height = -1", "height", "must be positive"),
                    bad_fountain("speed = -1", "speed", "must lie in [0, 10000]"),
                    bad_fountain("speed = 1e308", "speed", "must lie in [0, 10000]"),
                    bad_fountain("jitter = -1", "jitter", "must lie in [0, 10000]"),
                    bad_fountain("start = -1", "start", "must not be negative"),
                    bad_fountain("stop = 1\nstart = 1", "stop", "must be later than start, 1 s"),
                    bad_fountain("speed_range = [8, 8]", "speed_range", "must increase"),
                    bad_fountain("speed_range = [8, 2e4]", "speed_range", "within 0 to 10000"),
                    bad_fountain("speed_range = [8]", "speed_range", "list of 2 finite numbers"),
                    bad_fountain("music = ''", "music", "not empty"),
                    bad_fountain("music = 'a.pdf'", "music", "unknown kind of music; give a file ending in .txt"),
                    bad_fountain("follow = 'pitch'", "follow", "there is no music"),
                    bad_fountain("follow = 'pitch'\nmusic = 'a.mid'", "follow", "sound only"),
                    bad_fountain("track = 0\nmusic = 'a.mid'", "track", "must be at least 1"),
                    bad_fountain("track = 1\nmusic = 'a.txt'", "track", "MIDI files only"),
                    bad_fountain("channel = 17\nmusic = 'a.mid'", "channel", "from 1 to 16"),
                    bad_fountain("rate = 8000\nmusic = 'a.wav'", "rate", "raw PCM"),
                    bad_fountain("rate = 999\nmusic = '-'", "rate", "must be at least 1000"),
                    bad_fountain("mapping = 'log'\nmusic = '-'", "mapping", "linear"),
                    bad_fountain("speed = 0\nmusic = '-'", "speed", "give speed_range"),
                    BadScene{appended,
                             "[[fountain]]\ncenter = [1, 0]\nmusic = '-'\n[[fountain]]\ncenter = [0, 0]\n"
                             "music = '-'\nrate = 8000",
                             "18: [[fountain]] rate", "must be the same"},
                    bad_fountain("colour = 'red'", "colour", "unknown key")));

INSTANTIATE_TEST_SUITE_P(
    Output, BadSceneTest,
    testing::Values(
        BadScene{appended, "[output]\ndirectory = ''", "13: [output] directory", "not empty"},
        BadScene{appended, "[output.vtu]\nevery = 0", "13: [output.vtu] every", "must be positive"},
        BadScene{appended, "[output.vtu]\nevery_steps = 0", "13: [output.vtu] every_steps", "must be at least 1"},
        BadScene{appended, "[output.vtu]\nfields = []", "12: [output.vtu] every", "missing; give every"},
        BadScene{appended, "[output.vtkhdf]\nevery = 1\nfields = ['velocty']", "14: [output.vtkhdf] fields",
                 "did you mean \"velocity\"?"},
        BadScene{appended, "[output.vtkhdf]\nevery = 1\nfields = ['x']", "14: [output.vtkhdf] fields", "choose from"},
        BadScene{appended, "[output.vtu]\nevery = 1\nfields = 'id'", "14: [output.vtu] fields", "list of texts"},
        BadScene{appended, "[output.vtu]\nevery = 1\nfields = ['id', 1]", "14: [output.vtu] fields", "list of texts"},
        BadScene{appended, "[output.vtu]\nevery = 1\nfields = ['id', 'id']", "14: [output.vtu] fields", "named twice"},
        BadScene{appended, "[output.vtu]\nevery = 1\nfields = ['rgb']", "14: [output.vtu] fields",
                 "needs a table [colour]"},
        BadScene{appended, "[[output.frames]]", "12: [[output.frames]] every", "missing; give every"},
        BadScene{appended, "[[output.frames]]\nevery = 1\none_in = 6", "14: [[output.frames]] one_in", "power of two"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nname = '../a'", "14: [[output.frames]] name", "letters"},
        BadScene{appended, "[[output.frames]]\nevery = 1\n[[output.frames]]\nevery = 1\nname = '0'",
                 "16: [[output.frames]] name", "frames_0 is that of another"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nmin = [0, 0, 0]", "12: [[output.frames]] max",
                 "both corners"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nmin = [0, 0, 0]\nmax = [1, 0, 1]",
                 "15: [[output.frames]] max", "greater than min"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nmin = [70, 0, 0]\nmax = [71, 1, 1]",
                 "15: [[output.frames]] max", "nothing of the domain"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nwhat = 'cells'\nsurface = true",
                 "15: [[output.frames]] surface", "leave it out"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nwhat = 'cells'\nformat = 'vtu'",
                 "15: [[output.frames]] format", "must be"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nwhat = 'cells'\nfields = ['id']",
                 "15: [[output.frames]] fields", "choose from fraction"},
        BadScene{appended, "[[output.frames]]\nevery = 1\nwhat = 'points'", "14: [[output.frames]] what", "particles"},
        BadScene{appended, "[output.checkpoint]\nkeep = 0", "13: [output.checkpoint] keep", "must be at least 1"},
        BadScene{appended, "[output.checkpoint]\nevery = -1", "13: [output.checkpoint] every", "must be positive"},
        BadScene{appended, "[output.series]\nevry = 1", "13: [output.series] evry", "did you mean every?"},
        BadScene{appended, "[output.csv]", "12: [output.csv]", "unknown table"},
        BadScene{appended, "[output]\nseries = 1", "13: [output.series]",
                 "must be a table, got 1; write [output.series]"}));

INSTANTIATE_TEST_SUITE_P(Syntax, BadSceneTest,
                         testing::Values(BadScene{5, "spacing = ", "5", "not valid TOML"},
                                         BadScene{5, "spacing = 1\nspacing = 2", "6", "not valid TOML"},
                                         BadScene{1, "[domain", "1", "not valid TOML"},
                                         BadScene{4, "[fluid]\n" + std::string(200000, 'a') + " = 1", "5",
                                                  "a line of"}));

TEST(SceneRules, TooFarFromTheOrigin) {
  const std::string found =
      problems(scene_plus(), {"domain.min=[1e9, 0, 0]", "domain.max=[1000000002, 1, 1]", "particles.0.min=[1e9, 0, 0]",
                              "particles.0.max=[1000000001, 1, 0.5]"});
  EXPECT_EQ(found.find("--set domain.max=[1000000002, 1, 1]: "), 0u) << found;
  EXPECT_NE(found.find("too coarse for a spacing of 0.1 m"), std::string::npos) << found;
}

}  // namespace
}  // namespace trevi::test

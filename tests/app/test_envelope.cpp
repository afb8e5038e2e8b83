// A run outside the stability envelope says so, with a remedy that ends the warning; inside it nothing is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/preflight/envelope.hpp"
#include "scene/scene_text.hpp"

namespace trevi::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string poly6 = "fluid.density_kernel='poly6'";

std::vector<std::string> warnings(const std::vector<std::string>& overrides) {
  return envelope_warnings(parse(scene_plus("[gravity]\nacceleration = [0, 0, -9.8]"), overrides));
}

TEST(Envelope, SaysNothingInside) {
  EXPECT_THAT(warnings({"time.dt=0.1"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.1", poly6}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0010417", "fluid.kernel_radius=0.15"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.kernel_radius=0.4", "density.iterations=1"}), IsEmpty());
  // A finer lattice falls by a spacing in less time.
  EXPECT_THAT(warnings({"time.dt=0.00052084", "fluid.spacing=0.025", "fluid.kernel_radius=0.05"}), IsEmpty());
}

TEST(Envelope, TakesRoundedNumbersForWhatTheyStandFor) {
  EXPECT_THAT(warnings({"time.dt=0.00104"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.00102"}), ElementsAre(HasSubstr("dt = 0.00102 s is shorter than the 0.001042 s")));
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.kernel_radius=0.1495"}), IsEmpty());
}

TEST(Envelope, NamesWhatIsOutside) {
  EXPECT_THAT(warnings({"time.dt=0.0005"}), ElementsAre(HasSubstr("dt = 0.0005 s is shorter than the 0.001042 s")));
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.kernel_radius=0.14"}),
              ElementsAre(HasSubstr("kernel_radius is 1.4 spacings")));
  EXPECT_THAT(warnings({"density.preset='report'"}), ElementsAre(HasSubstr("no coarse grid")));
  EXPECT_THAT(warnings({"density.method='jacobi'"}), ElementsAre(HasSubstr("no coarse grid")));
  EXPECT_THAT(warnings({"gravity.acceleration=[9.8, 0, 0]"}), ElementsAre(HasSubstr("gravity does not point down")));
  EXPECT_THAT(warnings({"gravity.acceleration=[3, 0, -9.8]"}), IsEmpty());
  EXPECT_EQ(warnings({"time.dt=0.0005", "fluid.kernel_radius=0.14"}).size(), 2U);
}

TEST(Envelope, TellsOfEnergyThatRose) {
  const Scene scene = parse(scene_plus("[gravity]\nacceleration = [0, 0, -9.8]"), {});
  const auto risen = [](Real by) {
    EnergyRise energy(1, 10, 0.2);
    for (const Real kinetic : {100.0, 100 * (1 + by)}) {
      Diagnostics row;
      row.particles = 1;
      row.kinetic_energy = kinetic;
      energy.add(row);
    }
    return energy;
  };
  EXPECT_THAT(energy_warnings(scene, risen(0.0049)), IsEmpty());
  EXPECT_THAT(energy_warnings(scene, EnergyRise(1, 10, 0.2)), IsEmpty());
  EXPECT_THAT(energy_warnings(scene, risen(0.0567)), ElementsAre(HasSubstr("rose by 5.7 % above its start")));
  EXPECT_THAT(energy_warnings(scene, risen(0.0567)), ElementsAre(HasSubstr("[viscosity] nu = 0.015 m²/s")));
  const auto without_gravity = energy_warnings(parse(scene_plus(), {"vorticity.epsilon=1"}), risen(0.01));
  EXPECT_THAT(without_gravity, ElementsAre(HasSubstr("[vorticity] adds; lower its epsilon")));
  EXPECT_THAT(without_gravity, ElementsAre(Not(HasSubstr("[viscosity]"))));
}

TEST(Envelope, TellsOfCrushedWater) {
  const Scene scene = parse(scene_plus(), {});
  EXPECT_THAT(crush_warnings(scene, {0.04, -1}), IsEmpty());
  EXPECT_THAT(crush_warnings(scene, {0.21, 7}),
              ElementsAre(AllOf(HasSubstr("from step 7 on"), HasSubstr("up to 21 %"), HasSubstr("is 5 %"))));
}

TEST(Envelope, TellsOfBodiesThatFloatTooDeep) {
  const std::string ball =
      scene_plus("[gravity]\n[[body]]\ntype = 'sphere'\ncenter = [1, 0.5, 0.5]\nradius = 0.2\ndensity = 500");
  EXPECT_THAT(envelope_warnings(parse(ball, {})), IsEmpty());
  for (const char* method : {"density.method='jacobi'", "density.preset='report'", "density.coarse_grid=false"})
    EXPECT_THAT(envelope_warnings(parse(ball, {method})), testing::Contains(HasSubstr("bodies float too deep")));
}

TEST(Envelope, NothingFallsWithoutGravity) {
  EXPECT_THAT(envelope_warnings(parse(scene_plus(), {"time.dt=0.002", "density.iterations=1"})), IsEmpty());
}

}  // namespace
}  // namespace trevi::test

// A run outside the stability envelope says so, with a remedy that ends the warning; inside it nothing is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scene_text.hpp"
#include "trevi/app/envelope.hpp"

namespace trevi::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string poly6 = "fluid.density_kernel='poly6'";

std::vector<std::string> warnings(const std::vector<std::string>& overrides) {
  return envelope_warnings(parse(scene_plus("[gravity]\nacceleration = [0, 0, -9.8]"), overrides));
}

TEST(Envelope, SaysNothingInside) {
  EXPECT_THAT(warnings({"time.dt=0.1"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0166666666667", "fluid.kernel_radius=0.15"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.kernel_radius=0.2", "density.iterations=3"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.1", "density.iterations=2", poly6}), IsEmpty());
  // A finer lattice falls by a spacing in less time.
  EXPECT_THAT(warnings({"time.dt=0.0025", "fluid.spacing=0.025", "fluid.kernel_radius=0.05"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.00833334", "fluid.spacing=0.025", "fluid.kernel_radius=0.05", poly6}), IsEmpty());
}

TEST(Envelope, TakesRoundedNumbersForWhatTheyStandFor) {
  EXPECT_THAT(warnings({"time.dt=0.00496"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0049"}), ElementsAre(HasSubstr("dt = 0.0049 s is shorter than the 0.005 s")));
  EXPECT_THAT(warnings({"time.dt=0.0166666", poly6}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0166", poly6}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.spacing=0.0999", "fluid.kernel_radius=0.2"}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0164", poly6}),
              ElementsAre(HasSubstr("dt = 0.0164 s is shorter than the 0.01667 s")));
}

TEST(Envelope, NamesWhatIsOutside) {
  EXPECT_THAT(warnings({"time.dt=0.004"}), ElementsAre(HasSubstr("dt = 0.004 s is shorter than the 0.005 s")));
  EXPECT_THAT(warnings({"time.dt=0.01", poly6}), ElementsAre(HasSubstr("dt = 0.01 s is shorter than the 0.01667 s")));
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.kernel_radius=0.25", poly6}),
              ElementsAre(HasSubstr("kernel_radius is 2.5 spacings")));
  EXPECT_THAT(warnings({"time.dt=0.1", "fluid.kernel_radius=0.14"}),
              ElementsAre(HasSubstr("kernel_radius is 1.4 spacings")));
  EXPECT_THAT(warnings({"time.dt=0.1", "density.iterations=1"}), ElementsAre(HasSubstr("density.iterations = 1")));
  EXPECT_THAT(warnings({"density.preset='report'"}), ElementsAre(HasSubstr("no coarse grid")));
  EXPECT_THAT(warnings({"density.method='jacobi'"}), ElementsAre(HasSubstr("no coarse grid")));
  EXPECT_EQ(warnings({"time.dt=0.002", "density.iterations=1"}).size(), 2U);
}

TEST(Envelope, GoesFurtherWithWhatTheWarningsAdvise) {
  const std::string spiky = "fluid.density_kernel='spiky'", viscosity = "viscosity.c=0.0002";
  EXPECT_THAT(warnings({"time.dt=0.0021", "fluid.kernel_radius=0.3", viscosity, poly6}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.005001", "fluid.kernel_radius=0.4", spiky}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0021", "fluid.kernel_radius=0.3", viscosity}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0021", "fluid.kernel_radius=0.4", viscosity, spiky}), IsEmpty());
  EXPECT_THAT(warnings({"time.dt=0.0021", spiky}), ElementsAre(HasSubstr("[viscosity] c = 0.0002")));
  EXPECT_EQ(warnings({"time.dt=0.0021", "viscosity.c=0.0001"}).size(), 1U) << "not enough";
  EXPECT_THAT(warnings({"time.dt=0.0021", "viscosity.nu=0.2"}), IsEmpty()) << "0.23 of what a step can take";
  EXPECT_EQ(warnings({"time.dt=0.0021", "viscosity.nu=0.1"}).size(), 1U) << "not enough";
  EXPECT_THAT(warnings({"time.dt=0.1", "density.iterations=2", spiky}), ElementsAre(HasSubstr("use 3 or more")));
}

TEST(Envelope, TellsOfEnergyThatRose) {
  const Scene scene = parse(scene_plus(), {"fluid.density_kernel='poly6'"});
  EXPECT_THAT(energy_warnings(scene, 0.005), IsEmpty());
  EXPECT_THAT(energy_warnings(scene, std::nan("")), IsEmpty());
  EXPECT_THAT(energy_warnings(scene, 0.0567), ElementsAre(HasSubstr("rose by 5.7 % above its start")));
  EXPECT_THAT(energy_warnings(scene, 0.0567), ElementsAre(HasSubstr("density_kernel = \"spiky\"")));
  EXPECT_THAT(energy_warnings(parse(scene_plus(), {"vorticity.epsilon=1"}), 0.01),
              ElementsAre(HasSubstr("[vorticity] adds; lower its epsilon")));
}

TEST(Envelope, NothingFallsWithoutGravity) {
  EXPECT_THAT(envelope_warnings(parse(scene_plus(), {"time.dt=0.002", "density.iterations=1"})), IsEmpty());
}

}  // namespace
}  // namespace trevi::test

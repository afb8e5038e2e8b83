// The guard alone, without a solver: what it notes and what all ranks are told.
#include "solver/guard.hpp"

#include "support/cloud.hpp"
#include "trevi/error.hpp"

namespace trevi::test {
namespace {

const Box box{Vec3::Zero(), Vec3::Ones()};

Particles some_particles() {
  Particles particles;
  for (GlobalId k = 0; k < 5; ++k) {
    particles.id.push_back(5 * rank_of(world) + k);
    particles.position.push_back(Vec3::Constant(0.1 + 0.1 * static_cast<Real>(k)));
    particles.velocity.push_back(Vec3::Zero());
  }
  particles.predicted = particles.position;
  return particles;
}

/// What agree() throws in step 7; it is the same on all ranks.
std::string told_by(Guard& guard, const Particles& particles) {
  try {
    guard.agree(particles, 7);
  } catch (const BlowUp& error) {
    EXPECT_EQ(error.reach(), Reach::all_ranks);
    return error.what();
  }
  return "nothing";
}

bool is_last() { return rank_of(world) == size_of(world) - 1; }

TEST(Guard, TellsNothingOfGoodParticles) {
  const Particles particles = some_particles();
  Guard guard(world, particles, {});
  guard.check(particles, Walls(box, WallSettings{}, 1e-6), 7);
  EXPECT_EQ(told_by(guard, particles), "nothing");
}

TEST(Guard, NamesTheParticleThatIsOutsideOnOneRank) {
  Particles particles = some_particles();
  Guard guard(world, particles, {});
  if (is_last()) particles.predicted[3].x() = 1.5;
  guard.check(particles, Walls(box, WallSettings{}, 1e-6), 7);
  const std::string id = std::to_string(5 * size_of(world) - 2), told = told_by(guard, particles);
  EXPECT_NE(told.find("step 7: particle " + id + " is at (1.5, "), std::string::npos) << told;
}

TEST(Guard, NamesTheBodyThatIsNoNumber) {
  const Particles particles = some_particles();
  Guard guard(world, particles, {});
  std::vector<BodyState> bodies(2);
  guard.check(bodies, 7);
  EXPECT_EQ(told_by(guard, particles), "nothing");
  bodies[1].angular_momentum.y() = NAN;
  guard.check(bodies, 8);
  const std::string told = told_by(guard, particles);
  EXPECT_NE(told.find("step 8: body 1 is at ("), std::string::npos) << told;
}

TEST(Guard, AParticleMayGoOnlyWhereItIsExpectedTo) {
  Particles particles = some_particles();
  Guard guard(world, particles, {});
  const StepState before = state_of(particles.id);
  if (is_last()) particles.id.pop_back();
  const std::string id = std::to_string(5 * size_of(world) - 1), told = told_by(guard, particles);
  EXPECT_NE(told.find("particle " + id + " is lost"), std::string::npos) << told;
  const StepState now = state_of(particles.id);
  std::array<std::uint64_t, 3> change{now.particles - before.particles, now.ids - before.ids,
                                      now.squares - before.squares};
  MPI_Allreduce(MPI_IN_PLACE, change.data(), 3, MPI_UINT64_T, MPI_SUM, world);
  guard.expect({change[0], change[1], change[2]});
  EXPECT_EQ(told_by(guard, particles), "nothing");
}

TEST(Guard, MeansCompressionOverAllRanks) {
  const Particles particles = some_particles();
  Guard guard(world, particles, {});
  const std::vector<Real> density(5, is_last() ? 1250 : 900);
  guard.note_compression(density, 1000);
  guard.agree(particles, 7);
  EXPECT_NEAR(guard.compression(), 0.25 / size_of(world), 1e-5);
  EXPECT_NO_THROW(guard.end_if_crushed(7));
  guard.note_compression(std::vector<Real>(5, 1600), 1000);
  guard.agree(particles, 8);
  EXPECT_THROW(guard.end_if_crushed(8), BlowUp);
}

TEST(Guard, CarriesAnExceptionOfOneRankToAll) {
  const Particles particles = some_particles();
  Guard guard(world, particles, {});
  guard.attempt(7, "an observer", [] {
    if (is_last()) throw std::runtime_error("no paper");
  });
  const std::string told = told_by(guard, particles);
  EXPECT_NE(told.find("an observer failed: no paper"), std::string::npos) << told;
}

}  // namespace
}  // namespace trevi::test

// Cases that can be worked out by hand: lambda and delta of one and of two particles, forcings, a lone particle's fall
// and bounce through the whole solver.
#include <cmath>

#include "fluid/constraint/density.hpp"
#include "fluid/forcings/floor_friction.hpp"
#include "fluid/forcings/fountain.hpp"
#include "fluid/forcings/gravity.hpp"
#include "support/distributed.hpp"
#include "trevi/forcing.hpp"

namespace trevi::test {
namespace {

// ---- lambda, h = 0.2 m, m = 1 kg, rho0 = 1000 kg/m³, epsilon = 1 ---------------------------------------------------

template <class T>
class ByHand : public testing::Test {
 protected:
  static constexpr Real digits = std::is_same_v<T, float> ? 1e-6 : 1e-12;

  /// Particles along x from the middle of a plane, sorted by id; lambda and delta of each of this rank's.
  struct Solved {
    std::vector<GlobalId> id;
    std::vector<Real> rho, lambda;
    std::vector<Vec3> delta;
  };
  static Solved solve(const std::vector<Real>& x, const DensityModel& model, const std::optional<Tensile>& tensile) {
    Cloud cloud;
    for (std::size_t k = 0; k < x.size(); ++k)
      cloud.add(static_cast<GlobalId>(k), Vec3(0.4 + x[k], 0.7, 0.5), Vec3::Zero());
    Distributed<T> d(cloud);
    const DensityConstraint<T> constraint(model, tensile, {});
    const Range all{0, d.near.order().owned()};
    const Pairs<T> pairs{d.near.records(), d.near.list(), d.near.order().low_ghosts()};
    Solved solved{d.particles.id, std::vector<Real>(d.particles.id.size()), {}, {}};
    WallsOrShifts<T> field;
    field.borrow(d.near.scratch(), d.particles.id.size());
    constraint.lambdas(pairs, all, d.particles.predicted, {solved.rho, field, [&](Range here, const T* multipliers) {
                                                             for (LocalId i = here.begin; i < here.end; ++i)
                                                               d.near.record(i).w = multipliers[i - here.begin];
                                                           }});
    d.near.halo().exchange(d.near.records());
    constraint.deltas(pairs, all, d.particles.predicted, field);
    for (LocalId i = 0; i < all.end; ++i) solved.lambda.push_back(d.near.record(i).w);
    for (const Vec4<T>& q : field.shifts()) solved.delta.push_back(vector_of(q));
    return solved;
  }
};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ByHand, Precisions);

DensityModel model_of(Constraint constraint, const std::string& density_kernel = "poly6") {
  return {1, 1000, 0.2, 1, constraint, kernels_of({.density_kernel = density_kernel})};
}

// rho = W(0), 315/(64 π h³) of Poly6 and 15/(π h³) of Spiky; no gradients, so lambda = −C/epsilon.
TYPED_TEST(ByHand, OneParticle) {
  struct Expected {
    Constraint constraint;
    const char* kernel;
    Real rho, lambda;
  };
  for (const auto& [constraint, kernel, rho, lambda] :
       {Expected{Constraint::equality, "poly6", 195.8351839, 0.8041648161},
        Expected{Constraint::inequality, "poly6", 195.8351839, 0},
        Expected{Constraint::equality, "spiky", 596.8310366, 0.4031689634},
        Expected{Constraint::inequality, "spiky", 596.8310366, 0}}) {
    const auto one = this->solve({0}, model_of(constraint, kernel), Tensile{0.001, 4, 0.2});
    for (std::size_t k = 0; k < one.id.size(); ++k) {
      EXPECT_NEAR(one.rho[k], rho, 1e-7);
      EXPECT_NEAR(one.lambda[k], lambda, 1e-7);
      EXPECT_EQ(one.delta[k], Vec3::Zero());
    }
  }
}

// At r = h/2: W6 = W6(0) (3/4)³ and W_spiky = W_spiky(0) (1/2)³; each gradient is a = (m/rho0) 45/(π h⁴) (1/2)², once
// as ∇_i and once as ∇_j.
TYPED_TEST(ByHand, TwoParticles) {
  const Real a = 45 / (std::numbers::pi * 0.0016) / 4 / 1000, s_corr = -0.001 * std::pow(0.75 / 0.96, 12);
  for (const std::string kernel : {"poly6", "spiky"}) {
    const Real w0 = (kernel == "poly6" ? 315.0 / 64 : 15) / (std::numbers::pi * 0.008);
    const Real rho = w0 * (1 + (kernel == "poly6" ? 27.0 / 64 : 1.0 / 8));
    const Real lambda = -(rho / 1000 - 1) / (2 * a * a + 1);
    const DensityModel model = model_of(Constraint::equality, kernel);
    const auto plain = this->solve({0, 0.1}, model, std::nullopt);
    const auto tensile = this->solve({0, 0.1}, model, Tensile{0.001, 4, 0.2});
    for (std::size_t k = 0; k < plain.id.size(); ++k) {
      const Vec3 towards(plain.id[k] == 0 ? 1 : -1, 0, 0);  // a deficit of density attracts
      EXPECT_NEAR(plain.rho[k], rho, 1000 * this->digits);
      EXPECT_NEAR(plain.lambda[k], lambda, this->digits);
      EXPECT_LT((plain.delta[k] - a * 2 * lambda * towards).norm(), this->digits);
      EXPECT_LT((tensile.delta[k] - a * (2 * lambda + s_corr) * towards).norm(), this->digits);
    }
  }
}

// Seven in a row: too dense, so that the inequality constraint pushes, and the middle one has no direction to go.
TYPED_TEST(ByHand, CrowdPushesApart) {
  for (const std::string kernel : {"poly6", "spiky"}) {
    const DensityModel model = model_of(Constraint::inequality, kernel);
    const auto crowd = this->solve({-0.03, -0.02, -0.01, 0, 0.01, 0.02, 0.03}, model, std::nullopt);
    for (std::size_t k = 0; k < crowd.id.size(); ++k) {
      EXPECT_GT(crowd.rho[k], 1000);
      EXPECT_LT(crowd.lambda[k], 0);
      const auto side = static_cast<Real>(crowd.id[k]) - 3;
      EXPECT_TRUE(side == 0 ? crowd.delta[k].norm() < 10 * this->digits : crowd.delta[k].x() * side > 0);
    }
  }
}

// ---- forcings ---------------------------------------------------------------------------------------------------

Particles five_particles() {
  Particles particles;
  const Vec3 places[] = {{1, 1, 0.05}, {1.14, 1, 0.05}, {1.16, 1, 0.05}, {1, 1, 0.39}, {1, 1, 0.41}};
  for (const Vec3& p : places) {
    particles.id.push_back(particles.size());
    particles.position.push_back(p);
    particles.velocity.emplace_back(0.1, 0.2, 0.3);
  }
  particles.predicted = particles.position;
  return particles;
}

FountainSettings slanted_fountain() {
  FountainSettings settings;
  settings.center[0] = settings.center[1] = 1;
  settings.diameter = 0.3;
  settings.height = 0.4;
  settings.direction = Vec3(0.6, 0, 0.8);
  settings.speed = 8;
  settings.start = 0.5;
  settings.stop = 0.75;
  return settings;
}

/// 8 m/s and one more for each second.
class RisingPump : public Pump {
 public:
  std::optional<FountainState> at(Real time) const override { return FountainState{60, 8 + time}; }
  std::optional<Real> fastest(const TimeSpan& times) const override { return 8 + times.end; }
};

TEST(Forcing, GravityAddsTheSameToAll) {
  Particles particles = five_particles();
  Gravity(Vec3(1, 0, -9.75)).apply(particles, {0, 0, 0, 0.5});
  for (const Vec3& v : particles.velocity) EXPECT_EQ(v, Vec3(0.6, 0.2, 0.3 - 4.875));
}

// c_f/2 u² per area and density whatever the spacing, as layers of a lattice at s/2, 3s/2, ... share it; over a step it
// is the exact solution u0/(1 + r u0 dt) of du/dt = −r u².
TEST(Forcing, FloorFrictionIsTheShearStressOfItsCoefficient) {
  constexpr Real c = 0.02, floor = -1, u0 = 5, dt = 1e-6;
  for (const auto& [spacing, h] : {std::pair{0.1, 0.2}, {0.05, 0.1}, {0.05, 0.15}}) {
    Particles particles;
    particles.resize(4);
    for (std::size_t k = 0; k < 4; ++k) {
      particles.position[k] = Vec3(0, 0, floor + (static_cast<Real>(k) + 0.5) * spacing);
      particles.velocity[k] = Vec3(0.6 * u0, -0.8 * u0, 7);
    }
    FloorFriction(c, floor, h).apply(particles, {0, 0, 0, dt});
    Real lost = 0;
    for (const Vec3& v : particles.velocity) {
      lost += spacing * (u0 - std::hypot(v.x(), v.y())) / dt;
      EXPECT_NEAR(v.y() / v.x(), -0.8 / 0.6, 1e-14);
      EXPECT_EQ(v.z(), 7);
    }
    EXPECT_NEAR(lost, c / 2 * u0 * u0, 1e-4);
    EXPECT_EQ(particles.velocity[3], Vec3(0.6 * u0, -0.8 * u0, 7)) << "not within h of the floor";
  }
  Particles slow;
  slow.resize(1);
  slow.position[0] = Vec3(0, 0, floor);
  slow.velocity[0] = Vec3(u0, 0, 0);
  FloorFriction(c, floor, 0.2).apply(slow, {0, 0, 0, 100});
  EXPECT_NEAR(slow.velocity[0].x(), u0 / (1 + c / 0.2 * u0 * 100), 1e-15);
}

// Upright whatever its direction: 0.15 m around the axis and 0.4 m high; velocity in place of what was there.
TEST(Forcing, FountainPumpsInsideItsUprightCylinder) {
  Fountain fountain(slanted_fountain(), std::make_unique<RisingPump>(), 0, 1, 0);
  Particles particles = five_particles();
  fountain.apply(particles, {30, 0, 0.5, 0.1});
  for (const std::size_t k : {0U, 1U, 3U})
    EXPECT_LT((particles.velocity[k] - 8.5 * Vec3(0.6, 0, 0.8)).norm(), 1e-14) << k;
  for (const std::size_t k : {2U, 4U}) EXPECT_EQ(particles.velocity[k], Vec3(0.1, 0.2, 0.3)) << k;
}

TEST(Forcing, FountainRunsFromStartUntilStop) {
  Fountain fountain(slanted_fountain(), std::make_unique<RisingPump>(), 0, 1, 0);
  for (const auto& [time, runs] : {std::pair{0.49, false}, {0.5, true}, {0.74, true}, {0.75, false}}) {
    Particles particles = five_particles();
    fountain.apply(particles, {0, 0, time, 0.1});
    EXPECT_EQ(particles.velocity[0].z() > 1, runs) << "at " << time << " s";
    EXPECT_EQ(fountain.state(time)->speed, runs ? 8 + time : 0);
    EXPECT_EQ(std::isnan(fountain.state(time)->note), !runs) << "no note sounds";
  }
}

// A step that begins before the pump does must be short enough for it, too; and one that ends as it begins need not.
TEST(Forcing, FastestSpeedIsThatOfAnyMomentOfTheStep) {
  FountainSettings settings = slanted_fountain();  // from 0.5 to 0.75 s
  settings.jitter = 3;
  const Fountain fountain(settings, std::make_unique<ConstantPump>(8), 0, 1, 0);
  for (const auto& [begin, end, speed] :
       {std::tuple{0.3, 0.5, 0.0}, {0.3, 0.51, 11.0}, {0.6, 0.7, 11.0}, {0.74, 2.0, 11.0}, {0.75, 2.0, 0.0}})
    EXPECT_EQ(fountain.fastest({begin, end}), speed) << begin << " s to " << end << " s";
}

TEST(Forcing, JitterIsTheUniformNumberOfIdAndStep) {
  FountainSettings settings = slanted_fountain();
  settings.jitter = 3;
  Fountain fountain(settings, std::make_unique<RisingPump>(), 0, 77, 2);
  Particles particles = five_particles();
  const StepInfo info{31, 1, 0.5, 0.1};
  fountain.apply(particles, info);
  for (const std::size_t k : {0U, 1U, 3U})
    EXPECT_NEAR(particles.velocity[k].norm(), 8.5 + 3 * uniform(77, static_cast<GlobalId>(k), info, 2), 1e-13);
}

// ---- a lone particle through the solver ---------------------------------------------------------------------------

Cloud alone(const Vec3& p, const Vec3& v) {
  Cloud cloud;
  cloud.add(4, p, v);
  return cloud;
}

const std::vector<std::string> all_features = {"tensile.k=0.001", "vorticity.epsilon=0.002", "viscosity.c=0.001"};

TEST(LoneParticle, FallsExactly) {
  const Scene scene = scene_with(cloud_scene, all_features);
  Vec3 p(-0.2, 0.5, 0.95), v(1, 0.5, 0);
  const std::unique_ptr<Solver> solver = solver_of(world, scene, alone(p, v));
  for (int k = 0; k < 15; ++k) {
    solver->step();
    v += scene.dt * *scene.gravity;
    p += scene.dt * v;
    const Cloud found = gathered(world, solver->particles());
    EXPECT_LT((found.position[0] - p).norm(), 1e-15 * (k + 2));
    EXPECT_LT((found.velocity[0] - v).norm(), 1e-12);
  }
}

// The velocity after a bounce is that of the path: (p* − p)/dt.
TEST(LoneParticle, BouncesExactly) {
  const Scene scene = scene_with(cloud_scene, {"time.dt=0.25", "gravity.acceleration=[0,0,0]"});
  const std::unique_ptr<Solver> solver = solver_of(world, scene, alone(Vec3(0.5, 0.5, 0.35), Vec3(0, 0, -2)));
  solver->step();
  const Cloud found = gathered(world, solver->particles());
  EXPECT_LT((found.position[0] - Vec3(0.5, 0.5, 0.225)).norm(), 1e-15);
  EXPECT_LT((found.velocity[0] - Vec3(0, 0, -0.5)).norm(), 1e-14);
}

}  // namespace
}  // namespace trevi::test

// Waves: what theory says, where paddles are and what zones take.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "boundary/waves/elementary.hpp"
#include "boundary/waves/paddle_motion.hpp"
#include "fluid/forcings/damping.hpp"

namespace trevi::test {
namespace {

constexpr Real two_pi = 2 * std::numbers::pi;

WavemakerSettings regular_waves(PaddleKind kind = PaddleKind::piston) {
  WavemakerSettings maker;
  maker.kind = kind;
  maker.height = 0.1;
  maker.period = 1.4;
  maker.depth = 0.7;
  maker.position = 1;
  maker.ramp = 2;
  return maker;
}

TEST(Waves, FunctionsAreThoseOfTheLibrary) {
  for (Real x = -50; x < 50; x += 0.37) {
    EXPECT_NEAR(elementary::exp(x) / std::exp(x), 1, 1e-14) << x;
    EXPECT_NEAR(elementary::tanh(x), std::tanh(x), 1e-14) << x;
  }
  for (Real x = 1e-9; x < 1e9; x *= 1.7) EXPECT_NEAR(elementary::log(x), std::log(x), 1e-13) << x;
  EXPECT_EQ(elementary::exp(0), 1);
  EXPECT_EQ(elementary::log(1), 0);
}

TEST(Waves, WaveNumbersSatisfyTheDispersionRelation) {
  for (const Real depth : {0.01, 0.3, 1.0, 40.0}) {
    for (const Real omega : {0.1, 1.0, 4.0, 20.0}) {
      const Real k = wave_number(omega, depth, 9.8);
      EXPECT_NEAR(9.8 * k * std::tanh(k * depth) / (omega * omega), 1, 1e-12) << depth << ' ' << omega;
    }
  }
}

// In shallow water H/S = kd and kd/2, in deep water 2 for both; in between the values of Dean & Dalrymple's figure.
TEST(Waves, PaddlesHaveBieselsTransfer) {
  EXPECT_NEAR(biesel_transfer(PaddleKind::piston, 0.01) / 0.01, 1, 1e-4);
  EXPECT_NEAR(biesel_transfer(PaddleKind::flap, 0.01) / 0.005, 1, 1e-3);
  EXPECT_NEAR(biesel_transfer(PaddleKind::piston, 300), 2, 1e-12);
  EXPECT_NEAR(biesel_transfer(PaddleKind::flap, 300), 2, 0.01);
  const Real kd = 1.3;
  EXPECT_NEAR(biesel_transfer(PaddleKind::piston, kd), 2 * (std::cosh(2 * kd) - 1) / (std::sinh(2 * kd) + 2 * kd),
              1e-13);
  EXPECT_NEAR(biesel_transfer(PaddleKind::flap, kd),
              4 * std::sinh(kd) / kd * (kd * std::sinh(kd) - std::cosh(kd) + 1) / (std::sinh(2 * kd) + 2 * kd), 1e-13);
}

// What the face sweeps, the depth or half of it times its displacement, goes away as a wave, c0/k, or stays beside it.
TEST(Waves, LevelBesideAPaddleIsWhatDoesNotGoAway) {
  constexpr Real wide = 1000;
  for (const PaddleKind kind : {PaddleKind::piston, PaddleKind::flap}) {
    for (const Real kd : {0.2, 0.8, 1.6, 3.0}) {
      const Real swept = kind == PaddleKind::piston ? 1 : 0.5;
      EXPECT_NEAR(wide * evanescent_transfer(kind, kd, wide), swept - biesel_transfer(kind, kd) / kd, 5e-4) << kd;
    }
  }
}

TEST(Waves, IrregularWavesHaveTheEnergyOfTheirHeight) {
  WavemakerSettings maker = regular_waves();
  maker.wave = WaveKind::irregular;
  for (const WaveSpectrum spectrum : {WaveSpectrum::jonswap, WaveSpectrum::pierson_moskowitz}) {
    maker.spectrum = spectrum;
    Real energy = 0, most = 0, peak = 0;
    for (const PaddleComponent& part : paddle_components(maker)) {
      const Real k = wave_number(two_pi * part.frequency, maker.depth, maker.gravity);
      const Real a = part.amplitude * biesel_transfer(maker.kind, k * maker.depth);
      energy += a * a / 2;
      if (a > most) most = a, peak = part.frequency;
    }
    EXPECT_NEAR(4 * std::sqrt(energy), maker.height, 1e-12);
    EXPECT_NEAR(peak * maker.period, 1, 0.02);
  }
  const PaddleMotion one(maker);
  ++maker.seed;
  const PaddleMotion other(maker);
  EXPECT_NE(one.displacement(5), other.displacement(5));
}

TEST(Waves, APistonIsShiftedAndAFlapTurnsAboutItsHinge) {
  const Box tank{Vec3(0, 0, -0.2), Vec3(6, 0.6, 1.5)};
  for (const PaddleKind kind : {PaddleKind::piston, PaddleKind::flap}) {
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0)}) {
      WavemakerSettings maker = regular_waves(kind);
      maker.direction = direction;
      maker.position = direction.x() < 0 ? 5 : 0.3;
      maker.floor = tank.min.z();
      const BodyMotion motion(paddle_of(maker, tank));
      const PaddleMotion paddle(maker);
      const Pose rest = motion.at(0), then = motion.at(3.3);
      const Vec3 foot = maker.position * direction.cwiseAbs() + Vec3(0, 0, maker.floor);
      const Vec3 level = foot + maker.depth * Vec3::UnitZ();
      const auto moved = [&](const Vec3& p) { return Vec3(then.into_world(rest.into_body(p)) - p); };
      const Real x = paddle.displacement(3.3);
      EXPECT_GT(std::abs(x), 0.01);
      EXPECT_LT((moved(foot) - (kind == PaddleKind::piston ? x : 0) * direction).norm(), 1e-12);
      // A flap's face goes through the place at which it is asked to be.
      const Vec3 face = kind == PaddleKind::piston ? Vec3(x * direction) : moved(level);
      EXPECT_NEAR(face.dot(direction), x * maker.depth / std::hypot(maker.depth, kind == PaddleKind::flap ? x : 0),
                  1e-12);
      EXPECT_TRUE(paddle.displacement(0) == 0);
    }
  }
}

// dxi/dt = c eta/(d + eta), up to the 0.1 % by which the stroke is scaled, with Grimshaw's level as he writes it.
TEST(Waves, ASolitaryPaddleGoesWithItsWave) {
  WavemakerSettings maker = regular_waves();
  maker.wave = WaveKind::solitary;
  const SolitaryWave known(0.3, 1, 9.8);
  EXPECT_NEAR(known.kappa, 0.86242 * std::sqrt(0.225), 1e-5);
  EXPECT_NEAR(known.celerity * known.celerity, 9.8 * 1.294343, 1e-5);
  EXPECT_NEAR(known.stroke(), 2 * 0.27858 / known.kappa, 1e-5);
  for (const Real steepness : {0.2, 0.5, 0.75}) {
    maker.height = steepness * maker.depth;
    const PaddleMotion paddle(maker);
    const SolitaryWave wave(maker.height, maker.depth, maker.gravity);
    const Real end = wave.duration(), stroke = wave.stroke(), e = steepness;
    EXPECT_NEAR(paddle.displacement(0), -stroke / 2, 1e-12);
    EXPECT_NEAR(paddle.displacement(end), stroke / 2, 1e-12);
    for (Real t = 0.1 * end; t < 0.95 * end; t += 0.1 * end) {
      const Real x = paddle.displacement(t),
                 speed = (paddle.displacement(t + 1e-5) - paddle.displacement(t - 1e-5)) / 2e-5;
      const Real behind = wave.kappa * (wave.celerity * (t - end / 2) - x), sech = 1 / std::cosh(behind);
      const Real s2 = sech * sech, t2 = std::tanh(behind) * std::tanh(behind);
      const Real level = e * s2 - 3 * e * e * s2 * t2 / 4 + e * e * e * (5 * s2 * t2 / 8 - 101 * s2 * s2 * t2 / 80);
      EXPECT_NEAR(wave.level(std::tanh(behind)), level, 1e-14) << t;
      EXPECT_NEAR(speed, wave.celerity * level / (1 + level), 0.002 * wave.celerity * steepness) << t;
    }
  }
}

TEST(Waves, AZoneDampsExactlyHoweverTimeIsCut) {
  DampingSettings zone{Vec3(1, 0, 0), Vec3(3, 1, 1), 4, Vec3(Vec3::UnitX())};
  const auto damped = [&](int parts) {
    Particles water;
    water.resize(3);
    water.position = {Vec3(0.9, 0.5, 0.5), Vec3(2, 0.5, 0.5), Vec3(3, 0.5, 0.5)};
    water.velocity.assign(3, Vec3(1, -2, 3));
    Damping damping(zone);
    for (int n = 0; n < parts; ++n) damping.apply(water, {0, n, 0, 0.3 / parts});
    return water.velocity;
  };
  for (const int parts : {1, 7}) {
    const std::vector<Vec3> v = damped(parts);
    EXPECT_EQ(v[0], Vec3(1, -2, 3));
    EXPECT_NEAR((v[1] - std::exp(-0.3) * Vec3(1, -2, 3)).norm(), 0, 1e-14);  // a quarter of the rate in the middle
    EXPECT_NEAR((v[2] - std::exp(-1.2) * Vec3(1, -2, 3)).norm(), 0, 1e-14);
  }
}

TEST(Waves, AZoneEndsAtTheWallItIsAt) {
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(6, 0.6, 1)};
  settings.dampings = {{Vec3(4, 0, 0), Vec3(6, 0.6, 1), 1, {}},
                       {Vec3(0, 0, 0), Vec3(1, 0.6, 1), 1, {}},
                       {Vec3(0, 0, 0), Vec3(6, 0.6, 1), 1, {}}};
  const Settings all = resolved(settings);
  EXPECT_EQ(all.dampings[0].direction.value(), Vec3(1, 0, 0));
  EXPECT_EQ(all.dampings[1].direction.value(), Vec3(-1, 0, 0));
  EXPECT_FALSE(all.dampings[2].direction.given());
}

}  // namespace
}  // namespace trevi::test

#include "solver/active_absorption.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "boundary/geometry/pose.hpp"
#include "boundary/waves/elementary.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr Real return_periods = 8;  // in which an offset falls to 1/e
constexpr Real mean_periods = 3;    // over which the slow mean of the level is taken

bool absorbs(const ObstacleSettings& obstacle) { return obstacle.wavemaker && obstacle.wavemaker->absorb; }

}  // namespace

bool ActiveAbsorption::is_wanted(const Settings& settings) {
  return std::any_of(settings.obstacles.begin(), settings.obstacles.end(), absorbs);
}

ActiveAbsorption::ActiveAbsorption(const Settings& settings, std::vector<Real> state)
    : state_(std::move(state)), spacing_(settings.fluid.spacing), strip_(4 * settings.fluid.spacing) {
  for (std::size_t n = 0; n < settings.obstacles.size(); ++n) {
    if (!absorbs(settings.obstacles[n])) continue;
    const WavemakerSettings& maker = *settings.obstacles[n].wavemaker;
    const Eigen::Index axis = maker.direction.x() != 0 ? 0 : 1;
    const Real omega = 2 * std::numbers::pi / maker.period, low = settings.domain.min[axis];
    const Real k = wave_number(omega, maker.depth, maker.gravity), reach = paddle_reach(maker);
    constexpr Real quarter = std::numbers::pi / 2;  // no wave shorter than two strips is resolved
    const Real way = std::min(k * strip_ / 2, quarter), lag = way / omega;
    const Real seen = sine_cosine_of_turns(way / (2 * std::numbers::pi)).sine / way;
    const Real room = std::min(maker.position - low, settings.domain.max[axis] - maker.position) - reach;
    const Real smoothed = 1 / std::sqrt(1 + way * way);  // what smoothing leaves of a wave
    const Real transfer = biesel_transfer(maker.kind, k * maker.depth);
    paddles_.push_back({n, maker, PaddleMotion(maker), omega / (transfer * seen * smoothed), lag, seen, k * transfer,
                        evanescent_transfer(maker.kind, k * maker.depth, strip_ / maker.depth),
                        (settings.domain.max - settings.domain.min)[1 - axis], std::max(0.0, room)});
  }
  state_.resize(3 * paddles_.size(), 0);
}

void ActiveAbsorption::place(Obstacles& obstacles) const {
  for (std::size_t n = 0; n < paddles_.size(); ++n)
    obstacles.set_paddle_offset(paddles_[n].obstacle, state_[n], state_[n]);
}

// The mean level over the strip, in m above the still water. The strip follows the face at each height. Particles count
// as cubes that lie in front of the face, as for wave gauges: if parts of the cubes near it were cut off, they would be
// missing at all depths, and the paddle would follow this deficit.
Real ActiveAbsorption::level_before(MPI_Comm comm, const Paddle& paddle, Real way, const Particles& particles) {
  constexpr Real unit = 0x1p-30;  // of a particle
  constexpr LocalId part_size = 8192;
  const Eigen::Index axis = paddle.maker.direction.x() != 0 ? 0 : 1;
  const Real sign = paddle.maker.direction[axis];
  const bool is_flap = paddle.maker.kind == PaddleKind::flap;
  sums_.for_each([](auto& sums) { sums.assign(1, 0); });
  for_each_part({0, static_cast<LocalId>(particles.size())}, part_size, [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) {
      const Vec3& p = particles.position[static_cast<std::size_t>(i)];
      const Real lean = is_flap ? (p.z() - paddle.maker.floor) / paddle.maker.depth : 1;
      const Real ahead = std::max(sign * (p[axis] - paddle.maker.position) - lean * way, spacing_ / 2) / spacing_;
      const Real low = ahead - 0.5, high = std::min(ahead + 0.5, strip_ / spacing_);
      if (high > low) sums_.mine()[0] += std::llround((high - low) / unit);
    }
  });
  const Real cubes = static_cast<Real>(sum_over_threads_and_ranks(comm, sums_).front()) * unit;
  return cubes * spacing_ * spacing_ * spacing_ / (strip_ * paddle.wide) - paddle.maker.depth;
}

void ActiveAbsorption::move(MPI_Comm comm, const Particles& particles, const StepInfo& info, Obstacles& obstacles) {
  for (std::size_t n = 0; n < paddles_.size(); ++n) {
    const Paddle& paddle = paddles_[n];
    const Real own = paddle.motion.displacement(info.time), before = state_[n];
    Real& smooth = state_[paddles_.size() + 2 * n];
    Real& mean = state_[paddles_.size() + 2 * n + 1];
    // The fraction that remains after a substep, for a given time constant.
    const auto kept = [&](Real seconds) { return elementary::exp(-info.dt / seconds); };
    const Real level = level_before(comm, paddle, own + before, particles);
    const Real waves = paddle.seen * paddle.motion.level(std::max(0.0, info.time - paddle.lag));
    const Real back = level - waves - paddle.slope * own * own - paddle.beside * (own + before);
    smooth = back + (smooth - back) * kept(paddle.lag);
    mean = smooth + (mean - smooth) * kept(mean_periods * paddle.maker.period);
    const Real offset = (before - info.dt * paddle.gain * (smooth - mean)) * kept(return_periods * paddle.maker.period);
    state_[n] = std::clamp(offset, -paddle.farthest, paddle.farthest);
    obstacles.set_paddle_offset(paddle.obstacle, before, state_[n]);
  }
}

}  // namespace trevi

#include "boundary/waves/paddle_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "boundary/waves/elementary.hpp"

namespace trevi {

namespace {

Real smooth_step(Real u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

}  // namespace

PaddleMotion::PaddleMotion(const WavemakerSettings& wavemaker) : wavemaker_(wavemaker) {
  if (wavemaker.wave == WaveKind::solitary) return;
  components_ = paddle_components(wavemaker);
  for (const PaddleComponent& part : components_) {
    const Real k = wave_number(2 * std::numbers::pi * part.frequency, wavemaker.depth, wavemaker.gravity);
    levels_.push_back(part.amplitude * biesel_transfer(wavemaker.kind, k * wavemaker.depth));
  }
}

Real PaddleMotion::level(Real time) const {
  Real sum = 0;
  for (std::size_t n = 0; n < components_.size(); ++n)
    sum += levels_[n] * sine_cosine_of_turns(components_[n].frequency * time + components_[n].phase).cosine;
  return wavemaker_.ramp > 0 ? smooth_step(time / wavemaker_.ramp) * sum : sum;
}

Real PaddleMotion::displacement(Real time) const {
  if (wavemaker_.wave == WaveKind::solitary) return solitary(time);
  Real sum = 0;
  for (const PaddleComponent& part : components_)
    sum += part.amplitude * sine_cosine_of_turns(part.frequency * time + part.phase).sine;
  return wavemaker_.ramp > 0 ? smooth_step(time / wavemaker_.ramp) * sum : sum;
}

// Goring's equation, dxi/dt = c eta/(d + eta): the paddle moves with the water of the wave that passes it, so that xi
// is way(tanh kappa (c t − xi)). It starts where tanh is −0.999, and the rest of the stroke is scaled up so that there
// is no jump. The middle of the stroke is its rest position. Newton's method converges from the last two digits on by
// itself.
Real PaddleMotion::solitary(Real time) const {
  const SolitaryWave wave(wavemaker_.height, wavemaker_.depth, wavemaker_.gravity);
  const Real duration = wave.duration(), half = wave.stroke() / 2;
  if (time <= 0) return -half;
  if (time >= duration) return half;
  const auto place_after = [&](Real seconds) {  // from the middle of the stroke on
    Real x = 0;
    constexpr int enough = 40;
    for (int n = 0; n < enough; ++n) {
      const Real t = elementary::tanh(wave.kappa * (wave.celerity * seconds - x));
      x -= (x - wave.way(t)) / (1 + wave.level(t));
    }
    return x;
  };
  return place_after(time - duration / 2) * half / place_after(duration / 2);
}

Pose PaddleMotion::pose(const Pose& rest, Real displacement) const {
  if (wavemaker_.kind == PaddleKind::piston) return {rest.center + displacement * wavemaker_.direction, rest.turn};
  const Real length = std::sqrt(displacement * displacement + wavemaker_.depth * wavemaker_.depth);
  const Real sine = displacement / length, cosine = wavemaker_.depth / length;
  const Vec3& along = wavemaker_.direction;
  const Vec3 across(-along.y(), along.x(), 0);  // z goes to `along` by a rotation about it
  Rotation turn;
  turn.col(0) = across;
  turn.col(1) = cosine * along - sine * Vec3::UnitZ();
  turn.col(2) = sine * along + cosine * Vec3::UnitZ();
  Rotation straight;
  straight.col(0) = across;
  straight.col(1) = along;
  straight.col(2) = Vec3::UnitZ();
  const Rotation by = turn * straight.transpose();
  const Vec3 hinge = hinge_of(wavemaker_);
  return {hinge + by * (rest.center - hinge), by * rest.turn};
}

Vec3 hinge_of(const WavemakerSettings& flap) {
  Vec3 hinge = flap.position * flap.direction.cwiseAbs();
  hinge.z() = flap.floor;
  return hinge;
}

Real paddle_reach(const WavemakerSettings& wavemaker) {
  if (wavemaker.wave == WaveKind::solitary)
    return SolitaryWave(wavemaker.height, wavemaker.depth, wavemaker.gravity).stroke() / 2;
  Real sum = 0, squares = 0;
  for (const PaddleComponent& part : paddle_components(wavemaker)) {
    sum += std::abs(part.amplitude);
    squares += part.amplitude * part.amplitude / 2;
  }
  constexpr Real rare = 4;  // standard deviations
  return wavemaker.wave == WaveKind::irregular ? std::min(sum, rare * std::sqrt(squares)) : sum;
}

ObstacleSettings paddle_of(const WavemakerSettings& wavemaker, const Box& domain) {
  const Vec3 extent = domain.max - domain.min;
  const Eigen::Index axis = wavemaker.direction.x() != 0 ? 0 : 1;
  const bool up = wavemaker.direction[axis] > 0;
  // A flap that leans by 45 degrees still reaches the lid of the box, and has nothing behind it.
  Box box{domain.min - extent, domain.max + extent};
  const Real behind = (up ? domain.min[axis] : domain.max[axis]) - (up ? 1 : -1) * (extent[axis] + extent.z());
  box.min[axis] = std::min(behind, wavemaker.position);
  box.max[axis] = std::max(behind, wavemaker.position);
  ObstacleSettings paddle;
  paddle.shape = ShapeKind::box;
  paddle.center = (box.min + box.max) / 2;
  paddle.size = box.max - box.min;
  paddle.wavemaker = wavemaker;
  paddle.restitution = 0;
  return paddle;
}

}  // namespace trevi

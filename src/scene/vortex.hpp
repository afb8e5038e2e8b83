// The initial state of a Taylor-Green vortex. Not collective.
#pragma once

#include <cmath>

#include "trevi/scene.hpp"

namespace trevi {

/// sin(2 pi turns), to 1e-14: by additions and multiplications alone, because the last bit of the C library's sine
/// depends on its version.
inline Real sine_of_turns(Real turns) {
  Real t = turns - std::round(turns);                    // in [-1/2, 1/2]
  if (std::abs(t) > 0.25) t = (t > 0 ? 0.5 : -0.5) - t;  // sin(pi - x) = sin(x)
  constexpr Real two_pi = 6.283185307179586;
  const Real x = two_pi * t, x2 = x * x;
  Real sum = 0;
  for (int n = 23; n > 1; n -= 2) sum = (sum - 1) * x2 / (n * (n - 1));  // alternating, from the last term
  return x + x * sum;
}

/// v = vortex (sin X cos Y, -(L_y/L_x) cos X sin Y, 0) with X = 2 pi (x - min)/L_x over the extent of the block:
/// divergence-free, and one complete vortex pattern, so that it is periodic. `across` is the coordinate that represents
/// y: 1, or 2 in two dimensions.
inline Vec3 vortex_at(const ParticleSource& block, const Vec3& p, Eigen::Index across) {
  const Vec3 extent = block.max - block.min, turns = (p - block.min).cwiseQuotient(extent);
  const auto sine = [](Real t) { return sine_of_turns(t); };
  const auto cosine = [](Real t) { return sine_of_turns(t + 0.25); };
  const Real u = sine(turns.x()) * cosine(turns[across]), v = cosine(turns.x()) * sine(turns[across]);
  Vec3 velocity(u, 0, 0);
  velocity[across] = -extent[across] / extent.x() * v;
  return block.vortex * velocity;
}

}  // namespace trevi

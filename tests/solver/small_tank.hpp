// The settings and the water of the tests that use the library without a scene.
#pragma once

#include "support/cloud.hpp"

namespace trevi::test {

inline Settings tank(Precision precision = Precision::double_) {
  Settings settings;
  settings.domain = {Vec3::Zero(), Vec3(1.6, 0.8, 1.2)};
  settings.gravity = Vec3(0, 0, -9.8);
  settings.density.precision = precision;
  return settings;
}

/// 8 x 8 x 6 particles at the low end of the tank; every rank brings some, wherever they belong.
inline Particles block(MPI_Comm comm) {
  Particles particles;
  for (int n = rank_of(comm); n < 384; n += size_of(comm)) {
    particles.id.push_back(n);
    particles.position.push_back(0.1 * Vec3(n % 8 + 0.5, n / 8 % 8 + 0.5, n / 64 + 0.5));
    particles.velocity.push_back(Vec3::Zero());
  }
  return particles;
}

}  // namespace trevi::test

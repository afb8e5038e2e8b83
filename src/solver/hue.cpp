#include "solver/hue.hpp"

#include <algorithm>

#include "parallel/reductions.hpp"

namespace trevi {

void add_hue(MPI_Comm comm, Particles& particles) {
  Real low = 1e300, high = -1e300;
  for (const Vec3& p : particles.position) {
    low = std::min(low, p.x());
    high = std::max(high, p.x());
  }
  low = min_over_ranks(comm, low);
  high = max_over_ranks(comm, high);
  particles.has_hue = true;
  particles.hue.reserve(particles.position.size());
  for (const Vec3& p : particles.position) {
    particles.hue.push_back(high > low ? static_cast<float>((p.x() - low) / (high - low)) : 0.0F);
  }
}

}  // namespace trevi

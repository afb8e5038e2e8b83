#include "scene/block_start.hpp"

#include <algorithm>

#include "scene/vortex.hpp"

namespace trevi {

BlockStart::BlockStart(const ParticleSource& block, const FreePlaces& places) : block_(block), places_(places) {
  for (const std::string& text : block.velocity_formulas) velocity_.emplace_back(text, "xyz");
  if (!block.surface.empty()) surface_.emplace(block.surface, "xy");
}

bool BlockStart::holds_water(const Vec3& place) const {
  return (!surface_ || place.z() <= (*surface_)(place)) && places_.is_free(place);
}

GlobalId BlockStart::count(const Lattice& lattice, int axis, GlobalId layer) const {
  GlobalId count = 0;
  for_each_point(lattice, axis, layer,
                 [&](GlobalId i, GlobalId j, GlobalId k) { count += holds_water(lattice.point(i, j, k)) ? 1 : 0; });
  return count;
}

Vec3 BlockStart::velocity(const Vec3& place) const {
  Vec3 velocity = block_.velocity;
  for (std::size_t k = 0; k < velocity_.size(); ++k) velocity[static_cast<Eigen::Index>(k)] = velocity_[k](place);
  return block_.vortex == 0 ? velocity : Vec3(velocity + vortex_at(block_, place, block_.vortex_axis));
}

Real BlockStart::fastest() const {
  if (velocity_.empty()) return block_.velocity.norm() + std::abs(block_.vortex);
  constexpr int last = 8;
  Real fastest = 0;
  for (int n = 0; n < (last + 1) * (last + 1) * (last + 1); ++n) {
    const Vec3 part = Vec3(n % (last + 1), n / (last + 1) % (last + 1), n / ((last + 1) * (last + 1))) / last;
    fastest = std::max(fastest, velocity(block_.min + part.cwiseProduct(block_.max - block_.min)).norm());
  }
  return fastest;
}

}  // namespace trevi

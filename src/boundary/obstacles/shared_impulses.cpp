// The impulses that obstacles and box have given to the water, from the ledger, with the remainder shared among them.
#include <Eigen/Geometry>
#include <algorithm>

#include "boundary/obstacles/obstacles.hpp"

namespace trevi {

void Obstacles::begin_step() {
  ledger_.clear();
  gauges_->clear();
  finished_.clear();
}

std::vector<TotalImpulse> Obstacles::total(MPI_Comm comm) {
  if (!floating_) return recorded(comm);
  finished_.resize(bodies_.size() + 1);
  return finished_;
}

struct Obstacles::Whereabouts {
  Vec3 middle;
  Real reach;
};

Obstacles::Whereabouts Obstacles::whereabouts(std::size_t account) const {
  const Real half = (walls_.box().max - walls_.box().min).norm() / 2;
  if (account == box_account()) return {middle_of_box_, half};
  return {Vec3::Zero(), std::min(half, bodies_[account]->radius())};
}

// The vector from the point of reference of moments to the line along which an impulse acts, where this is nearest to
// the centre of the solid. The line of a couple is far from all water; then it is the vector to the centre.
Vec3 Obstacles::arm_of(std::size_t account, const Vec3& shift, const Vec3& moment) const {
  const auto [middle, reach] = whereabouts(account);
  const Vec3 arm = shift.cross(moment - middle.cross(shift)) / shift.squaredNorm();
  return arm.norm() <= reach ? Vec3(middle + arm) : middle;
}

// The basis for sharing the remainder: what each account gave by itself.
struct Obstacles::Sharing {
  TotalImpulse rest;
  std::vector<TotalImpulse> own;
  // A share would turn light bodies: they get one only along axes along which nothing else takes anything.
  std::array<bool, 3> by_fixed{};
};

bool Obstacles::has_share(const Sharing& sharing, std::size_t account, Eigen::Index axis) const {
  return !sharing.by_fixed[static_cast<std::size_t>(axis)] || !floating_->holds(account);
}

// The remainder belongs to all of the water, wherever that is, so a share acts where the impulse acts on which it is
// based. Errors are fractions of what each account gave, and the most likely errors that make the sum correct are in
// proportion to its squares. This is done for each axis separately, because walls that carry the weight of the water
// take nothing along the floor, but for all axes together where no account gave anything along an axis. The box gets
// the remainder if no account gave anything. Returns the moment that the shares leave over.
Vec3 Obstacles::share_rest(const Sharing& sharing, std::vector<TotalImpulse>& all) const {
  Eigen::Array3d along = Eigen::Array3d::Zero(), in_all = Eigen::Array3d::Zero();  // squares of those that share
  for (std::size_t k = 0; k < all.size(); ++k) {
    for (Eigen::Index a = 0; a < 3; ++a) {
      if (!has_share(sharing, k, a)) continue;
      along[a] += sharing.own[k].shift[a] * sharing.own[k].shift[a];
      in_all[a] += sharing.own[k].shift.squaredNorm();
    }
  }
  const auto part_of = [&](std::size_t k, Eigen::Index a) -> Real {
    const Vec3& own = sharing.own[k].shift;
    if (!has_share(sharing, k, a)) return 0;
    if (along[a] > 0) return own[a] * own[a] / along[a];
    return in_all[a] > 0 ? own.squaredNorm() / in_all[a] : k == box_account() ? 1 : 0;
  };
  Vec3 couple = sharing.rest.moment;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Vec3& own = sharing.own[k].shift;
    Vec3 share = Vec3::Zero();
    for (Eigen::Index a = 0; a < 3; ++a) share[a] = sharing.rest.shift[a] * part_of(k, a);
    if (share.isZero(0)) continue;
    const Vec3 arm = own.isZero(0) ? whereabouts(k).middle : arm_of(k, own, all[k].moment);
    const Vec3 moment = arm.cross(share);
    all[k].shift += share;
    all[k].moment += moment;
    couple -= moment + reference_of(k).cross(share);
  }
  return couple;
}

// For each axis separately, in proportion to the squares of the moment that each account gave, and of a fraction of
// what its force might give: a basin at rest gives large forces and no moment, and its errors are not those of its
// contents. The couple belongs to no account if only floating bodies gave anything.
void Obstacles::share_couple(const Sharing& sharing, const Vec3& couple, std::vector<TotalImpulse>& all) const {
  constexpr Real part_of_force = 0.1;
  const auto own_of = [&](std::size_t k, Eigen::Index axis) -> Real {
    if (floating_ && floating_->holds(k)) return 0;
    const Vec3& force = sharing.own[k].shift;
    const auto [middle, reach] = whereabouts(k);
    const Real given = part_of_force * reach;
    const Real moment = (sharing.own[k].moment - middle.cross(force))[axis];
    return moment * moment + given * given * (force.squaredNorm() - force[axis] * force[axis]);
  };
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!turns_[axis]) continue;
    Real sum = 0;
    for (std::size_t k = 0; k < all.size(); ++k) sum += own_of(k, axis);
    if (sum == 0) continue;
    for (std::size_t k = 0; k < all.size(); ++k) all[k].moment[axis] += own_of(k, axis) / sum * couple[axis];
  }
}

// The axes along which fixed solids take the remainder: not where floating bodies gave ten times as much, and more than
// all fixed solids gave along any axis, as under a jet in the air that drips on the floor.
std::array<bool, 3> Obstacles::are_by_fixed(const std::vector<TotalImpulse>& all) const {
  constexpr Real hardly = 0.1;
  std::array<bool, 3> result{};
  if (!floating_) return result;
  Eigen::Array3d fixed = Eigen::Array3d::Zero(), floating = Eigen::Array3d::Zero();
  for (std::size_t k = 0; k < all.size(); ++k)
    (floating_->holds(k) ? floating : fixed) += all[k].shift.array().square();
  for (Eigen::Index a = 0; a < 3; ++a) {
    const bool by_bodies = fixed[a] < hardly * hardly * floating[a] && fixed.sum() < floating[a];
    result[static_cast<std::size_t>(a)] = fixed.sum() > 0 && !by_bodies;
  }
  return result;
}

std::vector<TotalImpulse> Obstacles::recorded(MPI_Comm comm) {
  std::vector<TotalImpulse> all = ledger_.total(comm);
  all[box_account()].moment += middle_of_box_.cross(all[box_account()].shift);
  Sharing sharing{all.back(), {}};
  all.pop_back();
  sharing.own = all;
  sharing.by_fixed = are_by_fixed(all);
  const Vec3 couple = share_rest(sharing, all);
  share_couple(sharing, couple, all);
  return all;
}

}  // namespace trevi

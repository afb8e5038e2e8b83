#include "boundary/obstacles/obstacles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/kernels.hpp"

namespace trevi {

namespace {

// The box at whose walls solids end. In two dimensions there are none along y, and to clamp a place to them would round
// its other coordinates.
Box box_of_solids(const Settings& settings, const Box& open) {
  Box box = settings.domain;
  if (settings.fluid.dimensions == 2) {
    box.min.y() = open.min.y();
    box.max.y() = open.max.y();
  }
  return box;
}

}  // namespace

Obstacles::Obstacles(const Settings& settings, const Walls& walls, std::optional<AnalyticWallDensity> law)
    : middle_of_box_((settings.domain.min + settings.domain.max) / 2),
      walls_(walls),
      law_(std::move(law)),
      ledger_(settings.obstacles.size() + settings.bodies.size() + 2, settings.fluid.kernel_radius),
      relaxation_(settings.density.method == Method::jacobi ? settings.density.relaxation.value() : 1),
      water_mass_(settings.fluid.rest_density * settings.fluid.spacing * settings.fluid.spacing *
                  settings.fluid.spacing) {
  const BodyRules rules{box_of_solids(settings, walls_.box()), walls_.box(), settings.walls,
                        kernels_of(settings.fluid).density, settings.fluid.kernel_radius};
  for (const ObstacleSettings& obstacle : settings.obstacles)
    bodies_.push_back(std::make_unique<Body>(obstacle, rules));
  for (const BodySettings& body : settings.bodies) {
    const auto alike =
        std::find_if(settings.bodies.data(), &body, [&](const BodySettings& one) { return has_same_shape(one, body); });
    const std::size_t k = settings.obstacles.size() + static_cast<std::size_t>(alike - settings.bodies.data());
    bodies_.push_back(std::make_unique<Body>(body, rules, true, alike != &body ? bodies_[k].get() : nullptr));
  }
  index_.emplace(settings.domain, settings.fluid.kernel_radius, bodies_);
  if (!settings.bodies.empty())
    floating_ = std::make_unique<RigidBodies>(settings, bodies_, [this] { index_->update(); });
  gauges_.emplace(settings, [&](const Vec3& p) {
    return std::any_of(bodies_.begin(), bodies_.end(),
                       [&](const auto& body) { return body->shape().distance(body->now().into_body(p)) < 0; });
  });
}

void Obstacles::move(Real begin, Real end) {
  const std::size_t driven = floating_ ? floating_->first() : bodies_.size();
  for (std::size_t k = 0; k < driven; ++k)
    if (bodies_[k]->moves()) bodies_[k]->move(begin, end);
  if (floating_) floating_->begin(end - begin);
  if (!floating_) index_->update();
}

bool Obstacles::moves() const {
  return std::any_of(bodies_.begin(), bodies_.end(), [](const auto& body) { return body->moves(); });
}

Real Obstacles::fastest(Real begin, Real end) const {
  Real most = 0;
  const std::size_t driven = floating_ ? floating_->first() : bodies_.size();
  for (std::size_t k = 0; k < driven; ++k)
    most = std::max(most, bodies_[k]->motion().fastest(begin, end, bodies_[k]->radius()));
  return floating_ ? std::max(most, floating_->fastest(end - begin)) : most;
}

// Where they are is told by some of them, of about each cell one. Of many bodies only those are asked that come near to
// that; few are all asked, and what they leave open reaches further than a path.
OpenSpace Obstacles::open_space(std::span<const Vec3> p, Extent extent) const {
  constexpr std::size_t each = 8, few_bodies = 4;
  constexpr Real far = 4;
  const Box water = box_around(p, each);
  const bool are_few = bodies_.size() <= few_bodies;
  const Vec3 path = Vec3::Constant((are_few ? far : 1) * index_->longest_path());
  OpenSpace space(walls_.box());
  space.confine({water.min - path, water.max + path});
  const ObstacleIndex::Bits bits = are_few ? index_->all() : index_->in(water);
  const bool is_closed = index_->any(bits, [&](std::size_t k) {
    const Box* const body = bodies_[k]->bounds(extent);
    if (body != nullptr) space.close(*body);
    return body == nullptr;
  });
  return is_closed ? OpenSpace() : space;
}

namespace {

// The density that one obstacle contributes, and its gradient, in the world.
struct Contribution : BoundaryDensity {
  bool is_near = false;
};
Contribution contribution_of(const Body& body, const AnalyticWallDensity& law, const Vec3& p) {
  if (!body.may_reach(p)) return {};
  const Vec3 there = body.now().into_body(p);
  if (body.is_out_of_reach(there)) return {};
  const EquivalentPlane plane = body.map().at(there);
  const auto [value, slope] = law.of_plane(plane.distance);
  return {{value, slope * (body.now().turn * plane.gradient)}, plane.is_near};
}

}  // namespace

std::optional<BoundaryDensity> Obstacles::near_density(const Vec3& p) const {
  if (!law_) return std::nullopt;
  BoundaryDensity all;
  bool is_near = false;
  index_->for_each(index_->at(p), [&](std::size_t k) {
    const Contribution one = contribution_of(*bodies_[k], *law_, p);
    if (!one.is_near) return;  // it has none
    all.density += one.density;
    all.gradient += one.gradient;
    is_near = true;
  });
  return is_near ? std::optional(all) : std::nullopt;
}

BoundaryDensity Obstacles::together(const BoundaryDensity& box, const BoundaryDensity& all) {
  return {box.density + all.density - box.density * all.density,
          (1 - all.density) * box.gradient + (1 - box.density) * all.gradient};
}

Real Obstacles::growth(const BoundaryDensity& box, const Vec3& p, const Vec3& path) const {
  Real solid = 0, sum = 0;
  index_->for_each(index_->at(p), [&](std::size_t k) {
    const Body& body = *bodies_[k];
    const BoundaryDensity one = contribution_of(body, *law_, p);
    if (one.density == 0) return;
    solid += one.density;
    const Vec3 there = body.now().into_body(p);
    sum += (1 - box.density) * one.gradient.dot(path - (p - body.before().into_world(there)));
  });
  return sum + (1 - solid) * box.gradient.dot(path);
}

void Obstacles::record_gradient(const BoundaryDensity& box, const Vec3& p, Real factor) {
  Real solid = 0;
  factor *= relaxation_;
  index_->for_each(index_->at(p), [&](std::size_t k) {
    const BoundaryDensity one = contribution_of(*bodies_[k], *law_, p);
    solid += one.density;
    if (one.density != 0) record(k, factor * (1 - box.density) * one.gradient, p);
  });
  if (box.density != 0) record(box_account(), factor * (1 - solid) * box.gradient, p);
}

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

// From the point of moments to the line on which an impulse acts, where it is nearest to the middle of the solid; that
// of a couple is far from all water, and then it is the middle.
Vec3 Obstacles::arm_of(std::size_t account, const Vec3& shift, const Vec3& moment) const {
  const bool is_box = account == box_account();
  const Box& box = walls_.box();
  const Vec3 middle = is_box ? Vec3((box.min + box.max) / 2) : Vec3(Vec3::Zero());
  const Real half = (box.max - box.min).norm() / 2, reach = is_box ? half : std::min(half, bodies_[account]->radius());
  const Vec3 arm = shift.cross(moment - middle.cross(shift)) / shift.squaredNorm();
  return arm.norm() <= reach ? Vec3(middle + arm) : middle;
}

std::vector<TotalImpulse> Obstacles::recorded(MPI_Comm comm) {
  std::vector<TotalImpulse> all = ledger_.total(comm);
  all[box_account()].moment += middle_of_box_.cross(all[box_account()].shift);
  const TotalImpulse rest = all.back();
  all.pop_back();
  // It is of all the water, wherever that is, so that a share acts where what it goes by does. Errors are parts of what
  // each gave, and those that make the sum right and are the most likely ones go by its squares. A share would turn
  // bodies that are light: they have of it only what nobody else takes.
  Real sum = 0, of_fixed = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    sum += all[k].shift.squaredNorm();
    if (!floating_ || !floating_->holds(k)) of_fixed += all[k].shift.squaredNorm();
  }
  const bool by_fixed = floating_ && of_fixed > 0;
  if (by_fixed) sum = of_fixed;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (by_fixed && floating_->holds(k)) continue;
    const Real part = sum > 0 ? all[k].shift.squaredNorm() / sum : k == box_account() ? 1 : 0;
    const Vec3 own = all[k].shift, share = part * rest.shift;
    all[k].shift += share;
    if (own != Vec3::Zero()) all[k].moment += arm_of(k, own, all[k].moment).cross(share);
  }
  return all;
}

bool Obstacles::is_near_floating(const Vec3& from, const Vec3& to) const {
  const std::size_t first = floating_->first();
  return index_->any(along(from, to),
                     [&](std::size_t k) { return k >= first && !bodies_[k]->is_out_of_way(from, to); });
}

// Twice, as what they meet depends a little on how fast they are.
void Obstacles::settle(MPI_Comm comm, std::span<const Vec3> p, std::span<const Vec3> v, Real dt) {
  if (!floating_) return;
  const bool recorded = std::exchange(recording_, false);
  sounding_ = true;
  for (int round = 0; round < 2; ++round) {
    for_each_part({0, static_cast<LocalId>(p.size())}, at_once, [&](Range part) {
      const auto begin = static_cast<std::size_t>(part.begin), end = static_cast<std::size_t>(part.end);
      const OpenSpace open = open_space(p.subspan(begin, end - begin), Extent::path);
      std::array<Vec3, at_once> straight;
      std::array<LocalId, at_once> left;
      const Straight way{p.subspan(begin, end - begin), v.subspan(begin, end - begin), dt};
      const std::size_t count = go_straight(open, way, straight.data(), left.data());
      for (std::size_t k = 0; k < count; ++k) {
        const auto one = static_cast<std::size_t>(left[k]);
        Vec3 start = way.p[one];
        if (is_near_floating(start, straight[one])) predict(start, way.v[one], dt);
      }
    });
    if (!floating_->settle(comm)) break;
  }
  sounding_ = false;
  recording_ = recorded;
}

bool Obstacles::is_body_touched(MPI_Comm comm) {
  if (!floating_) return false;
  const std::vector<TotalImpulse> all = ledger_.total(comm);
  return std::any_of(all.begin() + static_cast<std::ptrdiff_t>(floating_->first()),
                     all.begin() + static_cast<std::ptrdiff_t>(box_account()),
                     [](const TotalImpulse& one) { return !one.shift.isZero(); });
}

void Obstacles::give_to_bodies(MPI_Comm comm) {
  if (!floating_) return;
  floating_->give(recorded(comm));
}

void Obstacles::finish_bodies(MPI_Comm comm) {
  if (!floating_) return;
  const std::vector<TotalImpulse> all = recorded(comm);
  floating_->finish(all);
  finished_.resize(all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    finished_[k].shift += all[k].shift;
    finished_[k].moment += all[k].moment;
  }
  ledger_.clear();
}

void Obstacles::record(std::size_t account, const Vec3& shift, const Vec3& p) {
  if (!recording_) return;
  record_projection(account, shift, p);
  gauges_->add(shift, p);
}

void Obstacles::record_projection(std::size_t account, const Vec3& shift, const Vec3& p) {
  const Vec3 center = account < bodies_.size() ? arm_center(account) : account == box_account() ? middle_of_box_ : p;
  const Impulse push{shift, p - center};
  ledger_.add(account, {&push, 1});
}

void Obstacles::record_box(std::span<Impulse> impulses) {
  for (Impulse& push : impulses) {
    push.shift *= relaxation_;
    if (gauges_->count() != 0) gauges_->add(push.shift, push.arm);
    push.arm -= middle_of_box_;
  }
  ledger_.add(box_account(), impulses);
}

std::size_t Obstacles::bytes() const {
  std::size_t bytes = index_->bytes();
  for (const auto& body : bodies_) bytes += body->bytes();
  return bytes;
}

}  // namespace trevi

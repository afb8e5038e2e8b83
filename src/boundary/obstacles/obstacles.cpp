#include "boundary/obstacles/obstacles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/kernels.hpp"

namespace trevi {

namespace {

// Distance from floating bodies, in units of h, within which paths are examined that they may meet once they are
// settled.
constexpr Real wider = 1.0 / 16;

// The box at whose walls solids end. In two dimensions there are no walls along y, and clamping a position to them
// would round its other coordinates.
Box box_of_solids(const Settings& settings, const Box& open) {
  Box box = settings.domain;
  if (settings.fluid.dimensions == 2) {
    box.min.y() = open.min.y();
    box.max.y() = open.max.y();
  }
  return box;
}

// There is no moment of all of the water about an axis perpendicular to one along which the box is periodic.
Eigen::Array<bool, 3, 1> axes_of_turns(const Settings& settings) {
  const std::array<bool, 3>& repeats = settings.periodic;
  const bool is_layer = settings.fluid.dimensions == 2;
  return {!repeats[1] && !repeats[2] && !is_layer, !repeats[2] && !repeats[0], !repeats[0] && !repeats[1] && !is_layer};
}

}  // namespace

Obstacles::Obstacles(const Settings& settings, const Walls& walls, std::optional<AnalyticWallDensity> law)
    : middle_of_box_((settings.domain.min + settings.domain.max) / 2),
      turns_(axes_of_turns(settings)),
      walls_(walls),
      law_(std::move(law)),
      ledger_(settings.obstacles.size() + settings.bodies.size() + 2, settings.fluid.kernel_radius),
      wider_(wider * settings.fluid.kernel_radius),
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
  are_bent_known_ = false;
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

Real Obstacles::acceleration(Real begin, Real end, Real h) const {
  Real most = 0;
  const std::size_t driven = floating_ ? floating_->first() : bodies_.size();
  for (std::size_t k = 0; k < driven; ++k)
    most = std::max(most, bodies_[k]->motion().acceleration(begin, end, bodies_[k]->radius(), h));
  return most;
}

// Of many bodies only those near a piece of water are examined. If there are few, all are examined, and the space that
// they leave open extends further than a path.
bool Obstacles::are_few() const {
  constexpr std::size_t few_bodies = 4;
  return bodies_.size() <= few_bodies;
}

// Their region is determined from some of them, about one per cell.
Obstacles::Surroundings Obstacles::look_around(std::span<const Vec3> p) const {
  constexpr std::size_t each = 8;
  const Box water = box_around(p, each);
  return {water, are_few() ? index_->all() : index_->in(water)};
}

// Each piece is requested a dozen times per substep.
Obstacles::Surroundings Obstacles::around(std::span<const Vec3> p, LocalId first) const {
  const auto count = static_cast<LocalId>(p.size());
  const std::size_t piece = static_cast<std::size_t>(std::max(first, 0)) / at_once;
  if (first < 0 || count > at_once || piece >= around_.size()) return look_around(p);
  Known& known = around_[piece];
  if (known.first != first || known.count != count || known.version != index_->version())
    known = {first, count, index_->version(), look_around(p)};
  return known.around;
}

OpenSpace Obstacles::open_space(const Surroundings& around, Extent extent) const {
  return open_space(around, [&](std::size_t k) { return bodies_[k]->part(extent); });
}

// part_of(k) is the part of space that obstacle k closes; null if that is all of it.
template <class PartOf>
OpenSpace Obstacles::open_space(const Surroundings& around, const PartOf& part_of) const {
  constexpr Real far = 4;
  const Vec3 path = Vec3::Constant((are_few() ? far : 1) * index_->longest_path());
  OpenSpace space(walls_.box());
  space.confine({around.water.min - path, around.water.max + path});
  space.set_near(around.near);
  const bool is_closed = index_->any(around.near, [&](std::size_t k) {
    const ClosedPart* const part = part_of(k);
    if (part != nullptr) space.close(*part);
    return part == nullptr;
  });
  if (is_closed) space = OpenSpace();
  return space;
}

namespace {

// The density that one obstacle contributes, and its gradient in the world frame, at a position in its frame that is
// not out of reach.
Obstacles::NearDensity contribution_at(const Body& body, const AnalyticWallDensity& law, const Vec3& there) {
  const EquivalentPlane plane = body.map().at(there, law.reach());
  const auto [value, slope] = law.of_plane(plane.distance);
  return {{value, slope * (body.now().turn * plane.gradient)}, plane.is_near};
}

BoundaryDensity contribution_of(const Body& body, const AnalyticWallDensity& law, const Vec3& p) {
  if (!body.may_reach(p)) return {};
  const Vec3 there = body.now().into_body(p);
  return body.is_out_of_reach(there) ? BoundaryDensity{} : contribution_at(body, law, there);
}

}  // namespace

// Obstacle by obstacle, for each of them all positions at once.
void Obstacles::find_near(const OpenSpace& open, std::span<const Vec3> p, std::span<NearDensity> found) const {
  std::fill(found.begin(), found.end(), NearDensity{});
  if (!law_ || p.empty()) return;
  const bool are_there = std::all_of(p.begin(), p.end(), [&](const Vec3& one) { return open.box().contains(one); });
  std::array<Vec3, at_once> there;
  std::array<Real, at_once> distance;
  std::array<std::size_t, at_once> which;
  index_->for_each(are_there ? open.near() : index_->all(), [&](std::size_t k) {
    const Body& body = *bodies_[k];
    std::size_t count = 0;
    for (std::size_t n = 0; n < p.size(); ++n) {
      if (!body.may_reach(p[n])) continue;
      there[count] = body.now().into_body(p[n]);
      which[count++] = n;
    }
    body.quick_distances({there.data(), count}, distance);
    for (std::size_t n = 0; n < count; ++n) {
      if (body.is_out_of_reach(distance[n])) continue;
      const NearDensity one = contribution_at(body, *law_, there[n]);
      if (!one.is_near) continue;  // it contributes none
      NearDensity& all = found[which[n]];
      all.density += one.density;
      all.gradient += one.gradient;
      all.is_near = true;
    }
  });
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

bool Obstacles::is_near_floating(const Vec3& from, const Vec3& to) const {
  const std::size_t first = floating_->first();
  return index_->any(along(from, to),
                     [&](std::size_t k) { return k >= first && !bodies_[k]->is_out_of_way(from, to); });
}

// In two rounds, because what they meet depends slightly on how fast they are.
void Obstacles::settle(MPI_Comm comm, Particles& particles, Real dt) {
  if (!floating_) return;
  const std::vector<Vec3>&x = particles.position, &v = particles.velocity, &straight = particles.predicted;
  if (around_.size() != x.size() / at_once + 1) number_particles(x.size());
  const bool recorded = std::exchange(recording_, false);
  sounding_ = true;
  find_bent(particles, dt);
  for (int round = 0; round < 2; ++round) {
    if (!are_bent_still_all()) find_bent(particles, dt);
    for_each_part({0, static_cast<LocalId>(bent_.size())}, at_once, [&](Range part) {
      for (LocalId k = part.begin; k < part.end; ++k) {
        const auto i = static_cast<std::size_t>(bent_[static_cast<std::size_t>(k)]);
        Vec3 start = x[i];
        if (is_near_floating(start, straight[i])) predict(start, v[i], dt);
      }
    });
    if (!floating_->settle(comm)) break;
  }
  are_bent_known_ = are_bent_still_all();
  sounding_ = false;
  recording_ = recorded;
}

// Includes those that would have to be examined if the bodies were slightly elsewhere.
void Obstacles::find_bent(Particles& particles, Real dt) {
  note_ways();
  const auto part_of = [&](std::size_t k) {
    return floating_->holds(k) ? &ways_[k - floating_->first()].wide : bodies_[k]->part(Extent::path);
  };
  PerThread<std::vector<LocalId>> found;
  for_each_part({0, particles.size()}, at_once, [&](Range part) {
    const auto begin = static_cast<std::size_t>(part.begin), count = static_cast<std::size_t>(part.size());
    const Straight way{{&particles.position[begin], count}, {&particles.velocity[begin], count}, dt};
    const OpenSpace open = open_space(around(way.p, part.begin), part_of);
    std::array<LocalId, at_once> left;
    const std::size_t bent = go_straight(open, way, &particles.predicted[begin], left.data());
    for (std::size_t k = 0; k < bent; ++k) found.mine().push_back(part.begin + left[k]);
  });
  bent_.clear();
  found.for_each([&](const auto& some) { bent_.insert(bent_.end(), some.begin(), some.end()); });
}

void Obstacles::note_ways() {
  ways_.clear();
  for (std::size_t k = floating_->first(); k < bodies_.size(); ++k) {
    const auto& [box, ball] = *bodies_[k]->part(Extent::path);
    const Box wide{box.min.array() - wider_, box.max.array() + wider_};
    ways_.push_back({bodies_[k]->reach(), {wide, {ball.center, ball.radius + wider_}}});
  }
}

// Whether the bodies are where they can meet no particles other than those that were found.
bool Obstacles::are_bent_still_all() const {
  const auto holds = [](const Box& box, const Box& other) {
    return box.contains(other.min) && box.contains(other.max);
  };
  for (std::size_t n = 0; n < ways_.size(); ++n) {
    const auto& [box, ball] = *bodies_[floating_->first() + n]->part(Extent::path);
    const auto& [reach, wide] = ways_[n];
    if (!holds(reach, box) || !holds(wide.box, box)) return false;
    if (!((ball.center - wide.ball.center).norm() + ball.radius <= wide.ball.radius)) return false;
  }
  return true;
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
    if (floating_->holds(k)) finished_[k].moment -= floating_->spurious_moment(k - floating_->first());
  }
  ledger_.clear();
}

void Obstacles::record(std::size_t account, const Vec3& shift, const Vec3& p) {
  if (!recording_) return;
  record_projection(account, shift, p);
  gauges_->add(shift, p);
}

void Obstacles::record_projection(std::size_t account, const Vec3& shift, const Vec3& p) {
  const Impulse push{shift, p - (account < bodies_.size() ? arm_center(account) : middle_of_box_)};
  ledger_.add(account, {&push, 1});
}

void Obstacles::take_from_rest(std::size_t account, const TotalImpulse& part) {
  const Vec3 of_shift = reference_of(account).cross(part.shift);
  const bool floats = floating_ && floating_->holds(account);
  const TotalImpulse own{part.shift, floats ? Vec3::Zero() : Vec3(part.moment - of_shift)};
  ledger_.add(account, own);
  record_rest({-part.shift, -own.moment - of_shift});
}

void Obstacles::record_about(std::size_t account, const TotalImpulse& push, const Vec3& place) {
  const Vec3 arm = place - (account == box_account() ? middle_of_box_ : arm_center(account));
  ledger_.add(account, {push.shift, push.moment + arm.cross(push.shift)});
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

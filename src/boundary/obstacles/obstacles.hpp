// The obstacles of a scene: what they contribute to the density of particles near them, where the paths of particles
// end, and what obstacles and box receive of the water's momentum. Metres and seconds. Functions for single particles
// may be called in loops that threads share; move() and clear() may not. Collective: total().
#pragma once

#include <Eigen/Geometry>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "boundary/gauges.hpp"
#include "boundary/impulse_ledger.hpp"
#include "boundary/obstacles/body.hpp"
#include "boundary/obstacles/obstacle_index.hpp"
#include "boundary/obstacles/open_space.hpp"
#include "boundary/rigid_bodies/rigid_bodies.hpp"
#include "boundary/wall_density.hpp"
#include "boundary/walls.hpp"
#include "trevi/particles.hpp"

namespace trevi {

class Obstacles {
 public:
  /// Without `law` obstacles have no density, like walls without one.
  Obstacles(const Settings& settings, const Walls& walls, std::optional<AnalyticWallDensity> law);

  /// See Body::set_paddle_offset().
  void set_paddle_offset(std::size_t k, Real begin, Real end) { bodies_[k]->set_paddle_offset(begin, end); }
  /// Takes all obstacles to where they are from `begin` to `end`, and bodies to where they are expected.
  void move(Real begin, Real end);
  /// The freely moving bodies among them; null if there are none.
  RigidBodies* floating() { return floating_.get(); }
  const RigidBodies* floating() const { return floating_.get(); }
  /// Finds how fast the bodies are among the particles that are about to bounce off them. Collective if there are any.
  /// Afterwards `predicted` holds the ends of straight paths, and bent() the particles whose paths may be different.
  void settle(MPI_Comm comm, Particles& particles, Real dt);
  /// Null if that is not known, as before settle() and without bodies.
  const std::vector<LocalId>* bent() const { return are_bent_known_ ? &bent_ : nullptr; }
  /// Before the projection, the bodies are given what the ledger holds so far in the substep; at the end of the substep
  /// all of it, which is then kept for total(). Collective.
  void give_to_bodies(MPI_Comm comm);
  void finish_bodies(MPI_Comm comm);

  /// The space around these particles into which no obstacle reaches. `first` is the number of the first of them, if
  /// they are numbered. Loops that threads share ask for at_once consecutive particles at a time.
  OpenSpace open_space(std::span<const Vec3> p, Extent extent, LocalId first = -1) const {
    return open_space(around(p, first), extent);
  }
  static constexpr LocalId at_once = 128;
  /// From now on there are this many numbered particles, which may be different ones.
  void number_particles(std::size_t count) { around_.assign(count / at_once + 1, {}); }
  /// Whether obstacles count as water for the density; if not, is_near() is false everywhere.
  bool has_density() const { return law_.has_value(); }
  /// Whether p is so near to an obstacle that this may contribute to its density.
  bool is_near(const Vec3& p) const {
    return law_ && index_->any(index_->at(p), [&](std::size_t k) { return bodies_[k]->is_near(p); });
  }
  /// The same, for obstacles that do not float.
  bool is_near_fixed(const Vec3& p) const {
    const std::size_t end = floating_ ? floating_->first() : bodies_.size();
    return law_ && index_->any(index_->at(p), [&](std::size_t k) { return k < end && bodies_[k]->is_near(p); });
  }
  /// Whether the water has given anything to a freely moving body in this substep. Collective.
  bool is_body_touched(MPI_Comm comm);
  /// The contribution of all obstacles at a position, and whether one of them is so near that it may contribute. Their
  /// solids do not overlap, so their contributions add up.
  struct NearDensity : BoundaryDensity {
    bool is_near = false;
  };
  /// For up to at_once positions of the particles for which `open` was found.
  void find_near(const OpenSpace& open, std::span<const Vec3> p, std::span<NearDensity> found) const;
  /// The contribution of the box and all obstacles: they are independent, like walls at an edge of the box.
  static BoundaryDensity together(const BoundaryDensity& box, const BoundaryDensity& all);
  /// The increase of this contribution for a particle at p that moves by `path`, m, in the substep.
  Real growth(const BoundaryDensity& box, const Vec3& p, const Vec3& path) const;
  /// Records in the ledger a shift along the gradient of the contribution at p: `factor` times its parts, as far as the
  /// density solver follows it.
  void record_gradient(const BoundaryDensity& box, const Vec3& p, Real factor);
  /// The same for particles that no obstacle is near.
  void record_box(std::span<Impulse> impulses);

  /// Visits the obstacles that contribute to the density at p: visit(account, distance of the equivalent plane, m, its
  /// normal into the water, displacement in the substep of a point at p that moves with the obstacle, m).
  template <class Visit>
  void for_each_near(const Vec3& p, Visit&& visit) const {
    index_->for_each(index_->at(p), [&](std::size_t k) {
      const Body& body = *bodies_[k];
      if (!body.is_near(p)) return;
      const Vec3 there = body.now().into_body(p);
      const EquivalentPlane plane = body.map().at(there);
      const Vec3 normal = body.now().turn * plane.gradient.stableNormalized();
      visit(k, plane.distance, normal, Vec3(p - body.before().into_world(there)));
    });
  }

  /// Whether a position is in a solid, or one is on the straight line to it, with the obstacles where they are now.
  bool covers(const Vec3& from, const Vec3& place) const {
    return std::any_of(bodies_.begin(), bodies_.end(), [&](const auto& body) { return body->covers(from, place); });
  }

  /// Motion with a velocity, from the obstacles' poses before to those now, with bounces at walls and obstacles. If it
  /// begins inside an obstacle, which has pressed the particle against a wall, it begins at the surface instead, and p
  /// is set to that position, because the way out of a solid is not motion.
  Vec3 predict(Vec3& p, const Vec3& v, Real dt);
  /// Shift by the density solve, with the obstacles where they are now: it continues along what it meets.
  Vec3 collide(const Vec3& p, const Vec3& shift);

  std::size_t count() const { return bodies_.size(); }
  const Body& body(std::size_t k) const { return *bodies_[k]; }
  bool moves() const;
  /// The highest speed of a point of an obstacle, m/s.
  Real fastest(Real begin, Real end) const;
  /// The largest acceleration of an obstacle whose motion is prescribed, m/s² (BodyMotion::acceleration()).
  Real acceleration(Real begin, Real end, Real h) const;

  /// Accounts: obstacles in their order, then the box. Moments are about the centres of obstacles and the middle of the
  /// box, from which no arm is so long that the integers of the ledger overflow.
  ImpulseLedger& ledger() { return ledger_; }
  std::size_t box_account() const { return bodies_.size(); }
  /// What moves the water besides the pressure on surfaces: its transfer between particles and cells does not balance
  /// to the last digit. Its moments are about the middle of the box, too.
  std::size_t rest_account() const { return bodies_.size() + 1; }
  /// A shift at a position, with its moment about that middle.
  TotalImpulse about_middle(const Vec3& shift, const Vec3& place) const {
    return {shift, (place - middle_of_box_).cross(shift)};
  }
  /// What the walls of the box give to the water, with its moment about that middle.
  void record_walls(const TotalImpulse& push) { ledger_.add(box_account(), push); }
  void record_rest(const TotalImpulse& rest) { ledger_.add(rest_account(), rest); }
  /// A part of the remainder, with its moment about the middle of the box, that came from an obstacle, not from the
  /// box; for a floating body the force alone.
  void take_from_rest(std::size_t account, const TotalImpulse& part);
  /// A push of an account, with its moment about any place.
  void record_about(std::size_t account, const TotalImpulse& push, const Vec3& place);
  /// Discards what was recorded before.
  void begin_step();
  /// What obstacles and box gave to the water since begin_step(), in the order of the accounts. The remainder is shared
  /// among them in proportion to the squares of what each gave, along the line on which that acts. The couple that is
  /// then left over is shared in the same way, so that the sums are those of the water. Moments are about the pivots,
  /// those of the box about the origin. Collective.
  std::vector<TotalImpulse> total(MPI_Comm comm);
  /// The pressure on walls and obstacles, cleared together with the ledger.
  PressureGauges& gauges() { return *gauges_; }
  /// Records in the ledger and the gauges a shift that the box or an obstacle gave to a particle at p.
  void record(std::size_t account, const Vec3& shift, const Vec3& p);
  /// Whether anything is recorded; not while only positions are shifted and no momentum changes.
  void record_impulses(bool on) { recording_ = on; }
  bool records_impulses() const { return recording_; }
  /// Records in the ledger alone, for the projection, which has its own rule for gauges.
  void record_projection(std::size_t account, const Vec3& shift, const Vec3& p);

  /// From the centre of an obstacle to its pivot, m; zero for floating bodies, whose moments are about their own
  /// centres.
  Vec3 lever(std::size_t k) const { return bodies_[k]->pivot() - bodies_[k]->midway().center; }

  /// Mass of the water at rest density that a particle represents, kg: forces are those of such water, whereas the mass
  /// of particles is calibrated to their kernel.
  Real water_mass() const { return water_mass_; }

  std::size_t bytes() const;

 private:
  struct Leg;
  // A leg from p, with the obstacles at their poses before or now.
  Leg leg_from(const Vec3& p, bool before);
  // From the ledger, with the remainder shared.
  std::vector<TotalImpulse> recorded(MPI_Comm comm);
  // Where a solid lies relative to the reference point of its moments, and how far it extends from there, within the
  // box.
  struct Whereabouts;
  Whereabouts whereabouts(std::size_t account) const;
  Vec3 arm_of(std::size_t account, const Vec3& shift, const Vec3& moment) const;
  struct Sharing;
  bool has_share(const Sharing& sharing, std::size_t account, Eigen::Index axis) const;
  std::array<bool, 3> are_by_fixed(const std::vector<TotalImpulse>& all) const;
  Vec3 share_rest(const Sharing& sharing, std::vector<TotalImpulse>& all) const;
  void share_couple(const Sharing& sharing, const Vec3& couple, std::vector<TotalImpulse>& all) const;
  // From the middle of the box to the reference point of the moments of an account.
  Vec3 reference_of(std::size_t account) const {
    return account == box_account() ? Vec3(-middle_of_box_) : Vec3(arm_center(account) - middle_of_box_);
  }
  const Vec3& arm_center(std::size_t k) const {
    return floating_ && floating_->holds(k) ? floating_->center(k) : bodies_[k]->pivot();
  }
  // The approximate region of some particles, and the obstacles near it.
  struct Surroundings {
    Box water;
    ObstacleIndex::Bits near;
  };
  // The same for those with numbers from `first` on, when the index had this version. They may have moved since; those
  // that have left the region are outside of the open space.
  struct Known {
    LocalId first = -1, count = 0;
    std::uint64_t version = 0;
    Surroundings around;
  };
  Surroundings around(std::span<const Vec3> p, LocalId first) const;
  Surroundings look_around(std::span<const Vec3> p) const;
  OpenSpace open_space(const Surroundings& around, Extent extent) const;
  template <class PartOf>
  OpenSpace open_space(const Surroundings& around, const PartOf& part_of) const;
  bool are_few() const;
  bool is_near_floating(const Vec3& from, const Vec3& to) const;
  void find_bent(Particles& particles, Real dt);
  void note_ways();
  bool are_bent_still_all() const;
  // Those that a path may approach.
  ObstacleIndex::Bits along(const Vec3& from, const Vec3& to) const {
    return ObstacleIndex::is_path_short(from, to, index_->longest_path()) ? index_->at(from) : index_->all();
  }
  Vec3 among(Vec3& p, const Vec3& v, Real dt);
  void record_bounce(std::size_t account, const Vec3& shift, const Vec3& p, const Vec3& start);

  std::vector<std::unique_ptr<Body>> bodies_;
  std::optional<ObstacleIndex> index_;  // made when all bodies are there
  mutable std::vector<Known> around_;   // of each piece of the particles, for whichever thread works on it
  std::unique_ptr<RigidBodies> floating_;
  // From settle(): the particles, and for each floating body what it might reach and might meet when they were found.
  struct Way {
    Box reach;
    ClosedPart wide;
  };
  std::vector<LocalId> bent_;
  std::vector<Way> ways_;
  bool are_bent_known_ = false;
  std::vector<TotalImpulse> finished_;  // of the substeps of the step, with bodies
  bool sounding_ = false;               // settle() examines what bounces
  Vec3 middle_of_box_;
  Eigen::Array<bool, 3, 1> turns_;  // axes about which all of the water has one angular momentum
  Walls walls_;
  std::optional<AnalyticWallDensity> law_;
  ImpulseLedger ledger_;
  PerThread<std::vector<Segment>> segments_;  // of the leg that a thread follows
  std::optional<PressureGauges> gauges_;      // made when all bodies are there
  bool recording_ = true;
  Real wider_;       // m
  Real relaxation_;  // of shifts by the density solver
  Real water_mass_;
};

}  // namespace trevi

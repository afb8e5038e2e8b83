// Contacts of rigid bodies with each other, with obstacles and with the box: points of a body's surface that may reach
// the surface of another solid in the substep. They are found before the solids touch, so that nothing passes through
// anything, and a body comes to rest on another one without a jump. Impulses with Coulomb friction are computed by the
// Gauss-Seidel method in the order of the contacts (Catto, Iterative dynamics with temporal coherence, 2005), for the
// inertia that a body has together with the surrounding water. Round parts of a body touch at their nearest point, not
// at sample points: facets would brake a rolling body. The same bits on any rank. Not collective.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "boundary/obstacles/body.hpp"
#include "boundary/rigid_bodies/rigid_body.hpp"

namespace trevi {

class Contacts {
 public:
  /// `all`: obstacles, then the bodies.
  Contacts(const Settings& settings, const std::vector<std::unique_ptr<Body>>& all);

  /// Finds the contacts of bodies that begin a substep.
  void find(const std::vector<RigidBody>& bodies, Real dt);
  /// Changes the bodies' twists as far as contacts require, and gives them the impulses.
  void solve(std::vector<RigidBody>& bodies);
  bool touches(std::size_t body) const;
  /// The work of obstacles that move by themselves, J, since the last call.
  Real take_driven_work() { return std::exchange(driven_work_, 0); }

 private:
  struct Contact {
    std::size_t body, other;          // of all bodies; nobody: the rest of the world
    std::array<Six, 3> arm, against;  // along the normal and two tangents; of the other body
    std::array<Real, 3> surface;      // velocities of what is not a body, m/s
    Real least;                       // separation speed along the normal, m/s
    Real friction;
    std::array<Real, 3> impulse;              // so far, N s
    std::array<Six, 3> answer, answer_other;  // change of the twists by an impulse of 1 N s
    std::array<Real, 3> mobility;             // of the velocity there, 1/kg
  };
  struct Near {
    Real gap;
    Vec3 p, normal, surface;
  };
  /// The round part of a body: all that is no further than `radius` from the centre of a ball, from the line in a
  /// capsule or from the ring in a torus; for a cylinder its side, about the axis only. Other shapes have none.
  struct Round {
    ShapeKind kind;
    Real radius = 0;  // m
    Real middle = 0;  // m: half the line, or the radius of the ring
    explicit Round(const ObstacleSettings& solid);
    bool is_side() const { return kind == ShapeKind::cylinder; }
    /// The point of that centre, line or ring next to a point of the surface; both in the frame of the shape.
    Vec3 middle_of(const Vec3& p) const;
    /// The point of the round part next to p that is nearest to a surface with this normal; p if there is no such part.
    Vec3 nearest(const Vec3& p, const Vec3& normal) const;
  };
  static constexpr std::size_t nobody = static_cast<std::size_t>(-1);
  void note_walls_reached_through(const BodySettings& body);
  void find_edges(const Settings& settings);
  void find_walls(const std::vector<RigidBody>& bodies, std::size_t k);
  void find_solid(const std::vector<RigidBody>& bodies, std::size_t k, std::size_t solid);
  void append_edges(std::size_t k, std::size_t obstacle, Real margin, std::vector<Near>& near) const;
  template <class Gap, class Normal>
  std::vector<Near> near_points(std::size_t k, bool convex, Real margin, const Gap& gap_of,
                                const Normal& normal_at) const;
  void add(const std::vector<RigidBody>& bodies, std::size_t k, std::size_t other, std::vector<Near>& near,
           const std::pair<Real, Real>& restitution_and_friction);
  const Pose& pose_of(std::size_t solid) const { return poses_[solid]; }
  Real rebound(Real restitution, Real v, Real a, Real distance) const;
  static void keep_few(std::vector<Near>& near);
  void find_answers(const std::vector<RigidBody>& bodies);
  static Real velocity_of(const Contact& contact, std::size_t along, const std::vector<Six>& twists);
  // What is given in one round, N s.
  static Real set_impulse(Contact& contact, std::size_t along, Real total, std::vector<Six>& twists);
  static Real push(Contact& contact, std::vector<Six>& twists);
  static std::array<Real, 2> brake(Contact& contact, std::vector<Six>& twists);

  const std::vector<std::unique_ptr<Body>>* all_;
  std::size_t first_;
  Box box_;
  Real spacing_, gravity_, dt_ = 0;
  std::vector<std::pair<Real, Real>> surface_;  // restitution and friction of each solid
  Real wall_restitution_;
  std::vector<std::vector<Vec3>> points_;  // of each body, in its frame; the next two as well
  std::vector<std::vector<Vec3>> middles_;
  std::vector<std::vector<Vec3>> edges_;  // of each obstacle, in its frame: points of its edges
  std::vector<Round> round_;
  std::vector<std::array<std::array<bool, 2>, 3>> goes_through_;  // of each body, the walls that do not exist for it
  std::vector<bool> is_convex_, is_ball_;                         // of all solids; balls that are bodies
  std::vector<Pose> poses_, ends_;                                // of all solids in the substep
  std::vector<Contact> contacts_;
  Real driven_work_ = 0;
};

}  // namespace trevi

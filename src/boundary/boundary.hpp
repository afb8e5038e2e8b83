// What a moving particle may meet: the walls of the box, obstacles and the ends of periodic axes. There is one class
// for each combination; make_boundary() chooses it once, and nothing else in a step asks what a scene contains. What
// walls and obstacles contribute to the density is in wall_density.hpp and obstacles.hpp. Metres and seconds.
// predict(), collide() and open_space() may be called in loops that threads share. Not collective.
#pragma once

#include <memory>
#include <span>

#include "boundary/obstacles/obstacles.hpp"
#include "boundary/periodic_domain.hpp"
#include "boundary/walls.hpp"
#include "trevi/particles.hpp"

namespace trevi {

class Boundary {
 public:
  explicit Boundary(const Walls& walls) : walls_(walls) {}
  virtual ~Boundary() = default;
  Boundary(const Boundary&) = delete;
  Boundary& operator=(const Boundary&) = delete;

  /// The end of a path with velocity v after the time dt, including bounces. A position inside a moving obstacle, which
  /// has pressed it against a wall, is first taken to the surface of the obstacle.
  virtual Vec3 predict(Vec3& p, const Vec3& v, Real dt) = 0;
  /// The end of a shift of the density solve.
  virtual Vec3 collide(const Vec3& p, const Vec3& shift) = 0;
  /// predict() of all particles, from their positions with their velocities to `predicted`. Returns the first particle
  /// that is then not inside the walls, or not a number; the number of particles if there is none.
  LocalId predict(Particles& particles, Real dt);
  /// The region in which shifts, or paths, of these particles meet nothing; empty if each particle must be examined.
  /// `first`: see Obstacles::open_space().
  virtual OpenSpace open_space(std::span<const Vec3> p, Extent extent, LocalId first) const = 0;
  /// Whether all particles inside the walls are in open_space().
  virtual bool is_open_inside() const { return false; }

  /// begin_step() clears the records of a new step; move() takes what moves by itself to its places at `begin` and
  /// `end`.
  virtual void begin_step() {}
  /// For freely moving bodies: between move() and predict(), before the projection, and at the end of a substep.
  /// Collective if there are any. settle_bodies() computes the ends of straight paths for predict(), which follows it.
  virtual void settle_bodies(MPI_Comm, Particles&, Real /*dt*/) {}
  virtual void give_to_bodies(MPI_Comm) {}
  virtual void finish_bodies(MPI_Comm) {}
  virtual void move(Real /*begin*/, Real /*end*/) {}
  /// The highest speed of what moves by itself, m/s.
  virtual Real fastest(Real /*begin*/, Real /*end*/) const { return 0; }
  /// The largest acceleration of obstacles with a prescribed motion, m/s² (BodyMotion::acceleration()).
  virtual Real acceleration(Real /*begin*/, Real /*end*/, Real /*h*/) const { return 0; }

  /// Along periodic axes: rounds positions to the quantum; also takes them back into the box; takes p* into the period
  /// that begins at the first cell, and x along with it, because velocities come from the displacement between the two.
  /// In two dimensions wrap_positions() also keeps the layer in its plane.
  virtual void round_positions(Particles&) const {}
  virtual void wrap_positions(Particles&) const {}
  virtual void wrap_predicted(Particles&) const {}

  /// The walls of the box; along periodic axes they are far away.
  const Walls& walls() const { return walls_; }
  /// Null if there are none.
  virtual Obstacles* obstacles() const { return nullptr; }

 private:
  // The particles for which predict() must be called, if `predicted` already holds the straight paths of all others;
  // otherwise null.
  virtual const std::vector<LocalId>* bent() const { return nullptr; }

  Walls walls_;
};

/// What make_boundary() chooses from; `obstacles` may be null, `periodic` absent. `layer`: two dimensions.
struct BoundaryParts {
  Walls walls;
  std::shared_ptr<Obstacles> obstacles;
  std::optional<PeriodicDomain> periodic;
  bool layer = false;
};
std::unique_ptr<Boundary> make_boundary(BoundaryParts parts);

}  // namespace trevi

// What a moving particle meets: the walls of the box, obstacles, the ends of periodic axes. There is one kind for each
// combination, chosen once by make_boundary(); nothing else in a step asks what a scene has. What walls and obstacles
// add to the density is in wall_density.hpp and obstacles.hpp. Metres and seconds. predict(), collide() and
// open_space() may be called in loops that threads share. Not collective.
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

  /// Where the path of a velocity ends after the time dt, bounces included. A place in a moving obstacle, which has
  /// pressed it against a wall, is taken to its surface first.
  virtual Vec3 predict(Vec3& p, const Vec3& v, Real dt) = 0;
  /// Where a shift of the density solve ends.
  virtual Vec3 collide(const Vec3& p, const Vec3& shift) = 0;
  /// predict() of all particles, from their positions by their velocities to `predicted`. Returns the first that is not
  /// inside of the walls then, or not a number; their number where there is none.
  LocalId predict(Particles& particles, Real dt);
  /// Where shifts, or paths, of these particles meet nothing; no place where each has to be asked for.
  /// `first`: see Obstacles::open_space().
  virtual OpenSpace open_space(std::span<const Vec3> p, Extent extent, LocalId first) const = 0;
  /// Whether all particles are inside of open_space().
  virtual bool is_open_inside() const { return false; }

  /// What moves by itself is taken to where it is from `begin` to `end`; with a new step its records are cleared.
  virtual void begin_step() {}
  /// Bodies that move freely: between move() and predict(), before the projection, and at the end of a substep.
  /// Collective where there are any. settle_bodies() finds the ends of straight paths for predict(), which follows it.
  virtual void settle_bodies(MPI_Comm, Particles&, Real /*dt*/) {}
  virtual void give_to_bodies(MPI_Comm) {}
  virtual void finish_bodies(MPI_Comm) {}
  virtual void move(Real /*begin*/, Real /*end*/) {}
  /// The highest speed of what moves by itself, m/s.
  virtual Real fastest(Real /*begin*/, Real /*end*/) const { return 0; }

  /// Along periodic axes: positions to the quantum; then back into the box; and p* with its x into the length of the
  /// box that begins at the first cell, together, as velocities come from the displacement between the two. In two
  /// dimensions wrap_positions() also keeps the layer in its plane.
  virtual void round_positions(Particles&) const {}
  virtual void wrap_positions(Particles&) const {}
  virtual void wrap_predicted(Particles&) const {}

  /// The walls of the box, far away along periodic axes.
  const Walls& walls() const { return walls_; }
  /// Null where there are none.
  virtual Obstacles* obstacles() const { return nullptr; }

 private:
  // The particles of which predict() needs to be asked, where `predicted` has the straight paths of all others; else
  // null.
  virtual const std::vector<LocalId>* bent() const { return nullptr; }

  Walls walls_;
};

/// What make_boundary() chooses from; `obstacles` may be null, `periodic` absent. `layer`: of two dimensions.
struct BoundaryParts {
  Walls walls;
  std::shared_ptr<Obstacles> obstacles;
  std::optional<PeriodicDomain> periodic;
  bool layer = false;
};
std::unique_ptr<Boundary> make_boundary(BoundaryParts parts);

}  // namespace trevi

// Conserves the momentum of each piece of water along axes along which nothing can push it (water_pieces.hpp), and the
// angular momentum of pieces that touch nothing, apart from the effect of gravity. The projection gives the smooth part
// of its pressure to the particles of a face as if there were as many as in full water (face_shares.hpp), and sweeps
// shift positions without velocity. Both conserve momentum on average, but not to rounding. In flight, moreover, the
// pressure at the upper side of compressed water is higher than at the lower side. The changes of the two momenta in
// the substep are undone by a translation and a rotation of the velocities of the piece, or by a translation alone if
// the box is periodic along an axis. The centre of a piece that touches nothing is moved back to the position of free
// flight (free_flight.hpp). Water on a smooth floor keeps its momentum along the floor as long as no wall across this
// direction and no solid is near. The momentum from pressure at the sides of a drain in the floor is spread over all of
// the water. Collective.
#pragma once

#include "base/orderless_sum.hpp"
#include "solver/density_solver.hpp"
#include "solver/water_pieces.hpp"
#include "trevi/box.hpp"

namespace trevi {

template <class T>
class FreeMomentum : public DensitySolver<T> {
 public:
  /// `solver` must set velocities.
  FreeMomentum(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver);

  void begin(DensityProblem<T>& problem) override { solver_->begin(problem); }
  SolveResult solve(DensityProblem<T>& problem) override;
  bool sets_velocities() const override { return true; }
  std::size_t bytes() const override { return solver_->bytes(); }

 private:
  // For a piece, with lengths in units of h: the number of particles, of those near something that may push along each
  // axis, a wall or a fixed solid, and of those near a freely moving body; Σ v dt; and if it may rotate, Σ p, Σ p × v
  // dt, and Σ p pᵀ in units of (16 h)², where p is measured from its first cell.
  static constexpr std::size_t counts = 5, sums = 15, words = counts + OrderlessSum::words * sums;
  using Words = std::vector<std::int64_t>;  // those of each piece
  struct Moments {
    Vec3 path = Vec3::Zero(), p = Vec3::Zero(), spin = Vec3::Zero();
    Eigen::Matrix3d pp = Eigen::Matrix3d::Zero();

    void add_arm(const Vec3& arm, const Vec3& way, bool spreads);
    void add_to(std::int64_t* next, bool turns) const;
  };
  struct Sums : Moments {
    using Moments::p, Moments::path, Moments::spin, Moments::pp;
    Real count = 0, near_floating = 0;
    WaterPieces::Axes touched = 0;

    explicit Sums(const std::int64_t* numbers);
    // About the centre of all its particles.
    Vec3 own_spin() const { return spin - (p / count).cross(path); }
  };
  // Corrections of the paths of the substep, in units of h, relative to the first cell of the piece.
  struct Undoing {
    Vec3 drift = Vec3::Zero(), turn = Vec3::Zero(), centre = Vec3::Zero(), off = Vec3::Zero();
    bool is_nothing() const { return drift.isZero(0) && turn.isZero(0) && off.isZero(0); }
  };

  // The sums of the motion only, or of everything.
  template <bool all, class Place, class Velocity>
  Words sums_of(const DensityProblem<T>& problem, const Place& place, const Velocity& velocity) const;
  void add_other_ranks(Words& before, Words& after) const;
  Undoing undoing(const Sums& before, const Sums& after, WaterPieces::Axes touched) const;
  void let_fly(DensityProblem<T>& problem) const;
  void undo(DensityProblem<T>& problem, const std::vector<Undoing>& all) const;
  Vec3 origin(std::size_t piece) const;
  WaterPieces::Axes touched(const Vec3& p) const;
  bool is_free(std::size_t piece) const;

  MPI_Comm comm_;
  CellGrid grid_;
  Box box_, interior_;           // m; interior_: where no wall acts
  Real h_;                       // m
  bool turns_ = true;            // whether there is an angular momentum to conserve
  WaterPieces::Axes still_ = 0;  // axes along which nothing moves
  Obstacles* obstacles_;
  WaterPieces pieces_;
  std::unique_ptr<DensitySolver<T>> solver_;
};

}  // namespace trevi

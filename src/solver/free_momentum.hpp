// Keeps the momentum of each piece of water along axes along which nothing can push it (water_pieces.hpp), and the
// angular one of what touches nothing, beside what gravity gives. The projection hands what is smooth of its pressure
// to the particles of a face as if they were as many as full water has there (face_shares.hpp), and sweeps shift
// positions without velocity: both are right in the mean, but not to rounding; and in flight the pressure at the upper
// side of water that is pressed together is higher than at the lower one. What the substep has changed of the two
// momenta is undone by a translation and a rotation of the velocities of the piece, where the box repeats along an axis
// by a translation alone; and the centre of what touches nothing goes back to where free flight takes it
// (free_flight.hpp). Water on a smooth floor keeps its momentum along it as far as no wall that stands across is near,
// nor a solid; what pushes at the sides of a drain in the floor goes to all of the water. Collective.
#pragma once

#include "base/orderless_sum.hpp"
#include "solver/density_solver.hpp"
#include "solver/water_pieces.hpp"
#include "trevi/box.hpp"

namespace trevi {

template <class T>
class FreeMomentum : public DensitySolver<T> {
 public:
  /// `solver` sets velocities.
  FreeMomentum(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver);

  void begin(DensityProblem<T>& problem) override { solver_->begin(problem); }
  SolveResult solve(DensityProblem<T>& problem) override;
  bool sets_velocities() const override { return true; }
  std::size_t bytes() const override { return solver_->bytes(); }

 private:
  // Of a piece, lengths in units of h: particles, those near what may push along each axis, a wall or a fixed solid,
  // and those near a body that moves freely; Σ v dt, and if it may turn Σ p, Σ p × v dt, and Σ p pᵀ in units of (16
  // h)², p being measured from its first cell.
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
    // About the centre of all.
    Vec3 own_spin() const { return spin - (p / count).cross(path); }
  };
  // In units of h, paths of the substep; from the first cell of the piece.
  struct Undoing {
    Vec3 drift = Vec3::Zero(), turn = Vec3::Zero(), centre = Vec3::Zero(), off = Vec3::Zero();
    bool is_nothing() const { return drift.isZero(0) && turn.isZero(0) && off.isZero(0); }
  };

  // Of motion alone, or of all.
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
  Box box_, interior_;           // m; where no wall acts
  Real h_;                       // m
  bool turns_ = true;            // whether there is an angular momentum to keep
  WaterPieces::Axes still_ = 0;  // along which nothing moves
  Obstacles* obstacles_;
  WaterPieces pieces_;
  std::unique_ptr<DensitySolver<T>> solver_;
};

}  // namespace trevi

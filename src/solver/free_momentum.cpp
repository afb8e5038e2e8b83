#include "solver/free_momentum.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "base/threads.hpp"
#include "boundary/obstacles/obstacles.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// The distance from a wall up to which its contribution to the density extends, in units of h; this is the largest
// value, at h = 1.2 spacings.
constexpr Real wall_reach = 1.25;

constexpr Real spread_unit = 16 * 16;  // h², of Σ p pᵀ
constexpr Real min_spread = 1e-6;      // h² per particle; less is rounding

}  // namespace

template <class T>
FreeMomentum<T>::FreeMomentum(const DensitySolverContext& context, std::unique_ptr<DensitySolver<T>> solver)
    : comm_(context.comm),
      grid_(context.grid),
      box_(context.box),
      interior_(context.box),
      h_(context.model.h),
      obstacles_(context.obstacles),
      solver_(std::move(solver)) {
  for (std::size_t a = 0; a < 3; ++a) {
    const int axis = grid_.axis(a);
    const bool repeats = grid_.is_periodic(a), is_still = axis == 1 && grid_.is_layer();
    const bool has_walls = !repeats && !is_still;
    if (is_still) still_ = 1U << static_cast<unsigned>(axis);
    const Real reach = !has_walls ? -INFINITY : wall_reach * h_;
    interior_.min[axis] += reach;
    interior_.max[axis] -= reach;
    turns_ = turns_ && !repeats;
  }
}

// A solid may push along any axis. Where solids do not contribute to the density, it is not known whether one is near.
template <class T>
WaterPieces::Axes FreeMomentum<T>::touched(const Vec3& p) const {
  unsigned axes = still_;
  for (int a = 0; a < 3; ++a)
    if (p[a] <= interior_.min[a] || p[a] >= interior_.max[a]) axes |= 1U << static_cast<unsigned>(a);
  if (axes != still_ && obstacles_ != nullptr && !obstacles_->has_density()) return WaterPieces::all_axes;
  if (axes != WaterPieces::all_axes && obstacles_ != nullptr && obstacles_->is_near_fixed(p))
    return WaterPieces::all_axes;
  return static_cast<WaterPieces::Axes>(axes);
}

template <class T>
FreeMomentum<T>::Sums::Sums(const std::int64_t* numbers)
    : count(static_cast<Real>(numbers[0])), near_floating(static_cast<Real>(numbers[4])) {
  for (unsigned a = 0; a < 3; ++a)
    if (numbers[1 + a] > 0) touched |= static_cast<WaterPieces::Axes>(1U << a);
  const std::int64_t* next = numbers + counts;
  const auto read = [&] {
    const Real sum = OrderlessSum::value(next);
    next += OrderlessSum::words;
    return sum;
  };
  for (Vec3* of : {&path, &p, &spin})
    for (Real& number : *of) number = read();
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) pp(a, b) = pp(b, a) = read() * spread_unit;
}

template <class T>
Vec3 FreeMomentum<T>::origin(std::size_t piece) const {
  const WaterPieces::Cell cell = pieces_.first_cell(piece);
  Vec3 middle = box_.min;
  for (std::size_t a = 0; a < 3; ++a) middle[grid_.axis(a)] += (cell[a] + 0.5) / grid_.per_length(a);
  return middle;
}

// Whether nothing pushes the piece along any axis.
template <class T>
bool FreeMomentum<T>::is_free(std::size_t piece) const {
  return pieces_.touched(piece) == still_;
}

// Sums over a run of cells, which belongs to one rank and one thread, are added in integers, whose order does not
// matter.
template <class T>
template <bool all, class Place, class Velocity>
typename FreeMomentum<T>::Words FreeMomentum<T>::sums_of(const DensityProblem<T>& problem, const Place& place,
                                                         const Velocity& velocity) const {
  const std::span<const WaterPieces::Run> runs = pieces_.runs();
  const bool has_bodies = obstacles_ != nullptr && obstacles_->floating() != nullptr;
  PerThread<Words> found;
  constexpr LocalId part_size = 16;
  for_each_part({0, static_cast<LocalId>(runs.size())}, part_size, [&](Range part) {
    Words& mine = found.mine();
    mine.resize(words * pieces_.count());
    for (auto n = static_cast<std::size_t>(part.begin); n < static_cast<std::size_t>(part.end); ++n) {
      const auto& [range, piece] = runs[n];
      std::int64_t* const to = mine.data() + words * piece;
      const Vec3 from = origin(piece);
      const bool turns = is_free(piece);
      Moments moments;
      for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
        const Vec3 there = place(i), way = velocity(i) * (problem.dt() / h_);
        moments.path += way;
        if (turns) moments.add_arm((there - from) / h_, way, all);
        if constexpr (all) {
          const WaterPieces::Axes axes = touched(there);
          for (unsigned a = 0; a < 3; ++a) to[1 + a] += axes >> a & 1U;
          to[4] += has_bodies && obstacles_->is_near(there) ? 1 : 0;
        }
      }
      to[0] += range.size();
      moments.add_to(to + counts, turns);
    }
  });
  Words total(words * pieces_.count(), 0);
  found.for_each([&](const Words& mine) {
    for (std::size_t k = 0; k < mine.size(); ++k) total[k] += mine[k];
  });
  return total;
}

template <class T>
void FreeMomentum<T>::Moments::add_arm(const Vec3& arm, const Vec3& way, bool spreads) {
  p += arm;
  spin += arm.cross(way);
  if (spreads) pp += arm * arm.transpose();
}

template <class T>
void FreeMomentum<T>::Moments::add_to(std::int64_t* next, bool turns) const {
  const auto add = [&](Real sum) {
    OrderlessSum::add(sum, next);
    next += OrderlessSum::words;
  };
  for (const Real number : path) add(number);
  if (!turns) return;
  for (const Vec3& of : {p, spin})
    for (const Real number : of) add(number);
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) add(pp(a, b) / spread_unit);
}

template <class T>
typename FreeMomentum<T>::Undoing FreeMomentum<T>::undoing(const Sums& before, const Sums& after,
                                                           WaterPieces::Axes touched) const {
  Undoing undoing;
  for (unsigned a = 0; a < 3; ++a) {
    if ((touched >> a & 1U) == 0) undoing.drift[a] = (after.path[a] - before.path[a]) / after.count;
  }
  undoing.centre = after.p / after.count;
  if (!turns_ || touched != still_) return undoing;
  undoing.off = (after.p - before.p) / after.count;
  const Eigen::Matrix3d spread = after.pp - after.count * undoing.centre * undoing.centre.transpose();
  const Eigen::Matrix3d inertia = spread.trace() * Eigen::Matrix3d::Identity() - spread;
  // A single particle or a line of particles has no inertia about some axis, and no rotation about it to correct.
  const Real size = inertia.trace();
  if (size > min_spread * after.count && inertia.determinant() > 1e-9 * size * size * size)
    undoing.turn = inertia.inverse() * (after.own_spin() - before.own_spin());
  return undoing;
}

// Adds the sums of other ranks for the pieces that lie on several ranks, which come first.
template <class T>
void FreeMomentum<T>::add_other_ranks(Words& before, Words& after) const {
  const auto shared = static_cast<std::ptrdiff_t>(words * pieces_.shared());
  if (shared == 0) return;
  Words both(before.begin(), before.begin() + shared);
  both.insert(both.end(), after.begin(), after.begin() + shared);
  both = sum_over_ranks(comm_, std::move(both));
  std::copy_n(both.begin(), shared, before.begin());
  std::copy_n(both.begin() + shared, shared, after.begin());
}

// What the pressure gave to the water beside surfaces belongs to the remainder of the forces on solids, not to any
// solid.
template <class T>
void FreeMomentum<T>::undo(DensityProblem<T>& problem, const std::vector<Undoing>& all) const {
  Particles& particles = problem.particles();
  const std::span<const WaterPieces::Run> runs = pieces_.runs();
  const Real to_velocity = h_ / problem.dt();
  constexpr LocalId part_size = 16;
  for_each_part({0, static_cast<LocalId>(runs.size())}, part_size, [&](Range part) {
    for (auto n = static_cast<std::size_t>(part.begin); n < static_cast<std::size_t>(part.end); ++n) {
      const auto& [range, piece] = runs[n];
      const Undoing& of = all[piece];
      if (of.is_nothing()) continue;
      const Vec3 from = origin(piece), off = of.off * h_;
      TotalImpulse undone;
      for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i) {
        const Vec3 arm = (particles.predicted[i] - from) / h_ - of.centre;
        const Vec3 by = of.drift + of.turn.cross(arm);
        particles.velocity[i] -= by * to_velocity;
        if (obstacles_ != nullptr) undone.moment -= obstacles_->about_middle(by * h_, particles.predicted[i]).moment;
        particles.predicted[i] -= off;
      }
      undone.shift = -range.size() * h_ * of.drift;
      if (obstacles_ != nullptr) obstacles_->record_rest(undone);
    }
  });
}

// Lets the pieces fly that touch nothing. Water aboard a body does not touch anything either, but it rests on the body.
template <class T>
void FreeMomentum<T>::let_fly(DensityProblem<T>& problem) const {
  if (obstacles_ != nullptr && obstacles_->floating() != nullptr) return;
  std::vector<Range> parts;
  for (const WaterPieces::Run& run : pieces_.runs())
    if (is_free(run.piece)) parts.push_back(run.particles);
  problem.let_fly(parts);
}

template <class T>
SolveResult FreeMomentum<T>::solve(DensityProblem<T>& problem) {
  Particles& particles = problem.particles();
  const bool any = pieces_.find(
      comm_, problem.order(), problem.scratch(), [&](std::size_t i) { return touched(particles.predicted[i]); },
      [&](WaterPieces::Labels& labels) { problem.exchange(labels); });
  if (!any) return solver_->solve(problem);
  let_fly(problem);
  Words before = sums_of<false>(
      problem, [&](std::size_t i) { return problem.end_of_flight(i); },
      [&, dt = problem.dt()](std::size_t i) { return Vec3((particles.predicted[i] - particles.position[i]) / dt); });
  const SolveResult result = solver_->solve(problem);
  Words after = sums_of<true>(
      problem, [&](std::size_t i) { return particles.predicted[i]; },
      [&](std::size_t i) { return particles.velocity[i]; });
  add_other_ranks(before, after);
  // A freely moving body receives the remainder of the transfer once it is touched.
  const bool is_body_touched = obstacles_ != nullptr && obstacles_->is_body_touched(comm_);
  std::vector<Undoing> all;
  for (std::size_t piece = 0; piece < pieces_.count(); ++piece) {
    const Sums first(before.data() + words * piece), last(after.data() + words * piece);
    const bool by_body = is_body_touched && last.near_floating > 0;
    const WaterPieces::Axes touched = by_body ? WaterPieces::all_axes : pieces_.touched(piece) | last.touched;
    all.push_back(undoing(first, last, touched));
  }
  undo(problem, all);
  return result;
}

template class FreeMomentum<float>;
template class FreeMomentum<double>;

}  // namespace trevi

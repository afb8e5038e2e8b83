#include "solver/density_problem.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/hash.hpp"
#include "domain/plane_sums.hpp"
#include "fluid/pairs/for_each_sum.hpp"
#include "fluid/pairs/particle_loops.hpp"

namespace trevi {

namespace {

struct CompressionSums {
  Real compression = 0, count = 0;
  template <class Visit>
  void for_each(const Visit& visit) {
    visit(compression), visit(count);
  }
};

// A direction for a pair of ids, uniformly distributed over the sphere, or over the circle in the plane of x and z: the
// first of a sequence of hashed points in a cube that lies in the inscribed ball. It has the same bits on any machine,
// unlike a result of sine and cosine.
Vec3 direction_of(GlobalId a, GlobalId b, int dimensions) {
  constexpr std::uint64_t next = 0x9E3779B97F4A7C15ull;
  constexpr Real half = 1U << 20U;
  const auto number = [](std::uint64_t bits) { return (static_cast<Real>(bits & 0x1FFFFFU) + 0.5) / half - 1; };
  for (std::uint64_t x = static_cast<std::uint64_t>(a) * next + static_cast<std::uint64_t>(b);; x += next) {
    const std::uint64_t bits = mix(x);
    const Vec3 v(number(bits), dimensions == 2 ? 0 : number(bits >> 21U), number(bits >> 42U));
    if (v.squaredNorm() <= 1) return v / std::sqrt(v.squaredNorm());
  }
}

}  // namespace

template <class T>
DensityProblem<T>::DensityProblem(MPI_Comm comm, Neighbourhood<T>& near, const DensityConstraint<T>& constraint,
                                  Boundary& boundary, const Vec3& gravity)
    : comm_(comm),
      near_(near),
      constraint_(constraint),
      boundary_(boundary),
      free_flight_(gravity, constraint.model().h, boundary) {}

template <class T>
void DensityProblem<T>::start(Particles& particles, Real dt, std::function<Real(std::size_t)> held) {
  particles_ = &particles;
  free_flight_.start(dt, std::move(held));
  dt_ = dt;
  positions_only_ = is_projected_ = false;
  if (boundary_.obstacles() != nullptr) boundary_.obstacles()->number_particles(particles.id.size());
}

template <class T>
void DensityProblem<T>::prepare() {
  Scratch& scratch = near_.scratch();
  const std::size_t particles = particles_->id.size();
  swept_.start(near_.order());
  swept_.find_moved_ghosts(near_.records());
  moved_rows_ = {near_.all()};
  rho_ = scratch.borrow<Real>(particles);
  multiplier_ = scratch.borrow<T>(particles);
  for_each_index(near_.all(), [of = multiplier_.data()](std::size_t i) { of[i] = 0; });
  if (!is_projected_) return field_.borrow(scratch, particles);
  act_ = scratch.borrow<T>(particles);
  in_flight_ = scratch.borrow<T>(particles);
  std::atomic<bool> flies = false;
  for_each_part(near_.all(), sums_chunk, [&, shifts = field_.shifts()](Range part) {
    bool may = false;  // without a branch
    for (auto i = static_cast<std::size_t>(part.begin); i < static_cast<std::size_t>(part.end); ++i) {
      act_[i] = shifts[i].w;
      in_flight_[i] = 0;
      may |= free_flight_.may_fly(shifts[i]);
    }
    if (may) flies.store(true, std::memory_order_relaxed);
  });
  if (flies) free_flight_.find(near_.all(), field_.shifts(), particles_->predicted, scratch);
}

template <class T>
void DensityProblem<T>::give_back() {
  for (Borrowed<Real>* array : {&rho_, &swept_rho_}) array->give_back();
  for (Borrowed<T>* array : {&multiplier_, &act_, &in_flight_}) array->give_back();
  free_flight_.give_back();
  field_.give_back();
}

template <class T>
void DensityProblem<T>::find_lambda(Range part, const UseLambda& use) {
  for_each_piece(part, moved_rows_, [&](Range piece, bool has_moved) {
    if (has_moved) {
      constraint_.lambdas(pairs(), piece, particles_->predicted, {{rho_.data(), rho_.size()}, field_, use});
      return count_pass(lambda_event(), piece, DensityConstraint<T>::density_flops);
    }
    constexpr std::array<T, sums_chunk> none{};
    for_each_part(piece, sums_chunk, [&](Range here) {
      field_.clear(here);
      use(here, none.data());
    });
  });
}

template <class T>
void DensityProblem<T>::set_multipliers(Range part) {
  if (part.size() == 0) return;
  for_each_index(part, [multiplier = multiplier_.data(), record = &near_.record(0)](std::size_t i) {
    record[i].w = multiplier[i];
  });
}

template <class T>
void DensityProblem<T>::count_pass(const Event& event, Range part, double flops_per_pair) {
  const auto pairs = static_cast<double>(near_.list().pairs(part));
  pair_passes_ += pairs;
  // In addition to the list, each particle has a record that is read, and a sum of four numbers that is written.
  constexpr double each = sizeof(Packed<T>) + 4 * sizeof(T);
  log_work(event, pairs * flops_per_pair, near_.list().bytes_read(part) + each * part.size());
}

// The artificial pressure also pushes particles without multipliers.
template <class T>
void DensityProblem<T>::find_swept_rows() {
  if (constraint_.is_tensile()) {
    swept_.move_all();
    swept_rows_ = {near_.all()};
  } else {
    swept_.find_multipliers(near_.records());
    swept_.move();
    swept_rows_ = swept_.with_multipliers(true);
  }
}

template <class T>
void DensityProblem<T>::find_delta(Range part) {
  for_each_piece(part, swept_rows_, [&](Range piece, bool is_swept) {
    if (!is_swept) return for_each_part(piece, sums_chunk, [&](Range here) { field_.clear(here); });
    constraint_.deltas(pairs(), piece, particles_->predicted, field_);
    count_pass(delta_event_, piece, DensityConstraint<T>::delta_flops);
  });
}

template <class T>
void DensityProblem<T>::finish_moves() {
  near_.finish_positions();
  swept_.find_moved_ghosts(near_.records());
  moved_rows_ = swept_.moved();
}

template <class T>
void DensityProblem<T>::compute_delta() {
  const ScopedEvent timed(delta_event_);
  if (positions_only_) note_sweep();
  find_swept_rows();
  find_delta(near_.all());
}

// Particles of the boundary may be moved once those in the cells next to them have their deltas, too.
template <class T>
void DensityProblem<T>::compute_delta_and_move(bool separate) {
  constexpr LocalId beside = 2;
  const CellWindow inner = near_.interior_window(beside);
  if (!near_.halo().has_neighbours() || inner.planes.size() == 0) {
    compute_delta();
    if (separate) separate_coincident();
    const std::vector<Range> moving = rows_to_move();
    return with_halo(Phase::move, [&](Range part) { move_rows(part, moving); });
  }
  if (positions_only_) note_sweep();
  find_swept_rows();
  const auto find = [&](const std::vector<Range>& parts, bool inside) {
    const ScopedEvent timed(delta_event_);
    for (const Range& part : parts) find_delta(part);
    if (separate) separate_coincident(inner, inside);
  };
  find(near_.boundary(beside), false);
  const auto move = [&](const std::vector<Range>& parts) {
    const std::vector<Range> moving = rows_to_move();
    for (const Range& part : parts) move_rows(part, moving);
  };
  move(near_.boundary());
  near_.start_positions();
  find(near_.interior(beside), true);
  const ScopedEvent timed(phase_event_[static_cast<std::size_t>(Phase::move)]);
  move(near_.interior());
  finish_moves();
}

// A particle inside a solid is moved out of it, whether its row is swept or not.
template <class T>
std::vector<Range> DensityProblem<T>::rows_to_move() const {
  return boundary_.obstacles() != nullptr ? std::vector<Range>{near_.all()} : swept_.moved();
}

template <class T>
void DensityProblem<T>::move_rows(Range part, const std::vector<Range>& moving) {
  for_each_piece(part, moving, [&](Range piece, bool moves) {
    if (moves) collide_and_move(piece);
  });
}

template <class T>
void DensityProblem<T>::collide_and_move(Range part, Real relaxation) {
  for_each_part(part, moved_at_once, [&](Range few) {
    const std::span<const Vec3> p(&particles_->predicted[static_cast<std::size_t>(few.begin)],
                                  static_cast<std::size_t>(few.size()));
    move_in(boundary_.open_space(p, Extent::shift, few.begin), few, relaxation);
  });
}

template <class T>
void DensityProblem<T>::move_in(const OpenSpace& open, Range few, Real relaxation) {
  const std::span<const Vec4<T>> shifts = field_.shifts();
  const auto first = static_cast<std::size_t>(few.begin);
  const std::span<Vec3> p(&particles_->predicted[first], static_cast<std::size_t>(few.size()));
  Packed<T>* const records = &near_.record(few.begin);
  std::array<LocalId, moved_at_once> left;
  const Shift<T> shift{open, boundary_.is_open_inside(), near_.encoding(), relaxation};
  const std::size_t count = move_particles<T>(shift, &shifts[first], {p, records}, left.data());
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(left[k]);
    const Vec3 before = p[i], way = vector_of(shifts[first + i]);
    p[i] = boundary_.collide(p[i], relaxation * way);
    if (const Vec3 straight = before + relaxation * way; p[i] != straight)
      note_collision(first + i, before, p[i] - straight);
    near_.encode(particles_->predicted, {few.begin + left[k], few.begin + left[k] + 1});
    if (way.isZero(0) && p[i] != before) swept_.move(few.begin + left[k]);  // out of a solid
  }
}

// The angular momentum of a shift that is changed by a solid is recorded about the position where the shift began,
// whereas the resulting velocity begins with the substep.
template <class T>
void DensityProblem<T>::note_collision(std::size_t i, const Vec3& began, const Vec3& change) const {
  Obstacles* const obstacles = boundary_.obstacles();
  if (obstacles == nullptr || !obstacles->records_impulses()) return;
  obstacles->record_rest({Vec3::Zero(), (particles_->position[i] - began).cross(change)});
}

template <class T>
void DensityProblem<T>::project(Projection& projection) {
  const Motion motion{particles_->position, particles_->predicted};
  const Loan velocities(near_.scratch(), std::as_writable_bytes(std::span(particles_->velocity)));
  projection.find(near_.order(), near_.halo(), dt_, motion);
  field_.borrow(near_.scratch(), particles_->id.size());
  projection.displacements<T>(near_.order(), dt_, motion, field_.shifts());
  is_projected_ = true;
}

template <class T>
void DensityProblem<T>::set_velocities(bool looks_later) {
  looks_later_ = looks_later;
  has_swept_ = false;
  if (looks_later_) swept_rho_ = near_.scratch().template borrow<Real>(rho_.size());
  std::vector<Vec3>&x = particles_->position, &p = particles_->predicted, &v = particles_->velocity;
  for_each_index(near_.all(), [&](std::size_t i) {
    v[i] = (p[i] - x[i]) / dt_;
    x[i] = p[i];
  });
  positions_only_ = true;
  if (boundary_.obstacles() != nullptr) boundary_.obstacles()->record_impulses(false);
}

template <class T>
void DensityProblem<T>::note_sweep() {
  has_swept_ = true;
  for_each_index(near_.all(), [&](std::size_t i) {
    in_flight_[i] += (1 - act_[i]) * multiplier_[i];
    if (looks_later_) swept_rho_[i] = rho_[i];
  });
}

template <class T>
void DensityProblem<T>::release_in_flight() {
  free_flight_.land(near_.all(), {in_flight_.data(), in_flight_.size()});
  with_halo(Phase::lambda, [&](Range part) {
    if (part.size() == 0) return;
    for_each_index(part, [in_flight = in_flight_.data(), record = &near_.record(0)](std::size_t i) {
      record[i].w = in_flight[i];
    });
  });
  in_flight_.give_back();
  multiplier_.give_back();
  const ScopedEvent timed(delta_event_);
  if (boundary_.obstacles() != nullptr) boundary_.obstacles()->record_impulses(true);
  swept_.find_multipliers(near_.records());
  for (const Range& part : swept_.with_multipliers(false)) {
    constraint_.deltas_in_flight(pairs(), part, particles_->predicted, particles_->velocity, dt_, field_);
    for_each_index(part, [&](std::size_t i) { particles_->velocity[i] += field_.shift(i) / dt_; });
    count_pass(delta_event_, part, DensityConstraint<T>::delta_flops);
  }
  if (boundary_.obstacles() != nullptr) boundary_.obstacles()->record_impulses(false);
}

template <class T>
void DensityProblem<T>::filter_shifts(Projection& projection) {
  const Borrowed<Real>& rho = looks_later_ && has_swept_ ? swept_rho_ : rho_;
  const Swept<T> swept{{particles_->position, particles_->predicted},
                       {act_.data(), act_.size()},
                       {{rho.data(), rho.size()}, constraint_.model().rest_density},
                       {swept_.find_near_shifts(), near_.order().rows()}};
  {
    const Loan records(near_.scratch(), std::as_writable_bytes(std::span(near_.records())));  // to be written anew
    projection.filter_shifts<T>(near_.order(), near_.halo(), swept, field_.shifts());
  }
  with_halo(Phase::move, [&](Range part) { collide_and_move(part); });
  projection.carry_velocities<T>(near_.order(), swept, dt_, particles_->velocity);
  free_flight_.lift(near_.all(), particles_->predicted);
  free_flight_.give_back();
  projection.give_back();
  act_.give_back();
  swept_rho_.give_back();
  field_.give_back();
  positions_only_ = false;
  if (boundary_.obstacles() != nullptr) boundary_.obstacles()->record_impulses(true);
}

// The two shifts are opposite, so that momentum is conserved. Coincident particles are in the same cell, up to
// rounding, so only pairs within a cell are tested. Later iterations push them further apart once the pair has a
// direction.
template <class T>
void DensityProblem<T>::separate_coincident(const CellWindow& window, bool inside) {
  if (near_.list().first_overfull_particle() >= 0)
    return;  // the test of all pairs in an overfull cell would take too long
  const std::vector<Vec3>& p = particles_->predicted;
  const Real h = constraint_.model().h, shift = 0.01 * h, coincident = 1e-6 * h * (1e-6 * h);
  const int dimensions = constraint_.model().kernels.density.dimensions;
  const auto part = [&](std::size_t i, std::size_t j) {
    const Vec3 away = shift * direction_of(particles_->id[i], particles_->id[j], dimensions);
    field_.add_to_shift(i, away);
    field_.add_to_shift(j, -away);
    swept_.move(static_cast<LocalId>(i));
  };
  const CellOrder& order = near_.order();
  const LocalId rows = order.rows(), columns = order.grid().columns();
  const auto is_in = [](LocalId i, const Range& range) { return i >= range.begin && i < range.end; };
  for_each_part(order.planes() * rows, [&](LocalId row) {
    if ((is_in(row / rows, window.planes) && is_in(row % rows, window.rows)) != inside) return;
    const LocalId k = row / rows + 1, first = row % rows * columns;
    for (LocalId c = first; c < first + columns; ++c) {
      const auto begin = static_cast<std::size_t>(order.start(k, c) - order.low_ghosts());
      const auto end = static_cast<std::size_t>(order.start(k, c + 1) - order.low_ghosts());
      if (end - begin < 2 || !may_coincide({p.data() + begin, end - begin}, coincident)) continue;  // nearly all
      for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t j = begin; j < i; ++j)
          if ((p[i] - p[j]).squaredNorm() < coincident) part(i, j);
      }
    }
  });
}

template <class T>
void DensityProblem<T>::compute_density() {
  const ScopedEvent timed(phase_event_[static_cast<std::size_t>(Phase::lambda)]);
  look_at_density();
  count_pass(lambda_event(), near_.all(), DensityConstraint<T>::value_flops);
}

template <class T>
void DensityProblem<T>::look_at_density() {
  constraint_.densities(pairs(), near_.all(), particles_->predicted, {rho_.data(), rho_.size()});
}

template <class T>
Compression DensityProblem<T>::compression() const {
  PerThread<Real> largest;
  const auto total = sum_over_planes<CompressionSums>(comm_, near_.order(), [&](CompressionSums& sums, Range range) {
    Real most = 0;
    for (LocalId i = range.begin; i < range.end; ++i) {
      const Real c = std::max(rho_[static_cast<std::size_t>(i)] / constraint_.model().rest_density - 1, 0.0);
      sums.compression += c;
      most = std::max(most, c);
    }
    sums.count += range.size();
    largest.mine() = std::max(largest.mine(), most);
  });
  Real most = 0;
  largest.for_each([&](Real one) { most = std::max(most, one); });
  return {total.count > 0 ? total.compression / total.count : 0, max_over_ranks(comm_, most)};
}

template class DensityProblem<float>;
template class DensityProblem<double>;

}  // namespace trevi

#include "solver/diagnostics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "base/threads.hpp"
#include "parallel/reductions.hpp"
#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// The numbers of a particle that are summed, and their index among the sums.
struct Number {
  static constexpr std::size_t density = 0, interior_density = 1, compression = 2, compression2 = 3, speed2 = 4;
  static constexpr std::size_t velocity = 5, place = 8, count = 11;  // vectors have three each
};
using Numbers = std::array<Real, Number::count>;

// A number is added as an integer multiple of a unit, which is such that the largest number has this many bits: beyond
// rounding.
constexpr int bits_of_largest = 50;
// For this many particles, the sum fits into an integer of 64 bits.
constexpr LocalId particles_of_part = 2048;
// The sums of parts are added in two integers: the bits above this number and those below it.
constexpr int low_bits = 32;

// A power of two as the unit for numbers up to `largest`. It is not so small that numbers in this unit become infinite.
Real unit_of(Real largest) {
  return std::ldexp(1, std::max(std::ilogb(std::max(largest, 1e-200)) + 1 - bits_of_largest, -900));
}

}  // namespace

// The unit of each number.
struct DiagnosticsSum::Units {
  Numbers of{};

  Units(const Diagnostics& largest, const Box& box) {
    const Real c = largest.compression_max, v = largest.speed_max;
    of[Number::density] = of[Number::interior_density] = unit_of(largest.density_max);
    of[Number::compression] = unit_of(c);
    of[Number::compression2] = unit_of(c * c);
    of[Number::speed2] = unit_of(v * v);
    std::fill_n(&of[Number::velocity], 3, unit_of(v));
    std::fill_n(&of[Number::place], 3, unit_of((box.max - box.min).maxCoeff()));
  }

  Numbers per_unit() const {
    Numbers per{};
    std::transform(of.begin(), of.end(), per.begin(), [](Real unit) { return 1 / unit; });
    return per;
  }
};

// The number of particles, the number of those in the interior, and the sum of each number in units.
struct DiagnosticsSum::Part {
  GlobalId count = 0, interior_count = 0;
  std::array<GlobalId, Number::count> sums{};
};

// The same for all particles.
struct DiagnosticsSum::Total {
  Real count = 0, interior_count = 0;
  Numbers sums{};

  Vec3 vector(std::size_t first) const { return {sums[first], sums[first + 1], sums[first + 2]}; }
};

DiagnosticsSum::DiagnosticsSum(MPI_Comm comm, const DensityModel& model, const Surroundings& around)
    : comm_(comm),
      box_(around.box),
      walls_(around.walls),
      model_(model),
      full_neighbourhood_(0.9 * around.lattice_neighbours),
      gravity_(around.gravity),
      water_mass_(around.water_mass) {}

bool DiagnosticsSum::interior(const Vec3& p, LocalId neighbours) const {
  return neighbours >= full_neighbourhood_ && ((p - walls_.min).array() > model_.h).all() &&
         ((walls_.max - p).array() > model_.h).all();
}

DiagnosticsSum::Part DiagnosticsSum::part_of(const DiagnosticsInput& input, Range range, const Units& units) const {
  Part part{range.size()};
  const auto per_unit = units.per_unit();
  // Rounded by a single instruction.
  const auto add = [&](std::size_t to, Real number) { part.sums[to] += std::llrint(number * per_unit[to]); };
  for (LocalId i = range.begin; i < range.end; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vec3 &p = input.particles.position[k], &v = input.particles.velocity[k];
    const Real rho = input.density[k], c = std::max(rho / model_.rest_density - 1, 0.0);
    add(Number::density, rho);
    add(Number::compression, c);
    add(Number::compression2, c * c);
    if (interior(p, input.list.count(i))) {
      ++part.interior_count;
      add(Number::interior_density, rho);
    }
    add(Number::speed2, v.squaredNorm());
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      add(Number::velocity + a, v[axis]);
      add(Number::place + a, p[axis] - box_.min[axis]);
    }
  }
  return part;
}

DiagnosticsSum::Total DiagnosticsSum::total_of(const DiagnosticsInput& input, const Diagnostics& largest) const {
  const Units units(largest, box_);
  PerThread<std::vector<GlobalId>> sums;
  sums.for_each([](auto& own) { own.assign(2 + 2 * Number::count, 0); });
  for_each_part({0, input.particles.size()}, particles_of_part, [&](Range range) {
    const Part part = part_of(input, range, units);
    std::vector<GlobalId>& own = sums.mine();
    own[0] += part.count;
    own[1] += part.interior_count;
    for (std::size_t n = 0; n < Number::count; ++n) {
      own[2 + 2 * n] += part.sums[n] >> low_bits;
      own[3 + 2 * n] += part.sums[n] & ((GlobalId{1} << low_bits) - 1);
    }
  });
  const std::vector<GlobalId> all = sum_over_threads_and_ranks(comm_, sums);
  Total total{static_cast<Real>(all[0]), static_cast<Real>(all[1]), {}};
  for (std::size_t n = 0; n < Number::count; ++n) {
    const Real high = std::ldexp(static_cast<Real>(all[2 + 2 * n]), low_bits), low = static_cast<Real>(all[3 + 2 * n]);
    total.sums[n] = (high + low) * units.of[n];
  }
  return total;
}

void DiagnosticsSum::add_maxima(const DiagnosticsInput& input, Diagnostics& row) const {
  constexpr Real lowest = -std::numeric_limits<Real>::infinity();
  const Particles& particles = input.particles;
  const Range all{0, particles.size()};
  const Real rho = largest(all, 0, [&](std::size_t i) { return input.density[i]; });
  const Real v2 = largest(all, 0, [&](std::size_t i) { return particles.velocity[i].squaredNorm(); });
  const Real top = largest(all, lowest, [&](std::size_t i) { return particles.position[i].z(); });
  const Real front = largest(all, lowest, [&](std::size_t i) { return particles.position[i].x(); });
  const Real work = plane_work(input.order, input.list, 0, input.order.planes());
  Real maxima[] = {rho, v2, top, front, input.drift, work};
  all_reduce(comm_, maxima, 6, MPI_DOUBLE, MPI_MAX);
  row.density_max = maxima[0];
  row.compression_max = std::max(maxima[0] / model_.rest_density - 1, 0.0);
  row.speed_max = std::sqrt(maxima[1]);
  const auto known = [&](Real place) { return place > lowest ? place : std::numeric_limits<Real>::quiet_NaN(); };
  row.top = known(maxima[2]);
  row.front = known(maxima[3]);
  row.drift_max = maxima[4];
  const auto all_work = static_cast<Real>(sum_over_ranks(comm_, static_cast<GlobalId>(work)));
  row.imbalance = all_work > 0 ? maxima[5] * size_of(comm_) / all_work : 1;
}

Diagnostics DiagnosticsSum::operator()(const DiagnosticsInput& input) const {
  Diagnostics row;
  add_maxima(input, row);
  const Total total = total_of(input, row);
  const Vec3 places = total.vector(Number::place);
  row.particles = static_cast<GlobalId>(total.count);
  row.density_mean = total.sums[Number::density] / total.count;
  row.density_interior =
      total.sums[Number::interior_density] / total.interior_count;  // 0/0 = nan where there is no interior
  row.compression_mean = total.sums[Number::compression] / total.count;
  row.compression_rms = std::sqrt(total.sums[Number::compression2] / total.count);
  row.kinetic_energy = water_mass_ / 2 * total.sums[Number::speed2];
  row.potential_energy = -water_mass_ * gravity_.dot(places);
  row.momentum = water_mass_ * total.vector(Number::velocity);
  row.com = box_.min + places / total.count;
  const auto q99 = static_cast<GlobalId>(std::ceil(0.99 * total.count));
  row.front_q99 = nth_smallest(comm_, input.particles.position, 0, q99, box_);
  return row;
}

Real nth_smallest(MPI_Comm comm, std::span<const Vec3> positions, int axis, GlobalId n, const Box& box) {
  constexpr int digit = 12, rounds = 3;  // 4096 intervals in each round
  constexpr GlobalId bins = GlobalId{1} << digit, cells = GlobalId{1} << (digit * rounds);
  if (n == 0) return std::numeric_limits<Real>::quiet_NaN();
  // Coordinates as integers, so that each round assigns a particle to the same interval as the previous round.
  const Real per_metre = static_cast<Real>(cells) / (box.max[axis] - box.min[axis]);
  const auto cell = [&](const Vec3& p) {
    return std::clamp<GlobalId>(static_cast<GlobalId>((p[axis] - box.min[axis]) * per_metre), 0, cells - 1);
  };
  GlobalId interval = 0;
  for (int round = 1; round <= rounds; ++round) {
    std::vector<GlobalId> count(bins, 0);
    PerThread<std::vector<GlobalId>> counts;
    counts.for_each([](auto& own) { own.assign(bins, 0); });
    constexpr LocalId part_size = 8192;
    for_each_part({0, static_cast<LocalId>(positions.size())}, part_size, [&](Range range) {
      std::vector<GlobalId>& own = counts.mine();
      for (LocalId i = range.begin; i < range.end; ++i) {
        const GlobalId part = cell(positions[static_cast<std::size_t>(i)]) >> (digit * (rounds - round));
        if (part >> digit == interval) ++own[static_cast<std::size_t>(part & (bins - 1))];
      }
    });
    counts.for_each(
        [&](const auto& own) { std::transform(own.begin(), own.end(), count.begin(), count.begin(), std::plus()); });
    all_reduce(comm, count.data(), static_cast<int>(bins), MPI_INT64_T, MPI_SUM);
    std::size_t bin = 0;
    while (bin + 1 < static_cast<std::size_t>(bins) && n > count[bin]) n -= count[bin++];  // n: from this interval on
    interval = interval * bins + static_cast<GlobalId>(bin);
  }
  return box.min[axis] + (static_cast<Real>(interval) + 0.5) / per_metre;
}

void DriftMeter::begin(Scratch& scratch, const std::vector<Vec3>& predicted) {
  start_ = scratch.borrow<Vec3>(predicted.size());
  for_each_index({0, static_cast<LocalId>(predicted.size())}, [&](std::size_t i) { start_[i] = predicted[i]; });
}

void DriftMeter::end(const std::vector<Vec3>& predicted) {
  const Range all{0, static_cast<LocalId>(start_.size())};
  largest_ = trevi::largest(all, 0, [&](std::size_t i) { return (predicted[i] - start_[i]).norm(); });
  start_.give_back();
}

}  // namespace trevi

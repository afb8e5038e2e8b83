#include "solver/diagnostics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/threads.hpp"
#include "domain/plane_sums.hpp"
#include "parallel/waiting.hpp"
#include "trevi/session.hpp"

namespace trevi {

// The sums over one plane.
struct DiagnosticsSum::Plane {
  Real count = 0, rho = 0, compression = 0, compression2 = 0, interior_count = 0, interior_rho = 0;
  Real v2 = 0, height = 0;
  Vec3 momentum = Vec3::Zero(), position = Vec3::Zero();

  template <class Visit>
  void for_each(const Visit& visit) {
    for (Real* sum : {&count, &rho, &compression, &compression2, &interior_count, &interior_rho, &v2, &height})
      visit(*sum);
    for (Real& sum : momentum) visit(sum);
    for (Real& sum : position) visit(sum);
  }
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

void DiagnosticsSum::add(const DiagnosticsInput& input, Range range, Plane& sum) const {
  for (LocalId i = range.begin; i < range.end; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vec3 &p = input.particles.position[k], &v = input.particles.velocity[k];
    const Real rho = input.density[k], c = std::max(rho / model_.rest_density - 1, 0.0);
    sum.count += 1;
    sum.rho += rho;
    sum.compression += c;
    sum.compression2 += c * c;
    if (interior(p, input.list.count(i))) {
      sum.interior_count += 1;
      sum.interior_rho += rho;
    }
    sum.v2 += v.squaredNorm();
    sum.height -= gravity_.dot(p - box_.min);
    sum.momentum += v;
    sum.position += p;
  }
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
  const auto sum =
      sum_over_planes<Plane>(comm_, input.order, [&](Plane& plane, Range range) { add(input, range, plane); });
  Diagnostics row;
  row.particles = static_cast<GlobalId>(sum.count);
  row.density_mean = sum.rho / sum.count;
  row.density_interior = sum.interior_rho / sum.interior_count;  // 0/0, nan, where there is no interior
  row.compression_mean = sum.compression / sum.count;
  row.compression_rms = std::sqrt(sum.compression2 / sum.count);
  row.kinetic_energy = water_mass_ / 2 * sum.v2;
  row.potential_energy = water_mass_ * sum.height;
  row.momentum = water_mass_ * sum.momentum;
  row.com = sum.position / sum.count;
  add_maxima(input, row);
  const auto q99 = static_cast<GlobalId>(std::ceil(0.99 * sum.count));
  row.front_q99 = nth_smallest(comm_, input.particles.position, 0, q99, box_);
  return row;
}

Real nth_smallest(MPI_Comm comm, std::span<const Vec3> positions, int axis, GlobalId n, const Box& box) {
  constexpr int digit = 12, rounds = 3;  // 4096 intervals in each round
  constexpr GlobalId bins = GlobalId{1} << digit, cells = GlobalId{1} << (digit * rounds);
  if (n == 0) return std::numeric_limits<Real>::quiet_NaN();
  // Coordinates as integers, so that each round counts a particle in the same interval as the round before.
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

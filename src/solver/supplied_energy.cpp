#include "solver/supplied_energy.hpp"

#include <cmath>

#include "base/threads.hpp"
#include "parallel/waiting.hpp"

namespace trevi {

namespace {

constexpr Real highest = 1e12;  // m²/s², for speeds that no run survives

}  // namespace

// The sums may wrap around; their differences are correct nevertheless.
std::int64_t SuppliedEnergy::units(const Particles& particles, const Vec3& more) const {
  PerThread<std::uint64_t> sums;
  constexpr LocalId part_size = 2048;
  for_each_part({0, particles.size()}, part_size, [&](Range part) {
    std::uint64_t sum = 0;
    for (LocalId i = part.begin; i < part.end; ++i) {
      const auto n = static_cast<std::size_t>(i);
      const Real energy =
          (particles.velocity[n] - more).squaredNorm() / 2 - gravity_.dot(particles.position[n] - corner_);
      if (std::abs(energy) < highest) sum += static_cast<std::uint64_t>(std::llround(energy / unit));
    }
    sums.mine() += sum;
  });
  std::uint64_t all = 0;
  sums.for_each([&](std::uint64_t sum) { all += sum; });
  return static_cast<std::int64_t>(all);
}

void SuppliedEnergy::measure(const Particles& particles, const std::function<void()>& work, Real ago) {
  const Vec3 more = ago * gravity_;
  const std::int64_t before = units(particles, more);
  work();
  measured_ += units(particles, more) - before;
}

void SuppliedEnergy::end_step() {
  all_reduce(comm_, &measured_, 1, MPI_INT64_T, MPI_SUM);
  joules_ += mass_ * unit * static_cast<Real>(measured_);
  measured_ = 0;
}

}  // namespace trevi

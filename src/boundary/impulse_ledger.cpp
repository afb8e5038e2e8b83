#include "boundary/impulse_ledger.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

// Limited, in units, to far more than any distance that a solver would let a particle travel; a number in any case.
Real countable(Real units) {
  constexpr Real most = 0x1p55;
  return std::max(-most, std::min(most, units));
}

}  // namespace

ImpulseLedger::ImpulseLedger(std::size_t accounts, Real h)
    : columns_(numbers * accounts),
      unit_(std::ldexp(h, -34)),
      arm_(h),
      per_shift_(1 / unit_),
      per_moment_(1 / (unit_ * arm_)) {
  clear();
}

void ImpulseLedger::clear() {
  sums_.for_each([&](auto& sums) { sums.assign(columns_, 0); });
}

// Rounded by a single instruction, unlike std::llround(); a scene with obstacles does this for everything at a wall.
void ImpulseLedger::count(const Vec3& shift, const Vec3& moment, std::int64_t* sums) const {
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    sums[a] += std::llrint(countable(shift[axis] * per_shift_));
    sums[a + 3] += std::llrint(countable(moment[axis] * per_moment_));
  }
}

void ImpulseLedger::add(std::size_t account, std::span<const Impulse> impulses) {
  std::array<std::int64_t, numbers> sums{};
  for (const auto& [shift, arm] : impulses) {
    const Vec3 moment(arm.y() * shift.z() - arm.z() * shift.y(), arm.z() * shift.x() - arm.x() * shift.z(),
                      arm.x() * shift.y() - arm.y() * shift.x());
    count(shift, moment, sums.data());
  }
  std::int64_t* const all = sums_.mine().data() + numbers * account;
  for (std::size_t k = 0; k < numbers; ++k) all[k] += sums[k];
}

void ImpulseLedger::add(std::size_t account, const TotalImpulse& impulse) {
  count(impulse.shift, impulse.moment, sums_.mine().data() + numbers * account);
}

std::vector<TotalImpulse> ImpulseLedger::total(MPI_Comm comm) {
  const std::vector<std::int64_t> all = sum_over_threads_and_ranks(comm, sums_);
  std::vector<TotalImpulse> taken(columns_ / numbers);
  for (std::size_t k = 0; k < taken.size(); ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      taken[k].shift[axis] = static_cast<Real>(all[numbers * k + a]) * unit_;
      taken[k].moment[axis] = static_cast<Real>(all[numbers * k + a + 3]) * unit_ * arm_;
    }
  }
  return taken;
}

}  // namespace trevi

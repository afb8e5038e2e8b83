#include "fluid/obstacles/toll.hpp"

#include <cmath>

#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr std::size_t numbers = 6;  // of a taker

}  // namespace

Toll::Toll(std::size_t takers, Real h) : columns_(numbers * takers), unit_(std::ldexp(h, -34)), arm_(h) { clear(); }

void Toll::clear() {
  sums_.for_each([&](auto& sums) { sums.assign(columns_, 0); });
}

void Toll::add(std::size_t taker, const Vec3& shift, const Vec3& arm) {
  std::int64_t* sums = sums_.mine().data() + numbers * taker;
  const Vec3 moment(arm.y() * shift.z() - arm.z() * shift.y(), arm.z() * shift.x() - arm.x() * shift.z(),
                    arm.x() * shift.y() - arm.y() * shift.x());
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    sums[a] += std::llround(shift[axis] / unit_);
    sums[a + 3] += std::llround(moment[axis] / (unit_ * arm_));
  }
}

std::vector<Taken> Toll::total(MPI_Comm comm) {
  const std::vector<std::int64_t> all = sum_over_threads_and_ranks(comm, sums_);
  std::vector<Taken> taken(columns_ / numbers);
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

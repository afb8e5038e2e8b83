#include "boundary/volume_map/plane_volume.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

constexpr int steps = 1024;

}  // namespace

// V(d) = 2 pi ∫_d^h W(r) r (r − d) dr, by Simpson's rule from step to step: with A = ∫ W r dr and B = ∫ W r² dr from d
// to h it is B − d A, up to a factor, which V(0) = ½ gives.
PlaneVolume::PlaneVolume(const Kernel& kernel, Real h) : h_(h), share_(steps + 1, 0.0) {
  const Real step = h / steps;
  const auto w = [&](Real r) { return kernel.value(Vec3(r, 0, 0), h); };
  Real a = 0, b = 0;
  for (int k = steps; k-- > 0;) {
    const Real low = k * step, mid = low + step / 2, high = low + step;
    a += step / 6 * (w(low) * low + 4 * w(mid) * mid + w(high) * high);
    b += step / 6 * (w(low) * low * low + 4 * w(mid) * mid * mid + w(high) * high * high);
    share_[static_cast<std::size_t>(k)] = b - low * a;
  }
  const Real per = 0.5 / share_.front();
  for (Real& share : share_) share *= per;
}

Real PlaneVolume::share(Real distance) const {
  if (distance < 0) return 1 - share(-distance);
  const Real x = distance / h_ * steps;
  if (!(x < steps)) return 0;
  const auto k = static_cast<std::size_t>(x);
  return share_[k] + (x - static_cast<Real>(k)) * (share_[k + 1] - share_[k]);
}

Real PlaneVolume::distance(Real share) const {
  if (share > 0.5) return -distance(1 - share);
  if (!(share > 0)) return h_;
  const auto above = std::upper_bound(share_.rbegin(), share_.rend(), share);  // the first share that is larger
  if (above == share_.rend()) return 0;
  const auto k = static_cast<std::size_t>(share_.rend() - above) - 1;
  const Real part = (share_[k] - share) / (share_[k] - share_[k + 1]);
  return (static_cast<Real>(k) + part) * h_ / steps;
}

}  // namespace trevi

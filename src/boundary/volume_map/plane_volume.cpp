#include "boundary/volume_map/plane_volume.hpp"

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

constexpr int steps = 1024;

// V(d) = 2 pi ∫_d^h W(r) r (r − d) dr, by Simpson's rule from step to step: with A = ∫ W r dr and B = ∫ W r² dr from d
// to h it is B − d A, up to a factor.
void sum_ball(const Kernel& kernel, Real h, std::vector<Real>& fraction) {
  const Real step = h / steps;
  const auto w = [&](Real r) { return kernel.value(Vec3(r, 0, 0), h); };
  Real a = 0, b = 0;
  for (int k = steps; k-- > 0;) {
    const Real low = k * step, mid = low + step / 2, high = low + step;
    a += step / 6 * (w(low) * low + 4 * w(mid) * mid + w(high) * high);
    b += step / 6 * (w(low) * low * low + 4 * w(mid) * mid * mid + w(high) * high * high);
    fraction[static_cast<std::size_t>(k)] = b - low * a;
  }
}

// The integral of the kernel along a line in the plane at distance z from its centre, up to a factor, by Simpson's
// rule.
Real along_line(const Kernel& kernel, Real h, Real z) {
  constexpr int parts = 64;
  const Real end = std::sqrt(std::max(h * h - z * z, 0.0)), part = end / parts;
  const auto w = [&](Real x) { return kernel.value(Vec3(x, 0, z), h); };
  Real sum = 0;
  for (int k = 0; k < parts; ++k) sum += w(k * part) + 4 * w((k + 0.5) * part) + w((k + 1) * part);
  return sum * part;
}

// V(d) = ∫_d^h of the integral of the kernel along the line at that distance.
void sum_disc(const Kernel& kernel, Real h, std::vector<Real>& fraction) {
  const Real step = h / steps;
  Real sum = 0, above = along_line(kernel, h, h);
  for (int k = steps; k-- > 0;) {
    const Real below = along_line(kernel, h, k * step);
    sum += below + 4 * along_line(kernel, h, (k + 0.5) * step) + above;
    fraction[static_cast<std::size_t>(k)] = sum;
    above = below;
  }
}

}  // namespace

// V(0) = ½ determines the factor.
PlaneVolume::PlaneVolume(const Kernel& kernel, Real h) : h_(h), fraction_(steps + 1, 0.0) {
  kernel.dimensions == 2 ? sum_disc(kernel, h, fraction_) : sum_ball(kernel, h, fraction_);
  const Real per = 0.5 / fraction_.front();
  for (Real& fraction : fraction_) fraction *= per;
}

Real PlaneVolume::fraction(Real distance) const {
  if (distance < 0) return 1 - fraction(-distance);
  const Real x = distance / h_ * steps;
  if (!(x < steps)) return 0;
  const auto k = static_cast<std::size_t>(x);
  return fraction_[k] + (x - static_cast<Real>(k)) * (fraction_[k + 1] - fraction_[k]);
}

Real PlaneVolume::distance(Real fraction) const {
  if (fraction > 0.5) return -distance(1 - fraction);
  if (!(fraction > 0)) return h_;
  const auto above =
      std::upper_bound(fraction_.rbegin(), fraction_.rend(), fraction);  // the first fraction that is larger
  if (above == fraction_.rend()) return 0;
  const auto k = static_cast<std::size_t>(fraction_.rend() - above) - 1;
  const Real part = (fraction_[k] - fraction) / (fraction_[k] - fraction_[k + 1]);
  return (static_cast<Real>(k) + part) * h_ / steps;
}

}  // namespace trevi

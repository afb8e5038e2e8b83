#include "boundary/waves/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trevi::elementary {

namespace {

// ln 2 as a sum of two numbers, the first with so few digits that its multiples are exact.
constexpr Real ln2_high = 0x1.62e42feep-1, ln2_low = 0x1.a39ef35793c76p-33;

}  // namespace

// By Taylor series, after powers of two have been taken out, for |r| up to ln 2 / 2, where the omitted terms are below
// 1e-17.
Real exp(Real x) {
  constexpr Real largest = 700;
  if (x < -largest) return 0;
  x = std::min(x, largest);
  const Real n = std::floor(x / std::numbers::ln2 + 0.5);
  const Real r = (x - n * ln2_high) - n * ln2_low;
  Real sum = 1;
  for (int k = 14; k >= 1; --k) sum = 1 + sum * r / k;
  return std::ldexp(sum, static_cast<int>(n));
}

// By the series of the inverse hyperbolic tangent, for arguments between sqrt(1/2) and sqrt(2).
Real log(Real x) {
  int n = 0;
  Real m = std::frexp(x, &n);
  if (m < std::numbers::sqrt2 / 2) {
    m *= 2;
    --n;
  }
  const Real s = (m - 1) / (m + 1), y = s * s;
  Real sum = 0;
  for (int k = 25; k >= 1; k -= 2) sum = 1.0 / k + y * sum;
  return n * ln2_high + (n * ln2_low + 2 * s * sum);
}

}  // namespace trevi::elementary

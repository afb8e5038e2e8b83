// A sum that does not depend on the order of its terms: integers in two limbs, in units of 2^-16 and 2^-50. For terms
// that each have the same bits on any number of ranks and threads. Not collective; the words of a sum on several ranks
// are added as integers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "trevi/types.hpp"

namespace trevi {

class OrderlessSum {
 public:
  static constexpr std::size_t words = 2;

  /// Accurate to 2^-51; for up to 2^30 terms below 2^16 on average. A term larger than 2^40 counts as 2^40.
  static void add(Real term, std::int64_t* sum) {
    constexpr Real most = 0x1p40;
    const Real countable = std::max(-most, std::min(most, term));
    const std::int64_t coarse = std::llrint(countable * 0x1p16);
    sum[0] += coarse;
    sum[1] += std::llrint((countable - static_cast<Real>(coarse) * 0x1p-16) * 0x1p50);
  }
  static Real value(const std::int64_t* sum) {
    return static_cast<Real>(sum[0]) * 0x1p-16 + static_cast<Real>(sum[1]) * 0x1p-50;
  }
};

}  // namespace trevi

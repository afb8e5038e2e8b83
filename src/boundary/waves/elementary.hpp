// Exponential, logarithm and hyperbolic functions by additions, multiplications and divisions alone, to 1e-14: the same
// bits on any processor and with any version of the C library, whose own functions do not guarantee this. Not
// collective.
#pragma once

#include "trevi/types.hpp"

namespace trevi::elementary {

/// e^x; 0 below −700, and at most e^700.
Real exp(Real x);
/// Natural logarithm of a positive number that is not denormal.
Real log(Real x);

inline Real sinh(Real x) { return (exp(x) - exp(-x)) / 2; }
inline Real cosh(Real x) { return (exp(x) + exp(-x)) / 2; }
inline Real tanh(Real x) {
  const Real e = exp(-2 * (x < 0 ? -x : x));
  return (x < 0 ? -1 : 1) * (1 - e) / (1 + e);
}

}  // namespace trevi::elementary

// Helpers with which make_solver() refuses settings. All comparisons are written such that a NaN fails. Not collective.
#pragma once

#include <cmath>
#include <string>

#include "trevi/error.hpp"
#include "trevi/types.hpp"

namespace trevi {

/// Throws an InputError that names the member of the settings and its rule, unless the rule holds.
inline void demand(bool holds, const std::string& rule) {
  if (!holds) throw InputError("settings of the solver: " + rule);
}

inline bool is_positive(Real x) { return x > 0 && std::isfinite(x); }
inline bool is_amount(Real x) { return x >= 0 && std::isfinite(x); }
inline bool is_direction(const Vec3& v) { return v.allFinite() && !v.isZero(0); }

}  // namespace trevi

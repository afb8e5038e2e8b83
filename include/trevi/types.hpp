// The few types that every layer shares.
// Lengths are metres, times seconds, masses kilograms; the state of a particle is kept in double precision.
// LocalId counts what one rank holds, GlobalId what all ranks hold together; the two are never mixed silently.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace trevi {

using Real = double;
using Vec3 = Eigen::Vector3d;
using LocalId = std::int32_t;
using GlobalId = std::int64_t;

}  // namespace trevi

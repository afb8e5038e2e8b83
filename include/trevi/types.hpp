// The few types that all modules share.
// Lengths are in metres, times in seconds and masses in kilograms; the state of a particle is in double precision.
// LocalId counts what one rank holds, and GlobalId what all ranks hold together; the two are never mixed silently.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace trevi {

using Real = double;
using Vec3 = Eigen::Vector3d;
using LocalId = std::int32_t;
using GlobalId = std::int64_t;

}  // namespace trevi

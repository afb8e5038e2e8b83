// Triangles on the surfaces of the analytic shapes, for pictures only: the sine and cosine of the C library are good
// enough, because no bit of a run depends on them. Not collective.
#pragma once

#include <utility>
#include <vector>

#include "trevi/box.hpp"
#include "trevi/obstacle.hpp"

namespace trevi {

/// Points (distance from the axis, z), with the outer side of the surface on the right of the segment from each point
/// to the next. A closed profile ends where it begins.
using Profile = std::vector<std::pair<Real, Real>>;

/// A half circle from the lower end of the axis to the upper one, with its halves `apart` above and below z = 0.
Profile arc(Real radius, Real apart, Real size, Real finest);
/// A circle at the distance `radius` from the axis.
Profile ring(Real radius, Real tube, Real finest);
/// The surface that a profile sweeps when it is rotated about z.
TriangleMesh turned(const Profile& profile, Real finest);
TriangleMesh cuboid_surface(const Vec3& half);
/// The surface of a box without a lid: its outer hull, and half the size of the space in it.
TriangleMesh basin_surface(const Box& outer, const Vec3& half);

}  // namespace trevi

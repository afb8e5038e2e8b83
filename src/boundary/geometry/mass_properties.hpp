// Volume, centre of mass and inertia of a solid of density 1, in the frame of its shape: in closed form, or for a mesh
// by sums over the tetrahedra of its triangles (Mirtich, Fast and accurate computation of polyhedral mass properties,
// J. Graph. Tools 1, 1996; Eberly, Polyhedral mass properties, 2002). Not collective.
#pragma once

#include "trevi/obstacle.hpp"

namespace trevi {

struct MassProperties {
  Real volume = 0;                                    ///< m³
  Vec3 center = Vec3::Zero();                         ///< m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< m⁵, about the centre
};

/// For the solid of an obstacle that is not a vessel; a mesh has been read and faces outwards.
MassProperties mass_properties(const ObstacleSettings& obstacle);

}  // namespace trevi

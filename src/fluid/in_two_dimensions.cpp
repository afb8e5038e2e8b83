#include "fluid/in_two_dimensions.hpp"

#include <cmath>

namespace trevi {

void lay_in_plane(ObstacleSettings& obstacle, const FluidSettings& fluid) {
  if (fluid.dimensions != 2) return;
  obstacle.extruded = true;
  obstacle.center.y() = 0;
  for (ObstacleKnot& knot : obstacle.knots) knot.center.y() = 0;
  if (!obstacle.size.isZero()) obstacle.size.y() = fluid.spacing;
  if (obstacle.shape == ShapeKind::cylinder) obstacle.height = fluid.spacing;
}

void lay_in_plane(BodySettings& body, const FluidSettings& fluid) {
  if (fluid.dimensions != 2) return;
  lay_in_plane(static_cast<ObstacleSettings&>(body), fluid);
  for (const std::size_t across : {1U, 3U, 5U}) body.free[across] = false;  // y, roll, yaw
  if (!body.mooring) return;
  body.mooring->anchor.y() = 0;
  if (body.mooring->point) body.mooring->point->y() = 0;
}

// Water flows through a slot. The horizontal edge of a rectangle lies along x where the water flows straight up or
// down, and along y otherwise (fluid/forcings/inlet.cpp).
void lay_in_plane(InletSettings& inlet, const FluidSettings& fluid) {
  if (fluid.dimensions != 2) return;
  inlet.center.y() = 0;
  const bool upright = std::abs(inlet.direction.x()) <= 1e-9 * inlet.direction.norm();
  if (inlet.shape == InletShape::disc) {
    inlet.shape = InletShape::rectangle;
    inlet.size[0] = inlet.size[1] = 2 * inlet.radius;
  }
  inlet.size[upright ? 1 : 0] = fluid.spacing;
}

void lay_in_plane(DrainSettings& drain, const FluidSettings& fluid) {
  if (fluid.dimensions != 2) return;
  drain.center.y() = 0;
  drain.min.y() = -fluid.spacing / 2;
  drain.max.y() = fluid.spacing / 2;
}

void lay_in_plane(DampingSettings& zone, const FluidSettings& fluid) {
  if (fluid.dimensions != 2) return;
  zone.min.y() = -fluid.spacing / 2;
  zone.max.y() = fluid.spacing / 2;
}

// The rectangle of a flow gauge is a slot, like that of an inlet.
void lay_in_plane(GaugeSettings& gauge, const FluidSettings& fluid) {
  if (fluid.dimensions != 2) return;
  gauge.center.y() = 0;
  if (gauge.kind != GaugeKind::flow) return;
  const bool upright = std::abs(gauge.normal.x()) <= 1e-9 * gauge.normal.norm();
  gauge.size[upright ? 1 : 0] = fluid.spacing;
}

void lay_in_plane(FrameSetSettings& frames, const FluidSettings& fluid) {
  if (fluid.dimensions != 2 || !frames.box) return;
  frames.box->min.y() = -fluid.spacing / 2;
  frames.box->max.y() = fluid.spacing / 2;
}

void lay_in_plane(Settings& settings) {
  if (settings.fluid.dimensions != 2) return;
  const Real spacing = settings.fluid.spacing;
  settings.domain.min.y() = -spacing / 2;
  settings.domain.max.y() = spacing / 2;
  for (ObstacleSettings& obstacle : settings.obstacles) lay_in_plane(obstacle, settings.fluid);
  for (BodySettings& body : settings.bodies) lay_in_plane(body, settings.fluid);
  for (FountainSettings& fountain : settings.fountains) fountain.center[1] = 0;
  for (InletSettings& inlet : settings.inlets) lay_in_plane(inlet, settings.fluid);
  for (DrainSettings& drain : settings.drains) lay_in_plane(drain, settings.fluid);
  for (DampingSettings& zone : settings.dampings) lay_in_plane(zone, settings.fluid);
  for (GaugeSettings& gauge : settings.gauges) lay_in_plane(gauge, settings.fluid);
  for (FrameSetSettings& frames : settings.output.frames) lay_in_plane(frames, settings.fluid);
}

std::string why_not_along_plane(const Vec3& vector) {
  return vector.y() == 0 ? "" : "must be 0 along y in two dimensions; give [x, z], or [x, 0, z]";
}

std::string why_not_about_y(const Vec3& rotation) {
  return rotation.x() == 0 && rotation.z() == 0 ? "" : "must be about y in two dimensions; give [0, y, 0]";
}

std::string why_not_in_plane(const ObstacleSettings& obstacle) {
  using enum ShapeKind;
  switch (obstacle.shape) {
    case box:
      return "";
    case cylinder:
      if (obstacle.axis.x() == 0 && obstacle.axis.z() == 0) return "";
      return "a cylinder has its axis along y in two dimensions; leave axis out, or take a box";
    case basin:
      if (!obstacle.size.isZero()) return "";
      return "a basin is a box in two dimensions; give size in place of radius and height";
    default:
      return "in two dimensions an obstacle goes on along y: a cylinder, a box or a basin that is a box; for a ball "
             "take "
             "type = \"cylinder\"";
  }
}

}  // namespace trevi

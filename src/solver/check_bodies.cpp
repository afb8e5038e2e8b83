#include "solver/check_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "boundary/geometry/mass_properties.hpp"
#include "boundary/geometry/pose.hpp"
#include "boundary/geometry/shape.hpp"
#include "boundary/geometry/surface_points.hpp"
#include "boundary/rigid_bodies/rigid_body.hpp"

namespace trevi {

namespace {

Box place_of(const ObstacleSettings& solid) {
  const Box bounds = bounds_of(solid);
  const Pose pose = BodyMotion(solid).at(0);
  const Vec3 middle = pose.into_world((bounds.max + bounds.min) / 2);
  const Vec3 half = pose.turn.cwiseAbs() * (bounds.max - bounds.min) / 2;
  return {middle - half, middle + half};
}

std::string why_no_mass(const BodySettings& body) {
  if (body.density.has_value() == body.mass.has_value()) return "needs a density or a mass, and only one of them";
  const Real given = body.density ? *body.density : *body.mass;
  if (!(given > 0) || !std::isfinite(given)) return "has a density or a mass that is not positive; give one that is";
  return "";
}

// With the energy of such a body, rounding would leave nothing of that of the water.
std::string why_too_heavy(const Settings& settings, const BodySettings& body) {
  constexpr Real most = 1e6;  // of the mass of the water that it displaces
  const Real volume = mass_properties(body).volume, water = settings.fluid.rest_density * volume;
  const Real mass = body.mass ? *body.mass : *body.density * volume;
  if (mass <= most * water) return "";
  return fmt::format(
      "has a mass of {:.3g} kg, more than a million times the {:.3g} kg of its water; check the units of {}", mass,
      water, body.mass ? "mass" : "density");
}

// Water that bounces off a body lighter than this throws it at more than its own speed, in steps that see the impact
// only once.
std::string why_too_light(const Settings& settings, const BodySettings& body) {
  const Real mass = body.mass ? *body.mass : *body.density * mass_properties(body).volume;
  const Real particle = settings.fluid.rest_density * std::pow(settings.fluid.spacing, 3);
  if (mass >= particle) return "";
  return fmt::format(
      "has a mass of {:.3g} kg, less than a particle of water with {:.3g} kg, which would throw it about; make it "
      "larger "
      "or denser, or lower fluid.spacing",
      mass, particle);
}

std::string why_no_start(const Settings& settings, const BodySettings& body) {
  const Box place = place_of(body);
  constexpr Real rounding = 1e-9;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<Eigen::Index>(a);
    if (!body.free[a] && body.velocity[b] != 0) return "has a velocity along an axis along which it is not free";
    if (!body.free[a + 3] && body.angular_velocity[b] != 0)
      return "has an angular velocity about an axis about which it is not free";
    if (body.free[a] && (place.min[b] < settings.domain.min[b] - rounding * settings.fluid.spacing ||
                         place.max[b] > settings.domain.max[b] + rounding * settings.fluid.spacing))
      return fmt::format(
          "reaches from {0} = {1:.6g} to {2:.6g} m, out of the box from {3:.6g} to {4:.6g} m; move it inside, or leave "
          "\"{0}\" out of free",
          "xyz"[a], place.min[b], place.max[b], settings.domain.min[b], settings.domain.max[b]);
  }
  return "";
}

// In the water a spring is integrated in steps with the force at their start, in the air in half steps with the forces
// at both ends: both are stable up to twice the inverse of its frequency.
std::string why_no_mooring(const Settings& settings, const BodySettings& body) {
  if (!body.mooring) return "";
  const Mooring& mooring = *body.mooring;
  const auto is_amount = [](Real x) { return x >= 0 && std::isfinite(x); };
  if (!mooring.anchor.allFinite() || (mooring.point && !mooring.point->allFinite()) || !is_amount(mooring.stiffness) ||
      !is_amount(mooring.damping) || !is_amount(mooring.length.value_or(0)))
    return "has a mooring with a place that is not finite, or a negative stiffness, damping or length";
  const RigidBody start(body, *make_shape(body), Vec3::Zero(), settings.fluid.rest_density);
  const Real mass = start.mass_at_mooring();
  const Real max_stiffness = mass / (settings.dt * settings.dt), max_damping = mass / settings.dt;
  if (!(mooring.stiffness <= max_stiffness && mooring.damping <= max_damping))
    return fmt::format(
        "has a mooring too stiff for the {:.3g} kg that its end moves with, and steps of {:.3g} s; lower stiffness to "
        "{:.3g} N/m, damping to {:.3g} N s/m, or dt, or fix it nearer to the centre of mass",
        mass, settings.dt, max_stiffness, max_damping);
  constexpr Real fastest = 1e4;  // m/s, as for everything that moves in a scene
  const Real distance = (mooring.point.value_or(start.state().position) - mooring.anchor).norm();
  const Real longer = distance - mooring.length.value_or(distance);
  const Real pull = mooring.stiffness * (mooring.slack ? std::max(longer, 0.0) : std::abs(longer));
  if (!(pull * settings.dt <= fastest * mass && std::isfinite(distance)))
    return fmt::format(
        "has a mooring whose anchor is {:.3g} m away, for a length of {:.3g} m, which throws the {:.3g} kg that its "
        "end moves with at more than {:g} m/s in a step; check its anchor, point and length",
        distance, mooring.length.value_or(distance), mass, fastest);
  return "";
}

// The first of the points that are more than `depth` inside a solid, in world coordinates.
std::optional<Vec3> first_within(const std::vector<Vec3>& points, const Pose& pose, const Shape& solid, const Pose& at,
                                 Real depth) {
  for (const Vec3& point : points) {
    const Vec3 p = pose.into_world(point);
    if (solid.distance(at.into_body(p)) < -depth) return p;
  }
  return std::nullopt;
}

// The corners of a solid, and a point inside it, because all corners of an identical solid in the same place are on its
// surface.
std::vector<Vec3> corners_of(const Shape& shape, Real finest) {
  std::vector<Vec3> points = shape.surface(finest).points;
  if (shape.distance(Vec3::Zero()) < 0) points.push_back(Vec3::Zero());
  return points;
}

// Faces and edges of a body may cross another solid although no corner of either is inside the other.
std::vector<Vec3> all_over(const Shape& shape, Real spacing) {
  constexpr Real parts = 100;  // of a large body
  const Real size = (shape.bounds().max - shape.bounds().min).maxCoeff();
  std::vector<Vec3> points = points_of(shape.surface(spacing / 50), std::max(spacing / 4, size / parts));
  if (shape.distance(Vec3::Zero()) < 0) points.push_back(Vec3::Zero());
  return points;
}

std::string why_in_another(const Settings& settings, std::size_t k) {
  const ObstacleSettings& one = settings.bodies[k];
  const auto shape = make_shape(one);
  const Pose pose = BodyMotion(one).at(0);
  const Real spacing = settings.fluid.spacing, depth = 0.05 * spacing;
  const std::vector<Vec3> points = all_over(*shape, spacing);
  Real radius = 0;
  for (const Vec3& point : points) radius = std::max(radius, point.norm());
  const std::vector<ObstacleSettings> all = solids_of(settings);
  for (std::size_t other = 0; other < all.size(); ++other) {
    if (other == settings.obstacles.size() + k) continue;
    const auto there = make_shape(all[other]);
    const Pose at = BodyMotion(all[other]).at(0);
    if (there->distance(at.into_body(pose.center)) > radius) continue;
    std::optional<Vec3> place = first_within(points, pose, *there, at, depth);
    if (!place && !all[other].inside) place = first_within(corners_of(*there, spacing / 50), at, *shape, pose, depth);
    if (!place) continue;
    const bool is_body = other >= settings.obstacles.size();
    return fmt::format("reaches into {} {} at ({:.4g}, {:.4g}, {:.4g}) m; move one of them",
                       is_body ? "body" : "obstacle", is_body ? other - settings.obstacles.size() : other, place->x(),
                       place->y(), place->z());
  }
  return "";
}

}  // namespace

std::string why_no_body(const Settings& settings, std::size_t k) {
  const BodySettings& body = settings.bodies[k];
  if (body.inside) return "is a vessel, which cannot move freely; take a basin";
  if (!body.motion.empty() || !body.knots.empty() || body.oscillation) return "has a motion of its own";
  if (body.free == std::array<bool, 6>{}) {
    return settings.fluid.dimensions == 2
               ? "is free to do nothing in the plane; give it x, z or pitch, or make an obstacle of it"
               : "is free to do nothing; make an obstacle of it";
  }
  if (std::string wrong = why_no_mass(body); !wrong.empty()) return wrong;
  if (std::string wrong = why_no_start(settings, body); !wrong.empty()) return wrong;
  if (std::string wrong = why_no_mooring(settings, body); !wrong.empty()) return wrong;
  if (std::string wrong = why_in_another(settings, k); !wrong.empty()) return wrong;
  if (std::string wrong = why_too_heavy(settings, body); !wrong.empty()) return wrong;
  return why_too_light(settings, body);
}

}  // namespace trevi

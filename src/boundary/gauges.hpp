// Gauges of the water. A gauge takes the mean over a disc, with a weight that falls to 0 at its edge, so that no
// particle enters or leaves it with a jump. Only the part that is open to the water counts as the disc: for a gauge at
// the foot of a wall, the half above the floor. The pressure on a wall or an obstacle is the momentum that these take
// from the water there, per time and area (see ImpulseLedger): by the multipliers of the density constraint,
// collisions, and the pressure of the coarse grid. Sums are integers, so that they depend neither on the order of the
// particles nor on the number of ranks or threads. add() may be called in loops that threads share. Collective:
// total().
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "base/threads.hpp"
#include "kernels/kernels.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// Horizontal; m.
struct Box2 {
  Real min_x, min_y, max_x, max_y;
};

/// The weight at a distance from the axis of the gauge, 1/m²; its integral over the disc is 1.
Real gauge_weight(Real distance2, Real radius);
/// The same in two dimensions, where the disc is a segment of this half length in a layer one spacing thick.
Real gauge_weight_in_layer(Real distance2, Real radius, Real spacing);

/// The integral of the weight over the part of a rectangle that is in the disc; m from the centre of the gauge. Exact.
Real gauge_weight_of(const Box2& rectangle, Real radius);
/// The same in two dimensions, where the rectangle is as wide as the layer.
Real gauge_weight_in_layer_of(const Box2& rectangle, Real radius);

/// What a gauge sees of a particle in a periodic box: the particle and its images beyond the ends of periodic axes.
class SeenFrom {
 public:
  /// The gauge sees as far as `reach` along each axis, m.
  SeenFrom(const Vec3& place, const Vec3& reach, const Settings& settings);
  /// Calls see(d) for each image of p, with the vector d from the place of the gauge to the image.
  template <class See>
  void for_each(const Vec3& p, const See& see) const {
    Vec3 nearest = p - place_;
    for (Eigen::Index a = 0; a < 3; ++a) nearest[a] -= length_[a] * std::round(nearest[a] * lengths_per_metre_[a]);
    for (const Vec3& one : images_) see(Vec3(nearest + one));
  }

 private:
  Vec3 place_, length_ = Vec3::Zero(), lengths_per_metre_ = Vec3::Zero();  // 0 along axes that are not periodic
  std::vector<Vec3> images_;                                               // displacements from the nearest image
};

/// Whether a place is in an obstacle.
using IsSolid = std::function<bool(const Vec3&)>;

/// The weight, at most 1, of the part of the disc that counts. Height: the part inside the box, which has no end along
/// periodic axes. Pressure: the part with open space a quarter of a spacing in front of it and a wall or an obstacle at
/// the same distance behind it, so that surfaces may be curved.
Real open_fraction_of_gauge(const GaugeSettings& gauge, const PointLattice& lattice, const Box& box,
                            const IsSolid& is_solid, const std::array<bool, 3>& periodic = {});

class PressureGauges {
 public:
  /// The pressure gauges of the scene.
  PressureGauges(const Settings& settings, const IsSolid& is_solid);

  /// To be called when a wall or an obstacle shifts a particle at p.
  void add(const Vec3& shift, const Vec3& p) {
    for (std::size_t k = 0; k < gauges_.size(); ++k) add_to(k, shift, p);
  }
  /// Adds a pressure in the form in which the coarse grid has it, m²: over the density, times the square of the
  /// substep.
  void add_phi(std::size_t gauge, Real phi);

  std::size_t count() const { return gauges_.size(); }
  const GaugeSettings& gauge(std::size_t k) const { return gauges_[k]; }

  /// In the order of the gauges, since clear(), m² as for add_phi().
  std::vector<Real> total(MPI_Comm comm);
  void clear();

 private:
  void add_to(std::size_t k, const Vec3& shift, const Vec3& p);

  std::vector<GaugeSettings> gauges_;
  std::vector<SeenFrom> seen_;
  std::vector<Real> volume_;  // of a particle, m³, over the fraction of the disc
  Real spacing_, h_, unit_;   // m, m, m²
  bool in_layer_;             // two dimensions
  PerThread<std::vector<std::int64_t>> sums_;
};

}  // namespace trevi

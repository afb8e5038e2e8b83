// Gauges of the water. A gauge takes the mean over a disc, with a weight that falls to 0 at its edge, so that no
// particle enters or leaves it with a jump. Only what is open to the water counts as the disc: of a gauge at the foot
// of a wall the half above the floor. The pressure on a wall or an obstacle is what these take of the water's momentum
// there, a time and an area (see ImpulseLedger): the multipliers of the density constraint, collisions, and the
// pressure of the coarse grid. Sums are integers, so that no order of the particles, and no number of ranks or threads,
// is seen in them. add() may be called in loops that threads share. Collective: total().
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

/// Level; m.
struct Box2 {
  Real min_x, min_y, max_x, max_y;
};

/// At a distance from the axis of the gauge, 1/m²; its integral over the disc is 1.
Real gauge_weight(Real distance2, Real radius);
/// The same in two dimensions, where the disc is a segment of that half length in a layer as thick as a spacing.
Real gauge_weight_in_layer(Real distance2, Real radius, Real spacing);

/// The integral of the weight over a rectangle as far as that is in the disc, from the centre of the gauge in m. Exact.
Real gauge_weight_of(const Box2& rectangle, Real radius);
/// The same in two dimensions, where the rectangle is as wide as the layer.
Real gauge_weight_in_layer_of(const Box2& rectangle, Real radius);

/// What a gauge sees of a particle in a box that repeats: it, and its images beyond the ends of periodic axes.
class SeenFrom {
 public:
  /// As far as `reach` along each axis, m.
  SeenFrom(const Vec3& place, const Vec3& reach, const Settings& settings);
  /// see(way) of each image of p, from the place to it.
  template <class See>
  void for_each(const Vec3& p, const See& see) const {
    Vec3 nearest = p - place_;
    for (Eigen::Index a = 0; a < 3; ++a) nearest[a] -= length_[a] * std::round(nearest[a] * lengths_per_metre_[a]);
    for (const Vec3& one : images_) see(Vec3(nearest + one));
  }

 private:
  Vec3 place_, length_ = Vec3::Zero(), lengths_per_metre_ = Vec3::Zero();  // 0 where nothing repeats
  std::vector<Vec3> images_;                                               // from the nearest one
};

/// Whether a place is in an obstacle.
using IsSolid = std::function<bool(const Vec3&)>;

/// The weight, at most 1, of the part of the disc that counts. Height: what is in the box, which has no end along
/// periodic axes. Pressure: what has open space a quarter of a spacing before it, and a wall or an obstacle as far
/// behind it, so that surfaces may be curved.
Real open_fraction_of_gauge(const GaugeSettings& gauge, const PointLattice& lattice, const Box& box,
                            const IsSolid& is_solid, const std::array<bool, 3>& periodic = {});

class PressureGauges {
 public:
  /// Those of pressure of the scene.
  PressureGauges(const Settings& settings, const IsSolid& is_solid);

  /// A wall or an obstacle shifts a particle at p.
  void add(const Vec3& shift, const Vec3& p) {
    for (std::size_t k = 0; k < gauges_.size(); ++k) add_to(k, shift, p);
  }
  /// A pressure as the coarse grid counts it, m²: over the density, times the time of the substep squared.
  void add_phi(std::size_t gauge, Real phi);

  std::size_t count() const { return gauges_.size(); }
  const GaugeSettings& gauge(std::size_t k) const { return gauges_[k]; }

  /// In the order of the gauges, since clear(), m² as add_phi() has them.
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

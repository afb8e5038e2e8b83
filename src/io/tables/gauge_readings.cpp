#include "io/tables/gauge_readings.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "boundary/gauges.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

bool is_pressure(const GaugeSettings& gauge) {
  return gauge.kind == GaugeKind::pressure || gauge.kind == GaugeKind::pressure_in_water;
}

// Sums are integers, so that they do not depend on the order of the particles.
Real unit_of_height(Real spacing) { return std::ldexp(spacing, -32); }
Real unit_of_flow(Real spacing) { return std::ldexp(spacing * spacing, -36); }  // m³/s
constexpr Real unit_of_velocity = 0x1p-30;                                      // of 1 m/s, and of a weight

// For a velocity gauge: the number of particles; the ten sums of w x_a x_b, a <= b, with x = (1, offset in radii); the
// twelve of w x_a v_b.
constexpr std::size_t count_of_moments = 1 + 10 + 12;

// `way`: from the centre of the gauge.
void add_velocity(const GaugeSettings& gauge, const Vec3& way, const Vec3& v, std::int64_t* sums) {
  const Vec3 from = way / gauge.radius;
  const Real weight = 1 - from.squaredNorm();
  if (!(weight > 0)) return;
  const std::array<Real, 4> x{1, from.x(), from.y(), from.z()};
  *sums++ += 1;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = a; b < 4; ++b) *sums++ += std::llround(weight * x[a] * x[b] / unit_of_velocity);
  for (std::size_t a = 0; a < 4; ++a)
    for (Eigen::Index b = 0; b < 3; ++b) *sums++ += std::llround(weight * x[a] * v[b] / unit_of_velocity);
}

// The best-fitting linear field at the centre; the mean if no such field can be determined there.
Vec3 velocity_from(const std::int64_t* sums, bool in_layer) {
  const std::int64_t count = *sums++;
  if (count == 0) return Vec3::Constant(NAN);
  Eigen::Matrix4d moments;
  Eigen::Matrix<Real, 4, 3> velocities;
  for (Eigen::Index a = 0; a < 4; ++a)
    for (Eigen::Index b = a; b < 4; ++b) moments(a, b) = moments(b, a) = static_cast<Real>(*sums++);
  for (Eigen::Index a = 0; a < 4; ++a)
    for (Eigen::Index b = 0; b < 3; ++b) velocities(a, b) = static_cast<Real>(*sums++);
  if (moments(0, 0) == 0) return Vec3::Constant(NAN);
  if (in_layer) moments(2, 2) = moments(0, 0);  // there is no slope along y in the plane
  constexpr Real far = 0.25, flat = 1e-3;
  constexpr std::int64_t enough = 8;
  const Vec3 middle = moments.block<3, 1>(1, 0) / moments(0, 0);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> spread(moments / moments(0, 0));
  if (count < enough || middle.norm() > far || spread.eigenvalues()[0] < flat)
    return velocities.row(0).transpose() / moments(0, 0);
  return moments.ldlt().solve(velocities).row(0).transpose();
}

// The box, which is infinite along periodic axes.
Box walls_of(const Settings& settings) {
  Box walls = settings.domain;
  for (Eigen::Index a = 0; a < 3; ++a) {
    if (!settings.periodic[static_cast<std::size_t>(a)]) continue;
    walls.min[a] = -INFINITY;
    walls.max[a] = INFINITY;
  }
  return walls;
}

// For gauges of height, at the start: whether there is a solid below the foot, and none above.
std::vector<char> stand_on_solids(const std::vector<GaugeSettings>& gauges, const Settings& settings) {
  std::vector<char> stand(gauges.size(), 0);
  const Vec3 way = settings.fluid.spacing / 4 * Vec3::UnitZ();
  std::vector<char> above(gauges.size(), 0);
  for (const ObstacleSettings& obstacle : settings.obstacles) {
    const std::unique_ptr<Shape> shape = make_shape(obstacle);
    const Pose pose = BodyMotion(obstacle).at(0);
    for (std::size_t g = 0; g < gauges.size(); ++g) {
      if (gauges[g].kind != GaugeKind::height) continue;
      if (shape->distance(pose.into_body(gauges[g].center - way)) < 0) stand[g] = 1;
      if (shape->distance(pose.into_body(gauges[g].center + way)) < 0) above[g] = 1;
    }
  }
  for (std::size_t g = 0; g < gauges.size(); ++g) stand[g] = stand[g] != 0 && above[g] == 0 ? 1 : 0;
  return stand;
}

}  // namespace

GaugeReadings::GaugeReadings(MPI_Comm comm, const Settings& settings)
    : comm_(comm),
      gauges_(settings.gauges),
      first_{0},
      spacing_(settings.fluid.spacing),
      walls_(walls_of(settings)),
      middles_{walls_.min.array() + spacing_ / 2, walls_.max.array() - spacing_ / 2},
      in_layer_(settings.fluid.dimensions == 2),
      pressures_(std::any_of(gauges_.begin(), gauges_.end(), is_pressure)),
      stands_on_solid_(stand_on_solids(gauges_, settings)) {
  std::optional<StandingSolids> solids;
  for (const GaugeSettings& gauge : gauges_) {
    first_.push_back(first_.back() + (gauge.kind == GaugeKind::velocity ? count_of_moments : 1));
    seen_.emplace_back(gauge.center, Vec3::Constant(gauge.radius + spacing_ / 2), settings);
    open_.emplace_back();
    if (gauge.kind == GaugeKind::height) {
      if (!solids) solids.emplace(settings);
      open_.back().emplace(gauge, *solids, settings);
    }
    run_ups_.emplace_back(gauge, settings);
    flows_.emplace_back(gauge, settings);
  }
}

// Each particle is a cube of one spacing that lies in the box, and above a solid on which the gauge stands; it is cut
// at the foot. This measures the same as a wetted wire: air in the water does not count. A gauge on the floor would
// miss a part of particles nearer to it than half a spacing, and crests press more of them there: waves were 2.4 % too
// low. Along walls the weight of the disc is its mean over the spacing next to them: where the cubes are within this
// spacing says little about the water.
void GaugeReadings::add_height(std::size_t g, const Vec3& from, std::int64_t& sum) const {
  const Real half = spacing_ / 2, reach = gauges_[g].radius + half + spacing_;
  if (std::abs(from.x()) >= reach || std::abs(from.y()) >= reach) return;
  const bool lies_on_solid = stands_on_solid_[g] && from.z() > -spacing_ / 4;
  const Real above = lies_on_solid ? 1 : std::clamp(from.z() / spacing_ + 0.5, 0.0, 1.0);
  if (above == 0) return;
  const Real weight = weight_of_cube(g, from);
  if (weight == 0) return;
  const Real height = gauges_[g].center.z() + from.z() + half - above * spacing_ / 2;  // of what counts
  sum += std::llround(above * spacing_ * weight / open_[g]->at(height) / unit_of_height(spacing_));
}

Real GaugeReadings::weight_of_cube(std::size_t g, const Vec3& from) const {
  const GaugeSettings& gauge = gauges_[g];
  const std::array<SharesAlong, 2> shares{shares_along(0, from, gauge), shares_along(1, from, gauge)};
  Real sum = 0;
  for (const Share& x : shares[0]) {
    if (x.share == 0) continue;
    if (in_layer_) {
      sum += x.share * gauge_weight_in_layer_of({x.low, 0, x.high, 0}, gauge.radius);
      continue;
    }
    for (const Share& y : shares[1])
      if (y.share != 0) sum += x.share * y.share * gauge_weight_of({x.low, y.low, x.high, y.high}, gauge.radius);
  }
  return sum;
}

// What is next to a wall, at either end, is evenly distributed over the spacing there; the rest is where it is.
GaugeReadings::SharesAlong GaugeReadings::shares_along(Eigen::Index axis, const Vec3& from,
                                                       const GaugeSettings& gauge) const {
  const Real low = from[axis] - spacing_ / 2, high = from[axis] + spacing_ / 2;
  const Real first = walls_.min[axis] - gauge.center[axis], last = walls_.max[axis] - gauge.center[axis];
  const Real thick = std::min(spacing_, (last - first) / 2);
  SharesAlong shares{Share{first, first + thick, 0},
                     Share{std::max(low, first + thick), std::min(high, last - thick), 0},
                     Share{last - thick, last, 0}};
  shares[0].share = std::max(0.0, std::min(high, first + thick) - low) / thick;
  shares[1].share = shares[1].low < shares[1].high ? 1 : 0;
  shares[2].share = std::max(0.0, high - std::max(low, last - thick)) / thick;
  return shares;
}

void GaugeReadings::add(std::size_t g, const Particles& particles, Range part, std::vector<std::int64_t>& sums) const {
  if (is_pressure(gauges_[g]) || gauges_[g].kind == GaugeKind::run_up) return;
  std::int64_t& first = sums[first_[g]];
  for (auto i = static_cast<std::size_t>(part.begin); i < static_cast<std::size_t>(part.end); ++i) {
    const Vec3 &p = particles.position[i], &v = particles.velocity[i];
    const auto middle = [&]() -> Vec3 { return p.cwiseMax(middles_.min).cwiseMin(middles_.max); };
    switch (gauges_[g].kind) {
      case GaugeKind::height:
        seen_[g].for_each(middle(), [&](const Vec3& from) { add_height(g, from, first); });
        break;
      case GaugeKind::velocity:
        seen_[g].for_each(p, [&](const Vec3& from) { add_velocity(gauges_[g], from, v, &first); });
        break;
      case GaugeKind::flow:
        first += std::llround(flows_[g].flow(middle(), v) / unit_of_flow(spacing_));
        break;
      default:
        break;
    }
  }
}

std::vector<std::int64_t> GaugeReadings::sums(const Particles& particles) {
  sums_.for_each([&](auto& sums) { sums.assign(first_.back(), 0); });
  constexpr LocalId part_size = 4096;
  for_each_part({0, static_cast<LocalId>(particles.size())}, part_size, [&](Range part) {
    for (std::size_t g = 0; g < gauges_.size(); ++g) add(g, particles, part, sums_.mine());
  });
  return sum_over_threads_and_ranks(comm_, sums_);
}

// The largest value over all particles of all ranks; nan without any.
Real GaugeReadings::run_up(std::size_t g, const Particles& particles) const {
  PerThread<Real> of_threads;
  of_threads.for_each([](Real& highest) { highest = -INFINITY; });
  constexpr LocalId part_size = 4096;
  for_each_part({0, particles.size()}, part_size, [&](Range part) {
    Real& highest = of_threads.mine();
    for (auto i = static_cast<std::size_t>(part.begin); i < static_cast<std::size_t>(part.end); ++i) {
      const Vec3& p = particles.position[i];
      if (run_ups_[g].height(p) > highest && run_ups_[g].touches(p)) highest = run_ups_[g].height(p);
    }
  });
  Real highest = -INFINITY;
  of_threads.for_each([&](Real one) { highest = std::max(highest, one); });
  highest = max_over_ranks(comm_, highest);
  return std::isfinite(highest) ? highest : NAN;
}

std::vector<std::string> GaugeReadings::columns() const {
  std::vector<std::string> columns;
  for (std::size_t k = 0; k < gauges_.size(); ++k) {
    switch (gauges_[k].kind) {
      case GaugeKind::height:
        columns.push_back(fmt::format("height_{}", k));
        break;
      case GaugeKind::pressure:
      case GaugeKind::pressure_in_water:
        columns.push_back(fmt::format("pressure_{}", k));
        break;
      case GaugeKind::flow:
        columns.push_back(fmt::format("flow_{}", k));
        break;
      case GaugeKind::run_up:
        columns.push_back(fmt::format("run_up_{}", k));
        break;
      case GaugeKind::velocity:
        for (const char* axis : {"u", "v", "w"}) columns.push_back(fmt::format("{}_{}", axis, k));
        break;
    }
  }
  return columns;
}

std::vector<Real> GaugeReadings::read(const Frame& frame) {
  const std::vector<std::int64_t> all = sums(frame.particles);
  auto pressure = frame.pressures.begin(), probe = frame.probes.begin();
  std::vector<Real> values;
  for (std::size_t k = 0; k < gauges_.size(); ++k) {
    const auto sum = static_cast<Real>(all[first_[k]]);
    const GaugeKind kind = gauges_[k].kind;
    if (kind == GaugeKind::height) values.push_back(sum * unit_of_height(spacing_));
    if (kind == GaugeKind::flow) values.push_back(sum * unit_of_flow(spacing_));
    if (kind == GaugeKind::run_up) values.push_back(run_up(k, frame.particles));
    if (kind == GaugeKind::pressure) {
      require(pressure != frame.pressures.end(), "gauges: no pressures in this frame");
      values.push_back(*pressure++);
    }
    if (kind == GaugeKind::pressure_in_water) {
      require(probe != frame.probes.end(), "gauges: no pressures in this frame");
      values.push_back(*probe++);
    }
    if (kind == GaugeKind::velocity) {
      const Vec3 velocity = velocity_from(&all[first_[k]], in_layer_);
      values.insert(values.end(), velocity.begin(), velocity.end());
    }
  }
  return values;
}

}  // namespace trevi

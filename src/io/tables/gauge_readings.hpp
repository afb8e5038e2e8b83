// The readings of the gauges of a scene: heights, velocities, flows and run-ups from the particles, pressures from the
// frame. Sums are integers, so that they depend neither on the order of the particles nor on the number of ranks or
// threads. Collective: read().
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/threads.hpp"
#include "boundary/standing_solids.hpp"
#include "io/tables/flow_and_run_up.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"
#include "trevi/settings.hpp"

namespace trevi {

class GaugeReadings {
 public:
  /// The gauges of these settings.
  GaugeReadings(MPI_Comm comm, const Settings& settings);

  /// Names as in postprocess/README.md, and their values: m, Pa, m/s and m³/s.
  std::vector<std::string> columns() const;
  std::vector<Real> read(const Frame& frame);
  /// Whether there are gauges of pressure, which need a frame with pressures.
  bool wants_pressures() const { return pressures_; }

 private:
  std::vector<std::int64_t> sums(const Particles& particles);
  void add(std::size_t g, const Particles& particles, Range part, std::vector<std::int64_t>& sums) const;
  Real run_up(std::size_t g, const Particles& particles) const;
  // For a particle whose centre is at `from` relative to the centre of the gauge.
  void add_height(std::size_t g, const Vec3& from, std::int64_t& sum) const;
  Real weight_of_cube(std::size_t g, const Vec3& from) const;
  // The share of a cube that is evenly distributed from `low` to `high`, m from the centre of the gauge; 0: none.
  struct Share {
    Real low, high, share;
  };
  using SharesAlong = std::array<Share, 3>;
  SharesAlong shares_along(Eigen::Index axis, const Vec3& from, const GaugeSettings& gauge) const;

  MPI_Comm comm_;
  std::vector<GaugeSettings> gauges_;
  std::vector<std::size_t> first_;  // of the sums of each gauge; one more at the end
  Real spacing_;                    // m, the edge of a particle's cube
  Box walls_;                       // infinite along periodic axes
  Box middles_;                     // where the centre of a cube may be
  bool in_layer_;                   // two dimensions
  bool pressures_;
  std::vector<RunUp> run_ups_;
  std::vector<RectangleFlow> flows_;
  std::vector<SeenFrom> seen_;
  std::vector<std::optional<OpenDisc>> open_;  // of gauges of height
  std::vector<char> stands_on_solid_;          // whether a gauge of height does
  PerThread<std::vector<std::int64_t>> sums_;
};

}  // namespace trevi

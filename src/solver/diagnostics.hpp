// The row of series.csv. Sums are formed in integers whose units depend on the largest values of all particles, so that
// every column except imbalance and wall_seconds has the same bits on any rank count. Definitions:
// postprocess/README.md; SI units. Collective. An interior particle is more than h from every wall and has at least 90
// % of the neighbours of a lattice point.
#pragma once

#include "domain/balance.hpp"
#include "fluid/constraint/density.hpp"
#include "particles/neighbour_list.hpp"
#include "trevi/box.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// The input of a row: all owned particles, in the frozen order.
struct DiagnosticsInput {
  const Particles& particles;
  std::span<const Real> density;  ///< kg/m³
  Real drift = 0;                 ///< longest displacement of an owned particle since the list was built, m
  const CellOrder& order;
  const NeighbourList& list;
};

class DiagnosticsSum {
 public:
  /// `walls`: their positions, which are far away along periodic axes; `lattice_neighbours`: number of neighbours of an
  /// interior point of the initial lattice; `gravity` in m/s²; `water_mass`: mass of water that a particle represents,
  /// kg.
  struct Surroundings {
    Box box, walls;
    int lattice_neighbours;
    Vec3 gravity;
    Real water_mass;
  };
  DiagnosticsSum(MPI_Comm comm, const DensityModel& model, const Surroundings& around);

  /// All columns except iterations and wall_seconds.
  Diagnostics operator()(const DiagnosticsInput& input) const;

 private:
  struct Part;
  struct Total;
  struct Units;
  Part part_of(const DiagnosticsInput& input, Range range, const Units& units) const;
  Total total_of(const DiagnosticsInput& input, const Diagnostics& largest) const;
  bool interior(const Vec3& p, LocalId neighbours) const;
  void add_maxima(const DiagnosticsInput& input, Diagnostics& row) const;

  MPI_Comm comm_;
  Box box_, walls_;
  DensityModel model_;
  Real full_neighbourhood_;
  Vec3 gravity_;
  Real water_mass_;
};

/// The largest distance by which p* of an owned particle moves between begin() and end(), while the neighbour list is
/// unchanged; 0 without a begin().
class DriftMeter {
 public:
  void begin(Scratch& scratch, const std::vector<Vec3>& predicted);
  void end(const std::vector<Vec3>& predicted);
  Real largest() const { return largest_; }  ///< m

 private:
  Borrowed<Vec3> start_;
  Real largest_ = 0;
};

/// The n-th smallest (from 1) of the coordinates along `axis` of the positions on all ranks, to 1e-10 of the box, in
/// three rounds of counting and without sorting. nan if n is 0. Collective.
Real nth_smallest(MPI_Comm comm, std::span<const Vec3> positions, int axis, GlobalId n, const Box& box);

}  // namespace trevi

// run.json: what ran, on which machines, how fast, and how it ended. Plain data that the program fills in; this part
// only writes it. Unknown values are nan and become null. Keys keep the order of the struct. Collective:
// write_run_report (rank 0's report is the one written).
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "trevi/box.hpp"
#include "trevi/session.hpp"

namespace trevi {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// One phase of the step: seconds over ranks, calls of one rank, flops and bytes of all ranks.
struct PhaseReport {
  std::string name;
  double seconds_min = unknown, seconds_mean = unknown, seconds_max = unknown;
  std::int64_t calls = 0;
  double flops = unknown, bytes = unknown;
};

/// A machine of the run: the number of its ranks, which are consecutive; for each of them its processors as Linux lists
/// them ("0-3,8"); and the number of memory domains that these are in.
struct HostReport {
  std::string name;
  int ranks = 0, memory_domains = 0;
  std::vector<std::string> processors;
};

struct RunReport {
  std::string exit_reason;  ///< "done", "stopped: wall limit", ...
  int exit_code = 0;
  int ranks = 1;
  int threads = 1, threads_min = 1;  ///< of a rank: largest and smallest over the ranks
  struct Versions {
    std::string trevi, mpi, petsc, hdf5, vtk;
  } versions;
  std::string scene, scene_hash;  ///< absolute path; scene_hash() of the text
  Box domain;
  double spacing = unknown, rest_density = unknown;
  std::vector<std::string> warnings;       ///< settings outside the stability envelope, and a rise of the energy
  std::string instruction_set, precision;  ///< e.g. "AVX2", "double"
  std::int64_t first_step = 0, last_step = 0;
  std::int64_t steps = 0;  ///< done by this process, without those before a restart
  std::int64_t particles = 0;
  double simulated_seconds = unknown, wall_seconds = unknown;
  double steps_per_second = unknown, particle_steps_per_second = unknown;
  double nanoseconds_per_pair = unknown;
  double energy_gain = unknown;          ///< EnergyRise::fraction(); unknown without a series
  double motion_gain = unknown;          ///< EnergyRise::fraction_of_motion()
  double compression_largest = unknown;  ///< mean over the water at the end of a substep
  std::int64_t crushed_step = -1;        ///< first with more than density.crush_limit; -1: none
  /// Particles that were requested from an inlet, and what became of them (FlowState::Stream).
  struct Inlet {
    double asked, made, covered, blocked, dry;
  };
  std::vector<Inlet> inlets;            ///< in the order of the scene
  std::int64_t unconverged_solves = 0;  ///< density solves that missed density.tolerance
  double halo_bytes_per_step = unknown, halo_messages_per_step = unknown;  ///< sums over ranks
  /// For each rank: time in the steps; of this, time waiting for others; and of that, time in exchanges with neighbours
  /// and in reductions over all ranks.
  std::vector<double> step_seconds, waiting_seconds, halo_wait_seconds, reduction_seconds;
  /// Largest over mean work of a rank, sampled some steps apart, before cuts were moved if they were.
  double imbalance_mean = unknown, imbalance_max = unknown;
  std::int64_t cut_moves = 0;  ///< times that cuts between slabs were moved
  double bytes_per_particle = unknown;
  double max_resident_bytes = unknown;  ///< largest rank
  double energy_joules = unknown;       ///< of the processors of all hosts, if all report it
  std::vector<HostReport> hosts;
  std::vector<PhaseReport> phases;
};

/// FNV-1a, 64 bits, as 16 hexadecimal digits.
std::string scene_hash(std::string_view text);

/// Writes DIR/run.json. RunError on all ranks alike.
void write_run_report(MPI_Comm comm, const std::string& directory, const RunReport& report);

}  // namespace trevi

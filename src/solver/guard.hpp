// Checks during a run: all particles are finite and inside the box, neighbour lists are not too long, and no particle
// is lost or duplicated. A failure is noted on the rank that finds it, and the substep continues to its end, because a
// rank that throws alone would leave the others waiting forever. At the end all ranks agree, and all throw the same
// BlowUp with rank, step, particle and likely cause. Collective: the constructor, recount() and agree().
#pragma once

#include <exception>
#include <functional>
#include <span>
#include <string>

#include "boundary/walls.hpp"
#include "parallel/step_consensus.hpp"
#include "trevi/particles.hpp"

namespace trevi {

class Guard {
 public:
  /// Counts the particles that must exist from now on. `requests` may be empty.
  Guard(MPI_Comm comm, const Particles& particles, std::function<RequestCounts()> requests);

  /// Counts again after particles were added or removed. Collective.
  void recount(const Particles& particles) { start_ = consensus_.count(state_of(particles.id)); }

  /// From now on `change` more particles are expected, or fewer, over all ranks.
  void expect(const StepState& change);

  /// Notes a failure; only the first one of a rank is reported. `step` counts from 1.
  void note(std::int64_t step, const std::string& failure);

  /// Calls `work`, which may throw on this rank alone, and notes the failure as that of `who`.
  template <class Work>
  void attempt(std::int64_t step, const char* who, Work&& work) {
    try {
      work();
    } catch (const std::exception& error) {
      note(step, std::string(who) + " failed: " + error.what());
    } catch (...) {
      note(step, std::string(who) + " failed");
    }
  }

  void note_particle(const Particles& particles, std::size_t i, std::int64_t step);

  /// Notes the first particle whose p* is outside the box, or whose p* or v is not a number.
  void check(const Particles& particles, const Walls& walls, std::int64_t step);

  /// Notes the first body whose position or motion is not a number.
  void check(std::span<const BodyState> bodies, std::int64_t step);

  /// Notes the compression of the water, from the densities of the owned particles; summed in the next agree().
  void note_compression(std::span<const Real> density, Real rest_density);

  /// Throws BlowUp on all ranks alike if any has noted a failure, or if a particle is missing or duplicated.
  void agree(const Particles& particles, std::int64_t step);

  /// Throws BlowUp on all ranks alike if the mean compression of the water exceeds a half and is not a quarter less
  /// than before: water that starts on top of itself flies apart.
  void end_if_crushed(std::int64_t step) const;

  /// The mean compression that was noted before the last agree(), the same on all ranks.
  Real compression() const { return compression_; }

  /// The requests from outside the run as of the last agree(), the same on all ranks.
  const RequestCounts& requests() const { return requests_; }

 private:
  std::string lost_or_doubled(const StepState& now) const;

  MPI_Comm comm_;
  StepConsensus consensus_;
  std::function<RequestCounts()> ask_;
  StepState start_;
  std::string failure_;
  RequestCounts requests_{};
  std::int64_t noted_compression_ = 0;  // of this rank, as in StepState
  Real compression_ = 0, last_compression_ = 0;
};

}  // namespace trevi

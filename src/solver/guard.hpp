// The guards of a run: particles finite and inside the box, neighbour lists of sane length, none lost, none doubled.
// A failure is noted on the rank where it shows, and the substep goes on to its end, so that no rank waits for another
// for ever; there all ranks vote, and all throw the same BlowUp with rank, step, particle and likely cause.
// Collective: the constructor, recount() and agree().
#pragma once

#include <functional>
#include <string>

#include "fluid/walls.hpp"
#include "parallel/vote.hpp"
#include "trevi/particles.hpp"

namespace trevi {

class Guard {
 public:
  /// Counts the particles that must be there from now on. `requests` may be empty.
  Guard(MPI_Comm comm, const Particles& particles, std::function<RequestCounts()> requests);

  /// The same again, after particles were added or removed. Collective.
  void recount(const Particles& particles) { start_ = ballot_.count(vote_of(particles.id)); }

  /// The first failure of a substep is the one that is told. `step` counts from 1.
  void note(std::int64_t step, const std::string& failure);

  void note_particle(const Particles& particles, std::size_t i, std::int64_t step);

  /// Notes the first particle whose p* is outside the box, or whose p* or v is not a number.
  void check(const Particles& particles, const Walls& walls, std::int64_t step);

  /// Throws BlowUp on all ranks alike when any has noted a failure, or a particle is missing or there twice.
  void agree(const Particles& particles, std::int64_t step);

  /// What is asked of the run from outside, as of the last agree(): the same on all ranks.
  const RequestCounts& requests() const { return requests_; }

 private:
  std::string lost_or_doubled(const Vote& now) const;

  MPI_Comm comm_;
  Ballot ballot_;
  std::function<RequestCounts()> ask_;
  Vote start_;
  std::string failure_;
  RequestCounts requests_{};
};

}  // namespace trevi

// What all ranks must agree on once a substep, in one small reduction: which particles exist, whether a guard has
// failed on any rank, and what is requested from outside the run. Ids enter as two sums modulo 2^64, of the ids and of
// their squares. A single particle lost or doubled changes the first sum by its id, so that the message can name it;
// the sums change, too, where one particle is lost and another is there twice. Collective: StepConsensus::count.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>

#include "trevi/requests.hpp"
#include "trevi/types.hpp"

namespace trevi {

struct StepState {
  std::uint64_t particles = 0, ids = 0, squares = 0;
  std::uint64_t failures = 0;
  std::int64_t compression = 0;  ///< sum over particles, in units of 2^-20
  RequestCounts requests{};      ///< the largest over all ranks
};

/// The part of the consensus that counts particles.
StepState state_of(std::span<const GlobalId> ids);

class StepConsensus {
 public:
  explicit StepConsensus(MPI_Comm comm);
  ~StepConsensus();
  StepConsensus(const StepConsensus&) = delete;
  StepConsensus& operator=(const StepConsensus&) = delete;

  StepState count(const StepState& mine) const;

 private:
  MPI_Comm comm_;
  MPI_Datatype type_;
  MPI_Op op_;
};

}  // namespace trevi

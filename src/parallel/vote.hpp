// What all ranks have to know of each other once a substep, in one small reduction: how many particles there are and
// which, whether a guard has failed anywhere, and what the world outside asks for. Collective: Ballot::count.
// Ids enter as two sums modulo 2^64: of the ids, and of their squares. One particle lost or doubled changes the first
// by its id, so the message can name it; one lost while another is doubled changes them, too.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>

#include "trevi/requests.hpp"
#include "trevi/types.hpp"

namespace trevi {

struct Vote {
  std::uint64_t particles = 0, ids = 0, squares = 0;
  std::uint64_t failures = 0;
  RequestCounts requests{};  ///< the largest over all ranks
};

/// The part of a vote that counts particles.
Vote vote_of(std::span<const GlobalId> ids);

class Ballot {
 public:
  explicit Ballot(MPI_Comm comm);
  ~Ballot();
  Ballot(const Ballot&) = delete;
  Ballot& operator=(const Ballot&) = delete;

  Vote count(const Vote& mine) const;

 private:
  MPI_Comm comm_;
  MPI_Datatype type_;
  MPI_Op op_;
};

}  // namespace trevi

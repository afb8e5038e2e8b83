#include "parallel/vote.hpp"

#include <algorithm>
#include <type_traits>

namespace trevi {

static_assert(std::is_trivially_copyable_v<Vote>);

namespace {

void combine(void* in, void* inout, int* count, MPI_Datatype*) {
  const auto* from = static_cast<const Vote*>(in);
  auto* into = static_cast<Vote*>(inout);
  for (int k = 0; k < *count; ++k) {
    into[k].particles += from[k].particles;
    into[k].ids += from[k].ids;
    into[k].squares += from[k].squares;
    into[k].failures += from[k].failures;
    for (std::size_t r = 0; r < into[k].requests.size(); ++r) {
      into[k].requests[r] = std::max(into[k].requests[r], from[k].requests[r]);
    }
  }
}

}  // namespace

Vote vote_of(std::span<const GlobalId> ids) {
  Vote vote;
  vote.particles = ids.size();
  for (const GlobalId id : ids) {
    const auto n = static_cast<std::uint64_t>(id);
    vote.ids += n;
    vote.squares += n * n;
  }
  return vote;
}

Ballot::Ballot(MPI_Comm comm) : comm_(comm) {
  MPI_Type_contiguous(sizeof(Vote), MPI_BYTE, &type_);
  MPI_Type_commit(&type_);
  MPI_Op_create(combine, 1, &op_);
}

Ballot::~Ballot() {
  MPI_Op_free(&op_);
  MPI_Type_free(&type_);
}

Vote Ballot::count(const Vote& mine) const {
  Vote total = mine;
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, type_, op_, comm_);
  return total;
}

}  // namespace trevi

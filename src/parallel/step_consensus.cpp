#include "parallel/step_consensus.hpp"

#include <algorithm>
#include <type_traits>

#include "base/threads.hpp"
#include "parallel/waiting.hpp"

namespace trevi {

static_assert(std::is_trivially_copyable_v<StepState>);

namespace {

void combine(void* in, void* inout, int* count, MPI_Datatype*) {
  const auto* from = static_cast<const StepState*>(in);
  auto* into = static_cast<StepState*>(inout);
  for (int k = 0; k < *count; ++k) {
    into[k].particles += from[k].particles;
    into[k].ids += from[k].ids;
    into[k].squares += from[k].squares;
    into[k].failures += from[k].failures;
    into[k].compression += from[k].compression;
    for (std::size_t r = 0; r < into[k].requests.size(); ++r) {
      into[k].requests[r] = std::max(into[k].requests[r], from[k].requests[r]);
    }
  }
}

}  // namespace

StepState state_of(std::span<const GlobalId> ids) {
  PerThread<StepState> parts;
  constexpr LocalId part_size = 8192;
  for_each_part({0, static_cast<LocalId>(ids.size())}, part_size, [&](Range part) {
    std::uint64_t sum = 0, squares = 0;
    for (LocalId i = part.begin; i < part.end; ++i) {
      const auto n = static_cast<std::uint64_t>(ids[static_cast<std::size_t>(i)]);
      sum += n;
      squares += n * n;
    }
    parts.mine().ids += sum;
    parts.mine().squares += squares;
  });
  StepState total;
  total.particles = ids.size();
  parts.for_each([&](const StepState& part) {
    total.ids += part.ids;
    total.squares += part.squares;
  });
  return total;
}

StepConsensus::StepConsensus(MPI_Comm comm) : comm_(comm) {
  MPI_Type_contiguous(sizeof(StepState), MPI_BYTE, &type_);
  MPI_Type_commit(&type_);
  MPI_Op_create(combine, 1, &op_);
}

StepConsensus::~StepConsensus() {
  MPI_Op_free(&op_);
  MPI_Type_free(&type_);
}

StepState StepConsensus::count(const StepState& mine) const {
  StepState total = mine;
  all_reduce(comm_, &total, 1, type_, op_);
  return total;
}

}  // namespace trevi

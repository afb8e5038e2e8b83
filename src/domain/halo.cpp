#include "domain/halo.hpp"

#include "domain/slabs.hpp"
#include "parallel/waiting.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {
constexpr int low = 0, high = 1;

int message_length(std::size_t bytes) {
  require(bytes < max_message_bytes, "a boundary plane exceeds 2 GB; use smaller planes or another slab axis");
  return static_cast<int>(bytes);
}
}  // namespace

Halo::Halo(MPI_Comm comm, bool ring) : comm_(comm) {
  neighbours_.from = slab_neighbours(comm, ring);
  neighbours_.to = {{{neighbours_.from[low], MPI_PROC_NULL}, {neighbours_.from[high], MPI_PROC_NULL}}};
}

// A message is tagged by the side it leaves from, so it arrives at the opposite one.
void Halo::receive(void* data, std::size_t bytes, int peer, int side) {
  if (peer == MPI_PROC_NULL) return;
  MPI_Irecv(data, message_length(bytes), MPI_BYTE, peer, 1 - side, comm_, &requests_.emplace_back());
}

void Halo::send(const void* data, std::size_t bytes, int peer, int side) {
  if (peer == MPI_PROC_NULL) return;
  MPI_Isend(data, message_length(bytes), MPI_BYTE, peer, side, comm_, &requests_.emplace_back());
  bytes_ += static_cast<std::int64_t>(bytes);
  ++messages_;
}

void Halo::rebuild(CellOrder& order) {
  const auto cells = static_cast<std::size_t>(order.grid().cells_per_plane());
  low_counts_.resize(neighbours_.from[low] == MPI_PROC_NULL ? 0 : cells);
  high_counts_.resize(neighbours_.from[high] == MPI_PROC_NULL ? 0 : cells);
  const std::size_t bytes = cells * sizeof(LocalId);
  receive(low_counts_.data(), bytes, neighbours_.from[low], low);
  receive(high_counts_.data(), bytes, neighbours_.from[high], high);
  send(order.first_plane_counts().data(), bytes, neighbours_.from[low], low);
  send(order.high_plane_counts().data(), bytes, neighbours_.from[high], high);
  finish();
  order.add_ghosts(low_counts_, high_counts_);
  owned_ = {order.start(1, 0),
            order.start(2, 0),
            order.start(order.planes(), 0),
            order.start(order.planes() + 1, 0),
            order.low_ghosts() + order.owned() + order.high_ghosts(),
            order.size()};
}

void Halo::start_bytes(std::byte* field, std::size_t size) {
  const auto at = [=](LocalId i) { return static_cast<std::size_t>(i) * size; };
  receive(field, at(owned_.begin), neighbours_.from[low], low);
  receive(field + at(owned_.end), at(owned_.end_high - owned_.end), neighbours_.from[high], high);
  send(field + at(owned_.begin), at(owned_.end_first_plane - owned_.begin), neighbours_.from[low], low);
  send(field + at(owned_.begin_last_plane), at(owned_.end - owned_.begin_last_plane), neighbours_.from[high], high);
}

void Halo::start_plane_bytes(std::span<std::byte> grid, std::size_t plane, const PlanePeers& peers) {
  if (grid.empty()) return;
  std::byte* const end = grid.data() + grid.size();
  receive(grid.data(), plane, peers.from[low], low);
  receive(end - plane, plane, peers.from[high], high);
  for (const int peer : peers.to[low]) send(grid.data() + plane, plane, peer, low);
  for (const int peer : peers.to[high]) send(end - 2 * plane, plane, peer, high);
}

void Halo::finish() {
  const ScopedEvent waited(wait_event_);
  wait_all(requests_);
  requests_.clear();
}

}  // namespace trevi

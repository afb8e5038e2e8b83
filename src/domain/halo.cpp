#include "domain/halo.hpp"

#include "domain/slabs.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {
constexpr int low = 0, high = 1;

int message_length(std::size_t bytes) {
  require(bytes < most_message_bytes, "a boundary plane exceeds 2 GB; use smaller planes or another slab axis");
  return static_cast<int>(bytes);
}
}  // namespace

Halo::Halo(MPI_Comm comm) : comm_(comm) {
  const int rank = rank_of(comm);
  neighbour_[low] = rank > 0 ? rank - 1 : MPI_PROC_NULL;
  neighbour_[high] = rank + 1 < size_of(comm) ? rank + 1 : MPI_PROC_NULL;
}

void Halo::send_receive(const void* send, std::size_t send_bytes, void* receive, std::size_t receive_bytes, int side) {
  const int peer = neighbour_[static_cast<std::size_t>(side)];
  if (peer == MPI_PROC_NULL) return;
  // A message is tagged by the side it leaves from, so it arrives at the opposite one.
  MPI_Irecv(receive, message_length(receive_bytes), MPI_BYTE, peer, 1 - side, comm_, &requests_.emplace_back());
  MPI_Isend(send, message_length(send_bytes), MPI_BYTE, peer, side, comm_, &requests_.emplace_back());
  bytes_ += static_cast<std::int64_t>(send_bytes);
  ++messages_;
}

void Halo::rebuild(CellOrder& order) {
  const auto cells = static_cast<std::size_t>(order.grid().cells_per_plane());
  low_counts_.resize(neighbour_[low] == MPI_PROC_NULL ? 0 : cells);
  high_counts_.resize(neighbour_[high] == MPI_PROC_NULL ? 0 : cells);
  const std::size_t bytes = cells * sizeof(LocalId);
  send_receive(order.first_plane_counts().data(), bytes, low_counts_.data(), bytes, low);
  send_receive(order.last_plane_counts().data(), bytes, high_counts_.data(), bytes, high);
  finish();
  order.add_ghosts(low_counts_, high_counts_);
  owned_ = {order.start(1, 0), order.start(2, 0), order.start(order.planes(), 0), order.start(order.planes() + 1, 0),
            order.size()};
}

void Halo::start_bytes(std::byte* field, std::size_t size) {
  const auto at = [=](LocalId i) { return static_cast<std::size_t>(i) * size; };
  send_receive(field + at(owned_.begin), at(owned_.end_first_plane - owned_.begin), field, at(owned_.begin), low);
  send_receive(field + at(owned_.begin_last_plane), at(owned_.end - owned_.begin_last_plane), field + at(owned_.end),
               at(owned_.end_high - owned_.end), high);
}

void Halo::start_plane_bytes(std::byte* grid, std::size_t plane, std::size_t planes) {
  send_receive(grid + plane, plane, grid, plane, low);
  send_receive(grid + (planes - 2) * plane, plane, grid + (planes - 1) * plane, plane, high);
}

void Halo::finish() {
  const ScopedEvent waited(wait_event_);
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  requests_.clear();
}

}  // namespace trevi

// Ghost exchange with the two neighbour slabs. Particles are in cell order, so what is sent to a neighbour and what is
// received from it are contiguous slices of an array [low ghosts | owned | high ghosts]: no index list, no packing.
// rebuild() finds the slices once a substep; then any array of that layout is exchanged by start() and finish(), and
// work that needs no ghosts can be done in between. Of records that are not all read a part is packed, sent and put in
// place. Whole planes of a grid are exchanged in the same way. Collective over neighbours: all ranks call the same
// exchanges in the same order.
#pragma once

#include <mpi.h>

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "base/threads.hpp"
#include "domain/plane_peers.hpp"
#include "parallel/log.hpp"
#include "particles/cell_order.hpp"

namespace trevi {

class Halo {
 public:
  /// `ring`: the first slab is next to the last. A rank may then be its own neighbour.
  explicit Halo(MPI_Comm comm, bool ring = false);
  Halo(const Halo&) = delete;
  Halo& operator=(const Halo&) = delete;

  /// Exchanges the cell counts of the boundary planes and adds the ghost planes to `order`.
  void rebuild(CellOrder& order);

  template <class T>
  void start(std::vector<T>& field) {
    static_assert(std::is_trivially_copyable_v<T>);
    assert(field.size() == static_cast<std::size_t>(owned_.all));
    start_bytes(reinterpret_cast<std::byte*>(field.data()), sizeof(T));
  }
  /// Sends a part of each record, sizeof(Part) bytes from `offset` on; finish_part() receives that of the ghosts. Owned
  /// records may change in between.
  template <class Part, class Record>
  void start_part(const std::vector<Record>& field, std::size_t offset) {
    const Range low_plane{owned_.begin, owned_.end_first_plane}, high_plane{owned_.begin_last_plane, owned_.end};
    const std::array<Range, 2> sent{low_plane, high_plane};
    const std::array<Range, 2> ghosts{Range{0, owned_.begin}, Range{owned_.end, owned_.end_high}};
    for (std::size_t side : {0U, 1U}) {
      received_[side].resize(static_cast<std::size_t>(ghosts[side].size()) * sizeof(Part));
      receive(received_[side].data(), received_[side].size(), neighbours_.from[side], static_cast<int>(side));
    }
    for (std::size_t side : {0U, 1U}) {
      if (neighbours_.from[side] == MPI_PROC_NULL) continue;
      const auto first = static_cast<std::size_t>(sent[side].begin);
      sent_[side].resize(static_cast<std::size_t>(sent[side].size()) * sizeof(Part));
      for_each_index({0, sent[side].size()}, [&, to = sent_[side].data(), from = field.data() + first](std::size_t i) {
        std::memcpy(to + i * sizeof(Part), reinterpret_cast<const std::byte*>(from + i) + offset, sizeof(Part));
      });
      send(sent_[side].data(), sent_[side].size(), neighbours_.from[side], static_cast<int>(side));
    }
  }
  template <class Part, class Record>
  void finish_part(std::vector<Record>& field, std::size_t offset) {
    finish();
    const std::array<Range, 2> ghosts{Range{0, owned_.begin}, Range{owned_.end, owned_.end_high}};
    for (std::size_t side : {0U, 1U}) {
      if (neighbours_.from[side] == MPI_PROC_NULL) continue;
      const auto first = static_cast<std::size_t>(ghosts[side].begin);
      for_each_index(
          {0, ghosts[side].size()}, [&, from = received_[side].data(), to = field.data() + first](std::size_t i) {
            std::memcpy(reinterpret_cast<std::byte*>(to + i) + offset, from + i * sizeof(Part), sizeof(Part));
          });
    }
  }
  /// The same for a grid of cell planes, [low ghost plane | owned ones | high ghost plane], `per_plane` values each.
  template <class T>
  void start_planes(std::vector<T>& grid, std::size_t per_plane) {
    start_planes(grid, per_plane, neighbours_);
  }
  template <class T>
  void start_planes(std::span<T> grid, std::size_t per_plane) {
    static_assert(std::is_trivially_copyable_v<T>);
    start_plane_bytes(std::as_writable_bytes(grid), per_plane * sizeof(T), neighbours_);
  }
  /// Between other ranks than the neighbours; `grid` may have no owned planes.
  template <class T>
  void start_planes(std::vector<T>& grid, std::size_t per_plane, const PlanePeers& peers) {
    static_assert(std::is_trivially_copyable_v<T>);
    start_plane_bytes(std::as_writable_bytes(std::span(grid)), per_plane * sizeof(T), peers);
  }
  void finish();

  template <class T>
  void exchange(std::vector<T>& field) {
    start(field);
    finish();
  }

  bool has_neighbours() const { return neighbours_.from[0] != MPI_PROC_NULL || neighbours_.from[1] != MPI_PROC_NULL; }

  /// Number of bytes and of messages sent by this rank since the beginning.
  std::int64_t bytes() const { return bytes_; }
  std::int64_t messages() const { return messages_; }
  /// Memory of what is packed.
  std::size_t memory() const {
    return sent_[0].capacity() + sent_[1].capacity() + received_[0].capacity() + received_[1].capacity();
  }

 private:
  // Borders of the slices, as indices into an array with ghosts.
  struct Borders {
    LocalId begin = 0, end_first_plane = 0, begin_last_plane = 0, end = 0, end_high = 0, all = 0;
  };
  void start_bytes(std::byte* field, std::size_t size);
  void start_plane_bytes(std::span<std::byte> grid, std::size_t plane, const PlanePeers& peers);
  void receive(void* data, std::size_t bytes, int peer, int side);
  void send(const void* data, std::size_t bytes, int peer, int side);

  MPI_Comm comm_;
  PlanePeers neighbours_;
  Borders owned_;
  std::vector<LocalId> low_counts_, high_counts_;
  std::vector<MPI_Request> requests_;
  std::array<std::vector<std::byte>, 2> sent_, received_;  // parts, by the side
  std::int64_t bytes_ = 0, messages_ = 0;
  Event wait_event_{"HaloWait"};
};

}  // namespace trevi

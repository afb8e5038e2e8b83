// Ghost exchange with the surrounding ranks. Particles are in cell order, so the data sent to a neighbouring slab and
// the data received from it are contiguous slices of an array [low ghosts | owned | high ghosts | ghosts of rows]:
// there is no index list and no packing. Where slabs are cut inside, a row of each plane is sent to the adjacent rank,
// and the rows received from it are stored at the end. rebuild() finds the slices once per substep. Any array of that
// layout is then exchanged by start() and finish(), and work that needs no ghosts can be done in between. If only a
// part of each record is needed, that part is packed, sent and put in place. Cells of a grid are exchanged in the same
// way. Collective over neighbours: all ranks call the same exchanges in the same order.
#pragma once

#include <mpi.h>

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "base/threads.hpp"
#include "domain/cell_peers.hpp"
#include "domain/slabs.hpp"
#include "parallel/log.hpp"
#include "particles/cell_order.hpp"

namespace trevi {

class Halo {
 public:
  /// `ring`: the first slab is adjacent to the last. A rank may then be its own neighbour. Until rebuild() is called,
  /// slabs are not cut.
  explicit Halo(MPI_Comm comm, bool ring = false);
  Halo(const Halo&) = delete;
  Halo& operator=(const Halo&) = delete;

  MPI_Comm comm() const { return comm_; }

  /// Exchanges the cell counts of the boundary and adds the ghosts to `order`.
  void rebuild(CellOrder& order, const CellCuts& cuts);

  template <class Field>
  void start(Field& field) {
    static_assert(std::is_trivially_copyable_v<typename Field::value_type>);
    assert(field.size() == static_cast<std::size_t>(size_));
    start_bytes(reinterpret_cast<std::byte*>(field.data()), sizeof(field[0]));
  }
  /// Sends a part of each record, sizeof(Part) bytes from `offset` on; finish_part() receives that of the ghosts. Owned
  /// records may change in between.
  template <class Part, class Field>
  void start_part(const Field& field, std::size_t offset) {
    for (Ghosts& from : from_) {
      from.received.resize(static_cast<std::size_t>(from.slice.size()) * sizeof(Part));
      receive(from.received.data(), from.received.size(), from.peer);
    }
    for (Boundary& to : to_) {
      to.sent.resize(static_cast<std::size_t>(to.size) * sizeof(Part));
      std::byte* out = to.sent.data();
      for (const Range& slice : to.slices) {
        const auto first = static_cast<std::size_t>(slice.begin);
        for_each_index({0, slice.size()}, [=, from = field.data() + first](std::size_t i) {
          std::memcpy(out + i * sizeof(Part), reinterpret_cast<const std::byte*>(from + i) + offset, sizeof(Part));
        });
        out += static_cast<std::size_t>(slice.size()) * sizeof(Part);
      }
      send(to.sent.data(), to.sent.size(), to.peer);
    }
  }
  template <class Part, class Field>
  void finish_part(Field& field, std::size_t offset) {
    finish();
    for (const Ghosts& from : from_) {
      const auto first = static_cast<std::size_t>(from.slice.begin);
      for_each_index({0, from.slice.size()}, [&, in = from.received.data(), to = field.data() + first](std::size_t i) {
        std::memcpy(reinterpret_cast<std::byte*>(to + i) + offset, in + i * sizeof(Part), sizeof(Part));
      });
    }
  }
  /// Starts the exchange of a grid of cell planes, [low ghost plane | owned planes | high ghost plane], of `per_plane`
  /// values each, for the cells beside the owned rows. Where rows are cut, a plane has one more row at either end.
  template <class Field>
  void start_planes(Field& grid, std::size_t per_plane) {
    start_planes(std::span(grid.data(), grid.size()), per_plane);
  }
  template <class T>
  void start_planes(std::span<T> grid, std::size_t per_plane) {
    static_assert(std::is_trivially_copyable_v<T>);
    start_plane_bytes(std::as_writable_bytes(grid), per_plane * sizeof(T), peers_);
  }
  /// The same for planes of different lengths: slice(k, rows) gives the data of plane k, of `planes` owned ones, and
  /// where rows are cut, of these rows of it.
  using PlaneSlice = std::function<std::span<std::byte>(LocalId k, const Range& rows)>;
  void start_planes(LocalId planes, const PlaneSlice& slice) { start_planes(planes, slice, peers_); }
  /// All cells around those of a grid, exchanged with `peers` instead of the neighbours; `grid` may own no cells.
  template <class Field>
  void start_cells(Field& grid, std::size_t per_plane, const CellPeers& peers) {
    start_plane_bytes(std::as_writable_bytes(std::span(grid.data(), grid.size())), per_plane * sizeof(grid[0]), peers);
    start_rows(grid, per_plane, peers);
  }
  /// The rows beside the owned ones, also of ghost planes; nothing where rows are not cut.
  template <class Field>
  void start_rows(Field& grid, std::size_t per_plane) {
    start_rows(grid, per_plane, peers_);
  }
  /// The same, where address(k, r, side) is the address of row r of plane k; −1 and the number of rows are the ghost
  /// rows. `side`: that of the zone that is filled, −1 for rows before the receiver's own.
  using RowAddress = std::function<void*(LocalId k, LocalId r, int side)>;
  struct RowShape {
    LocalId planes;  ///< owned planes
    std::size_t bytes;
  };
  void start_rows(const RowShape& shape, const RowAddress& address) { start_rows(shape, address, peers_); }
  void finish();

  template <class Field>
  void exchange(Field& field) {
    start(field);
    finish();
  }

  bool has_neighbours() const { return !peers_.from.empty(); }
  bool rows_are_cut() const { return peers_.rows_are_cut; }
  /// The cuts of the last rebuild().
  const CellCuts& cuts() const { return cuts_; }

  /// Number of bytes and of messages sent by this rank since the beginning.
  std::int64_t bytes() const { return bytes_; }
  std::int64_t messages() const { return messages_; }
  /// Memory of packed data, in bytes.
  std::size_t memory() const;

 private:
  // The contents of a message that is sent, as indices into an array with ghosts; and of one that is received.
  struct Boundary {
    CellPiece peer;
    std::vector<Range> slices;
    LocalId size = 0;
    std::vector<std::byte> sent;
  };
  struct Ghosts {
    CellPiece peer;
    Range slice;
    std::vector<std::byte> received;
  };
  void find_peers(const CellOrder& order, const CellCuts& cuts);
  void exchange_counts(CellOrder& order);
  void find_slices(const CellOrder& order);
  void start_bytes(std::byte* field, std::size_t size);
  void start_planes(LocalId planes, const PlaneSlice& slice, const CellPeers& peers);
  void start_plane_bytes(std::span<std::byte> grid, std::size_t plane, const CellPeers& peers);
  template <class Field>
  void start_rows(Field& grid, std::size_t per_plane, const CellPeers& peers) {
    if (!peers.rows_are_cut || grid.empty()) return;
    const std::size_t row = per_plane / (static_cast<std::size_t>(peers.rows) + 2);
    const auto planes = static_cast<LocalId>(grid.size() / per_plane) - 2;
    const auto address = [&, first = grid.data()](LocalId k, LocalId r, int) {
      return first + static_cast<std::size_t>(k) * per_plane + static_cast<std::size_t>(r + 1) * row;
    };
    start_rows({planes, row * sizeof(grid[0])}, address, peers);
  }
  void start_rows(const RowShape& shape, const RowAddress& address, const CellPeers& peers);
  void receive(void* data, std::size_t bytes, const CellPiece& peer);
  void send(const void* data, std::size_t bytes, const CellPiece& peer);
  void note_sent(std::size_t bytes);

  MPI_Comm comm_;
  bool ring_;
  CellCuts cuts_;
  CellPeers peers_;
  std::vector<Boundary> to_;
  std::vector<Ghosts> from_;
  LocalId size_ = 0;  // of an array with ghosts
  std::vector<MPI_Request> requests_;
  std::int64_t bytes_ = 0, messages_ = 0;
  Event wait_event_{"HaloWait"};
};

}  // namespace trevi

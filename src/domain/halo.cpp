#include "domain/halo.hpp"

#include <algorithm>

#include "parallel/waiting.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

int message_length(std::size_t bytes) {
  require(bytes < max_message_bytes, "a boundary plane exceeds 2 GB; use smaller planes or another slab axis");
  return static_cast<int>(bytes);
}

// Planes of a piece as counted by its sender and by its receiver, from the low ghost plane on.
Range planes_to_send(const CellPiece& piece, LocalId planes) {
  return piece.plane < 0 ? Range{planes, planes + 1} : piece.plane > 0 ? Range{1, 2} : Range{1, planes + 1};
}
Range planes_to_fill(const CellPiece& piece, LocalId planes) {
  return piece.plane < 0 ? Range{0, 1} : piece.plane > 0 ? Range{planes + 1, planes + 2} : Range{1, planes + 1};
}

// Several slices of memory as one message.
class Slices {
 public:
  void add(const void* data, std::size_t bytes) {
    if (bytes == 0) return;
    MPI_Get_address(data, &places_.emplace_back());
    lengths_.push_back(message_length(bytes));
    bytes_ += bytes;
  }
  std::size_t bytes() const { return bytes_; }
  // To be freed by the caller.
  MPI_Datatype type() const {
    MPI_Datatype type;
    message_length(bytes_);
    MPI_Type_create_hindexed(static_cast<int>(places_.size()), lengths_.data(), places_.data(), MPI_BYTE, &type);
    MPI_Type_commit(&type);
    return type;
  }

 private:
  std::vector<MPI_Aint> places_;
  std::vector<int> lengths_;
  std::size_t bytes_ = 0;
};

}  // namespace

Halo::Halo(MPI_Comm comm, bool ring) : comm_(comm), ring_(ring) {
  const int ranks = size_of(comm);
  for (LocalId plane = 0; plane <= ranks; ++plane) cuts_.planes.push_back(plane);
  for (int k = 0; k < ranks; ++k) cuts_.rows.insert(cuts_.rows.end(), {0, 1});
  peers_ = cell_peers(cuts_, rank_of(comm), 0, {ring, false});
}

// A message is tagged by the zone that it fills.
void Halo::receive(void* data, std::size_t bytes, const CellPiece& peer) {
  MPI_Irecv(data, message_length(bytes), MPI_BYTE, peer.rank, peer.tag(), comm_, &requests_.emplace_back());
}

void Halo::send(const void* data, std::size_t bytes, const CellPiece& peer) {
  MPI_Isend(data, message_length(bytes), MPI_BYTE, peer.rank, peer.tag(), comm_, &requests_.emplace_back());
  note_sent(bytes);
}

void Halo::note_sent(std::size_t bytes) {
  bytes_ += static_cast<std::int64_t>(bytes);
  ++messages_;
}

void Halo::rebuild(CellOrder& order, const CellCuts& cuts) {
  find_peers(order, cuts);
  exchange_counts(order);
  find_slices(order);
  size_ = order.size();
}

void Halo::find_peers(const CellOrder& order, const CellCuts& cuts) {
  if (cuts == cuts_) return;
  cuts_ = cuts;
  peers_ = cell_peers(cuts_, rank_of(comm_), 0, {ring_, order.grid().is_periodic(1)});
}

// Counts for zones in ghost planes beside the owned rows go directly to their places in the plane; those for other
// zones, which are rows, go to the places of these rows.
void Halo::exchange_counts(CellOrder& order) {
  const auto columns = static_cast<std::size_t>(order.grid().columns()), rows = static_cast<std::size_t>(order.rows());
  const auto planes = static_cast<std::size_t>(order.planes());
  std::array<std::vector<LocalId>, 2> of_planes, of_rows;
  for (const CellPiece& piece : peers_.from) {
    if (piece.row == 0) of_planes[piece.plane < 0 ? 0 : 1].resize(rows * columns);
    if (piece.row != 0) of_rows[piece.row < 0 ? 0 : 1].resize((planes + 2) * columns);
  }
  for (const CellPiece& piece : peers_.from) {
    const Range of = planes_to_fill(piece, order.planes());
    const auto first = static_cast<std::size_t>(of.begin), row = static_cast<std::size_t>(piece.rows.begin);
    const std::size_t count = static_cast<std::size_t>(of.size()) * columns;
    if (piece.row != 0) {
      receive(&of_rows[piece.row < 0 ? 0 : 1][first * columns], count * sizeof(LocalId), piece);
    } else if (!peers_.rows_are_cut) {
      receive(of_planes[piece.plane < 0 ? 0 : 1].data(), rows * columns * sizeof(LocalId), piece);
    } else {
      receive(&of_planes[piece.plane < 0 ? 0 : 1][row * columns],
              static_cast<std::size_t>(piece.rows.size()) * columns * sizeof(LocalId), piece);
    }
  }
  std::vector<std::vector<LocalId>> packed;
  packed.reserve(peers_.to.size());
  for (const CellPiece& piece : peers_.to) {
    const Range of = planes_to_send(piece, order.planes());
    if (piece.row != 0) {
      std::vector<LocalId>& counts = packed.emplace_back();
      for (LocalId k = of.begin; k < of.end; ++k)
        counts.insert(counts.end(), order.counts(k, piece.rows.begin), order.counts(k, piece.rows.begin) + columns);
      send(counts.data(), counts.size() * sizeof(LocalId), piece);
    } else {
      const Range own = peers_.rows_are_cut ? piece.rows : Range{0, order.rows()};
      send(order.counts(of.begin, own.begin), static_cast<std::size_t>(own.size()) * columns * sizeof(LocalId), piece);
    }
  }
  finish();
  order.add_ghosts({of_planes[0], of_planes[1], of_rows[0], of_rows[1]});
}

void Halo::find_slices(const CellOrder& order) {
  const LocalId planes = order.planes();
  from_.resize(peers_.from.size());
  to_.resize(peers_.to.size());
  const auto particles = [&](LocalId first_plane, LocalId last, const Range& rows) {
    return Range{order.row(first_plane, rows.begin).begin, order.row(last, rows.end - 1).end};
  };
  const auto rows_of = [&](const CellPiece& piece) {
    return peers_.rows_are_cut ? piece.rows : Range{0, order.rows()};
  };
  for (std::size_t n = 0; n < from_.size(); ++n) {
    const CellPiece& piece = peers_.from[n];
    const Range of = planes_to_fill(piece, planes);
    from_[n].peer = piece;
    from_[n].slice = particles(of.begin, of.end - 1, rows_of(piece));
  }
  for (std::size_t n = 0; n < to_.size(); ++n) {
    const CellPiece& piece = peers_.to[n];
    const Range of = planes_to_send(piece, planes);
    to_[n].peer = piece;
    to_[n].slices.clear();
    to_[n].size = 0;
    for (LocalId k = of.begin; k < of.end; ++k) {
      to_[n].slices.push_back(particles(k, k, rows_of(piece)));
      to_[n].size += to_[n].slices.back().size();
    }
  }
}

void Halo::start_bytes(std::byte* field, std::size_t size) {
  const auto at = [=](LocalId i) { return static_cast<std::size_t>(i) * size; };
  for (const Ghosts& from : from_) receive(field + at(from.slice.begin), at(from.slice.size()), from.peer);
  for (const Boundary& to : to_) {
    if (to.slices.size() == 1) {
      send(field + at(to.slices[0].begin), at(to.size), to.peer);
      continue;
    }
    Slices slices;
    for (const Range& slice : to.slices) slices.add(field + at(slice.begin), at(slice.size()));
    MPI_Datatype type = slices.type();
    MPI_Isend(MPI_BOTTOM, 1, type, to.peer.rank, to.peer.tag(), comm_, &requests_.emplace_back());
    MPI_Type_free(&type);
    note_sent(slices.bytes());
  }
}

void Halo::start_plane_bytes(std::span<std::byte> grid, std::size_t plane, const CellPeers& peers) {
  if (grid.empty()) return;
  const auto planes = static_cast<LocalId>(grid.size() / plane) - 2;
  const std::size_t row = plane / (static_cast<std::size_t>(peers.rows) + 2);
  start_planes(
      planes,
      [&](LocalId k, const Range& rows) {
        const std::span<std::byte> whole = grid.subspan(static_cast<std::size_t>(k) * plane, plane);
        if (!peers.rows_are_cut) return whole;
        return whole.subspan(static_cast<std::size_t>(rows.begin + 1) * row,
                             static_cast<std::size_t>(rows.size()) * row);
      },
      peers);
}

void Halo::start_planes(LocalId planes, const PlaneSlice& slice, const CellPeers& peers) {
  for (const CellPiece& piece : peers.from) {
    if (piece.row != 0) continue;
    const std::span<std::byte> ghosts = slice(planes_to_fill(piece, planes).begin, piece.rows);
    receive(ghosts.data(), ghosts.size(), piece);
  }
  for (const CellPiece& piece : peers.to) {
    if (piece.row != 0) continue;
    const std::span<std::byte> own = slice(planes_to_send(piece, planes).begin, piece.rows);
    send(own.data(), own.size(), piece);
  }
}

void Halo::start_rows(const RowShape& shape, const RowAddress& address, const CellPeers& peers) {
  const auto start = [&](const CellPiece& piece, const Range& planes, bool sends) {
    Slices slices;
    for (LocalId k = planes.begin; k < planes.end; ++k)
      slices.add(address(k, piece.rows.begin, piece.row), shape.bytes);
    MPI_Datatype type = slices.type();
    MPI_Request* const request = &requests_.emplace_back();
    if (sends) {
      MPI_Isend(MPI_BOTTOM, 1, type, piece.rank, piece.tag(), comm_, request);
      note_sent(slices.bytes());
    } else {
      MPI_Irecv(MPI_BOTTOM, 1, type, piece.rank, piece.tag(), comm_, request);
    }
    MPI_Type_free(&type);
  };
  for (const CellPiece& piece : peers.from)
    if (piece.row != 0) start(piece, planes_to_fill(piece, shape.planes), false);
  for (const CellPiece& piece : peers.to)
    if (piece.row != 0) start(piece, planes_to_send(piece, shape.planes), true);
}

void Halo::finish() {
  if (requests_.empty()) return wait_all({});
  const ScopedEvent waited(wait_event_);
  wait_all(requests_);
  requests_.clear();
}

std::size_t Halo::memory() const {
  std::size_t bytes = 0;
  for (const Boundary& to : to_) bytes += to.sent.capacity();
  for (const Ghosts& from : from_) bytes += from.received.capacity();
  return bytes;
}

}  // namespace trevi

#include "domain/migrate.hpp"

#include <array>
#include <cstdlib>
#include <cstring>

#include "base/growth.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// For each owned particle the side to which it leaves: −1 low, +1 high, 0 if it stays.
struct Directions {
  std::vector<signed char> side;
  std::array<std::size_t, 2> leaving{};  // low, high
  int farthest = 0;                      // largest number of slabs that a particle has to cross
};

Directions directions(int rank, const std::vector<Vec3>& positions, const CellGrid& grid, const Slabs& slabs) {
  Directions result;
  result.side.assign(positions.size(), 0);
  const LocalId first = slabs.first_plane(rank), last = slabs.last_plane(rank);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const LocalId plane = grid.plane_of(positions[i]);
    if (plane >= first && plane < last) continue;
    result.side[i] = plane < first ? -1 : 1;
    ++result.leaving[plane < first ? 0 : 1];
    result.farthest = std::max(result.farthest, std::abs(slabs.owner(plane) - rank));
  }
  return result;
}

std::size_t bytes_per_particle(Particles& particles) {
  std::size_t bytes = 0;
  particles.for_each_field([&](auto& field) { bytes += sizeof(field[0]); });
  return bytes;
}

// The particles that leave to `side`, one field after the other.
std::vector<std::byte> pack(Particles& particles, const Directions& to, int side) {
  std::vector<std::byte> buffer(to.leaving[side < 0 ? 0 : 1] * bytes_per_particle(particles));
  std::byte* out = buffer.data();
  particles.for_each_field([&](auto& field) {
    for (std::size_t i = 0; i < field.size(); ++i) {
      if (to.side[i] != side) continue;
      std::memcpy(out, &field[i], sizeof(field[i]));
      out += sizeof(field[i]);
    }
  });
  return buffer;
}

void remove_leaving(Particles& particles, const Directions& to) {
  particles.for_each_field([&](auto& field) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < field.size(); ++i) {
      if (to.side[i] == 0) field[kept++] = field[i];
    }
    field.resize(kept);
  });
}

void append(Particles& particles, const std::vector<std::byte>& buffer) {
  const std::size_t arrived = buffer.size() / bytes_per_particle(particles);
  const std::byte* in = buffer.data();
  particles.for_each_field([&](auto& field) {
    const std::size_t before = field.size();
    resize_tightly(field, before + arrived);
    if (arrived > 0) std::memcpy(static_cast<void*>(field.data() + before), in, arrived * sizeof(field[0]));
    in += arrived * sizeof(field[0]);
  });
}

// Swaps buffers with the neighbour on each side; incoming[side] is what arrived from that side. Messages count
// particles rather than bytes: a plane of a large box may hold 27 million of them, whose bytes do not fit into an int.
std::array<std::vector<std::byte>, 2> exchange(MPI_Comm comm, const std::array<std::vector<std::byte>, 2>& outgoing,
                                               std::size_t particle_bytes) {
  MPI_Datatype particle;
  MPI_Type_contiguous(static_cast<int>(particle_bytes), MPI_BYTE, &particle);
  MPI_Type_commit(&particle);
  const int rank = rank_of(comm), ranks = size_of(comm);
  const std::array<int, 2> peer = {rank > 0 ? rank - 1 : MPI_PROC_NULL, rank + 1 < ranks ? rank + 1 : MPI_PROC_NULL};
  std::array<std::vector<std::byte>, 2> incoming;
  for (std::size_t side : {0U, 1U}) {  // everything moves to `side`, so it arrives from the other one
    const std::size_t from = 1 - side;
    const int sent = static_cast<int>(outgoing[side].size() / particle_bytes);
    int received = 0;
    MPI_Sendrecv(&sent, 1, MPI_INT, peer[side], 0, &received, 1, MPI_INT, peer[from], 0, comm, MPI_STATUS_IGNORE);
    incoming[from].resize(static_cast<std::size_t>(received) * particle_bytes);
    MPI_Sendrecv(outgoing[side].data(), sent, particle, peer[side], 1, incoming[from].data(), received, particle,
                 peer[from], 1, comm, MPI_STATUS_IGNORE);
  }
  MPI_Type_free(&particle);
  return incoming;
}

}  // namespace

GlobalId migrate(MPI_Comm comm, Particles& particles, std::vector<Vec3> Particles::*position, const CellGrid& grid,
                 const Slabs& slabs) {
  if (slabs.ranks() == 1) return 0;
  const int rank = rank_of(comm);
  Directions to = directions(rank, particles.*position, grid, slabs);
  int rounds = 0;
  MPI_Allreduce(&to.farthest, &rounds, 1, MPI_INT, MPI_MAX, comm);
  GlobalId sent = 0;
  for (int round = 0; round < rounds; ++round) {
    if (round > 0) to = directions(rank, particles.*position, grid, slabs);
    const std::array<std::vector<std::byte>, 2> outgoing = {pack(particles, to, -1), pack(particles, to, 1)};
    remove_leaving(particles, to);
    for (const std::vector<std::byte>& buffer : exchange(comm, outgoing, bytes_per_particle(particles)))
      append(particles, buffer);
    sent += static_cast<GlobalId>(to.leaving[0] + to.leaving[1]);
  }
  return sent;
}

}  // namespace trevi

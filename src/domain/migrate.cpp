#include "domain/migrate.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <iterator>

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "domain/plane_peers.hpp"
#include "domain/send_to_owners.hpp"
#include "parallel/waiting.hpp"
#include "particles/remove.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// The owned particles that leave, in ascending order.
struct Leaving {
  std::array<std::vector<LocalId>, 2> to;  // low, high
  int farthest = 0;                        // largest number of slabs that a particle has to cross

  void append(const Leaving& others) {
    for (std::size_t side : {0U, 1U}) to[side].insert(to[side].end(), others.to[side].begin(), others.to[side].end());
    farthest = std::max(farthest, others.farthest);
  }
};

// Slabs from here to there, upwards; in a ring the shorter direction.
int hops_to(int owner, int rank, int ranks, bool ring) {
  const int hops = owner - rank;
  if (!ring || 2 * std::abs(hops) <= ranks) return hops;
  return hops > 0 ? hops - ranks : hops + ranks;
}

Leaving leaving_particles(int rank, const std::vector<Vec3>& positions, const CellGrid& grid, const Slabs& slabs) {
  const LocalId first = slabs.first_plane(rank), last = slabs.end_plane(rank);
  const Range all{0, static_cast<LocalId>(positions.size())};
  constexpr LocalId part_size = 8192;
  std::vector<Leaving> parts(static_cast<std::size_t>((all.size() + part_size - 1) / part_size));
  for_each_part(all, part_size, [&](Range part) {
    Leaving& leaving = parts[static_cast<std::size_t>(part.begin / part_size)];
    for (LocalId i = part.begin; i < part.end; ++i) {
      const LocalId plane = grid.plane_of(positions[static_cast<std::size_t>(i)]);
      if (plane >= first && plane < last) continue;
      const int hops = hops_to(slabs.owner(plane), rank, slabs.ranks(), grid.is_periodic(0));
      leaving.to[hops < 0 ? 0 : 1].push_back(i);
      leaving.farthest = std::max(leaving.farthest, std::abs(hops));
    }
  });
  Leaving result;
  for (const Leaving& part : parts) result.append(part);
  return result;
}

std::size_t bytes_per_particle(Particles& particles) {
  std::size_t bytes = 0;
  particles.for_each_field([&](auto& field) { bytes += sizeof(field[0]); });
  return bytes;
}

// The chosen particles, one field after the other.
std::vector<std::byte> pack(Particles& particles, const std::vector<LocalId>& chosen) {
  std::vector<std::byte> buffer(chosen.size() * bytes_per_particle(particles));
  std::byte* out = buffer.data();
  particles.for_each_field([&](auto& field) {
    constexpr std::size_t size = sizeof(field[0]);
    for_each_index({0, static_cast<LocalId>(chosen.size())},
                   [out, from = field.data(), to_go = chosen.data()](std::size_t k) {
                     std::memcpy(out + k * size, from + to_go[k], size);
                   });
    out += chosen.size() * size;
  });
  return buffer;
}

void remove_leaving(Particles& particles, const Leaving& leaving) {
  std::vector<LocalId> places;
  std::merge(leaving.to[0].begin(), leaving.to[0].end(), leaving.to[1].begin(), leaving.to[1].end(),
             std::back_inserter(places));
  remove_particles(particles, places);
}

void append(Particles& particles, const std::vector<std::byte>& buffer) {
  const std::size_t arrived = buffer.size() / bytes_per_particle(particles);
  const std::byte* in = buffer.data();
  particles.for_each_field([&](auto& field) {
    const std::size_t before = field.size();
    resize_tightly(field, before + arrived);
    for_each_index({0, static_cast<LocalId>(arrived)}, [in, to = field.data() + before](std::size_t k) {
      std::memcpy(static_cast<void*>(to + k), in + k * sizeof(to[0]), sizeof(to[0]));
    });
    in += arrived * sizeof(field[0]);
  });
}

std::vector<int> owners_of(const std::vector<Vec3>& positions, const CellGrid& grid, const Slabs& slabs) {
  std::vector<int> owners(positions.size());
  for_each_index({0, static_cast<LocalId>(owners.size())},
                 [&, to = owners.data()](std::size_t i) { to[i] = slabs.owner(grid.plane_of(positions[i])); });
  return owners;
}

// Swaps buffers with the neighbour on each side; incoming[side] is what arrived from that side. Messages count
// particles rather than bytes: a plane of a large box may hold 27 million of them, whose bytes do not fit into an int.
std::array<std::vector<std::byte>, 2> exchange(MPI_Comm comm, const std::array<int, 2>& peer,
                                               const std::array<std::vector<std::byte>, 2>& outgoing,
                                               std::size_t particle_bytes) {
  MPI_Datatype particle;
  MPI_Type_contiguous(static_cast<int>(particle_bytes), MPI_BYTE, &particle);
  MPI_Type_commit(&particle);
  std::array<std::vector<std::byte>, 2> incoming;
  for (std::size_t side : {0U, 1U}) {  // everything moves to `side`, so it arrives from the other one
    const std::size_t from = 1 - side;
    const int sent = static_cast<int>(outgoing[side].size() / particle_bytes);
    int received = 0;
    std::array<MPI_Request, 2> requests;
    MPI_Irecv(&received, 1, MPI_INT, peer[from], 0, comm, &requests[0]);
    MPI_Isend(&sent, 1, MPI_INT, peer[side], 0, comm, &requests[1]);
    wait_all(requests);
    incoming[from].resize(static_cast<std::size_t>(received) * particle_bytes);
    MPI_Irecv(incoming[from].data(), received, particle, peer[from], 1, comm, &requests[0]);
    MPI_Isend(outgoing[side].data(), sent, particle, peer[side], 1, comm, &requests[1]);
    wait_all(requests);
  }
  MPI_Type_free(&particle);
  return incoming;
}

}  // namespace

GlobalId migrate(MPI_Comm comm, Particles& particles, std::vector<Vec3> Particles::*position, const CellGrid& grid,
                 const Slabs& slabs) {
  if (slabs.ranks() == 1) return 0;
  const Leaving leaving = leaving_particles(rank_of(comm), particles.*position, grid, slabs);
  int farthest = leaving.farthest;
  all_reduce(comm, &farthest, 1, MPI_INT, MPI_MAX);
  if (farthest == 0) return 0;
  if (farthest > 1) return send_to_owners(comm, particles, owners_of(particles.*position, grid, slabs));
  const std::array<std::vector<std::byte>, 2> outgoing = {pack(particles, leaving.to[0]),
                                                          pack(particles, leaving.to[1])};
  remove_leaving(particles, leaving);
  const std::array<int, 2> peers = slab_neighbours(comm, grid.is_periodic(0));
  for (const std::vector<std::byte>& buffer : exchange(comm, peers, outgoing, bytes_per_particle(particles)))
    append(particles, buffer);
  return static_cast<GlobalId>(leaving.to[0].size() + leaving.to[1].size());
}

}  // namespace trevi

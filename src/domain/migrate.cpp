#include "domain/migrate.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "domain/cell_peers.hpp"
#include "domain/send_to_owners.hpp"
#include "parallel/waiting.hpp"
#include "particles/remove.hpp"
#include "trevi/session.hpp"

namespace trevi {

namespace {

// The owned particles that leave, in ascending order, for each neighbour; and whether any move farther.
struct Leaving {
  std::vector<std::vector<LocalId>> to;
  int far = 0;

  void append(const Leaving& others) {
    for (std::size_t n = 0; n < to.size(); ++n) to[n].insert(to[n].end(), others.to[n].begin(), others.to[n].end());
    far = std::max(far, others.far);
  }
};

// The ranks with cells around those of this rank, in ascending order.
std::vector<int> neighbours_of(int rank, const CellGrid& grid, const Slabs& slabs) {
  std::vector<int> ranks;
  for (const CellPiece& piece : cell_peers(slabs.cuts(), rank, 0, {grid.is_periodic(0), grid.is_periodic(1)}).from)
    if (piece.rank != rank) ranks.push_back(piece.rank);
  std::sort(ranks.begin(), ranks.end());
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
  return ranks;
}

Leaving leaving_particles(int rank, const std::vector<int>& neighbours, const std::vector<Vec3>& positions,
                          const CellGrid& grid, const Slabs& slabs) {
  const CellWindow own = slabs.window(rank, grid.rows());
  const auto is_in = [](LocalId k, const Range& range) { return k >= range.begin && k < range.end; };
  const Range all{0, static_cast<LocalId>(positions.size())};
  constexpr LocalId part_size = 8192;
  const Leaving none{std::vector<std::vector<LocalId>>(neighbours.size()), 0};
  std::vector<Leaving> parts(static_cast<std::size_t>((all.size() + part_size - 1) / part_size), none);
  for_each_part(all, part_size, [&](Range part) {
    Leaving& leaving = parts[static_cast<std::size_t>(part.begin / part_size)];
    for (LocalId i = part.begin; i < part.end; ++i) {
      const Vec3& p = positions[static_cast<std::size_t>(i)];
      const LocalId plane = grid.plane_of(p);
      if (is_in(plane, own.planes) && (slabs.parts() == 1 || is_in(grid.row_of(p), own.rows))) continue;
      const int owner = slabs.owner(grid, p);
      const auto found = std::lower_bound(neighbours.begin(), neighbours.end(), owner);
      const bool is_near = found != neighbours.end() && *found == owner;
      if (is_near) leaving.to[static_cast<std::size_t>(found - neighbours.begin())].push_back(i);
      leaving.far = std::max(leaving.far, is_near ? 0 : 1);
    }
  });
  Leaving result = none;
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

// Returns their number.
std::size_t remove_leaving(Particles& particles, const Leaving& leaving) {
  std::vector<LocalId> places;
  for (const std::vector<LocalId>& some : leaving.to) places.insert(places.end(), some.begin(), some.end());
  std::sort(places.begin(), places.end());
  remove_particles(particles, places);
  return places.size();
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
                 [&, to = owners.data()](std::size_t i) { to[i] = slabs.owner(grid, positions[i]); });
  return owners;
}

// Exchanges buffers with the neighbours; returns what arrived from each. Messages count particles rather than bytes: a
// plane of a large box may hold 27 million of them, whose bytes do not fit into an int.
std::vector<std::vector<std::byte>> exchange(MPI_Comm comm, const std::vector<int>& neighbours,
                                             const std::vector<std::vector<std::byte>>& outgoing,
                                             std::size_t particle_bytes) {
  const std::size_t count = neighbours.size();
  std::vector<MPI_Request> requests(2 * count);
  std::vector<int> sent(count), received(count);
  for (std::size_t n = 0; n < count; ++n) {
    sent[n] = static_cast<int>(outgoing[n].size() / particle_bytes);
    MPI_Irecv(&received[n], 1, MPI_INT, neighbours[n], 0, comm, &requests[n]);
    MPI_Isend(&sent[n], 1, MPI_INT, neighbours[n], 0, comm, &requests[count + n]);
  }
  wait_all(requests);
  MPI_Datatype particle;
  MPI_Type_contiguous(static_cast<int>(particle_bytes), MPI_BYTE, &particle);
  MPI_Type_commit(&particle);
  std::vector<std::vector<std::byte>> incoming(count);
  for (std::size_t n = 0; n < count; ++n) {
    incoming[n].resize(static_cast<std::size_t>(received[n]) * particle_bytes);
    MPI_Irecv(incoming[n].data(), received[n], particle, neighbours[n], 1, comm, &requests[n]);
    MPI_Isend(outgoing[n].data(), sent[n], particle, neighbours[n], 1, comm, &requests[count + n]);
  }
  wait_all(requests);
  MPI_Type_free(&particle);
  return incoming;
}

}  // namespace

GlobalId migrate(MPI_Comm comm, Particles& particles, std::vector<Vec3> Particles::*position, const CellGrid& grid,
                 const Slabs& slabs) {
  if (slabs.ranks() == 1) return 0;
  const std::vector<int> neighbours = neighbours_of(rank_of(comm), grid, slabs);
  const Leaving leaving = leaving_particles(rank_of(comm), neighbours, particles.*position, grid, slabs);
  std::array<int, 2> any{0, leaving.far};
  for (const std::vector<LocalId>& some : leaving.to) any[0] = std::max(any[0], some.empty() ? 0 : 1);
  all_reduce(comm, any.data(), 2, MPI_INT, MPI_MAX);
  if (any[1] > 0) return send_to_owners(comm, particles, owners_of(particles.*position, grid, slabs));
  if (any[0] == 0) return 0;
  std::vector<std::vector<std::byte>> outgoing;
  for (const std::vector<LocalId>& some : leaving.to) outgoing.push_back(pack(particles, some));
  const std::size_t left = remove_leaving(particles, leaving);
  for (const std::vector<std::byte>& buffer : exchange(comm, neighbours, outgoing, bytes_per_particle(particles)))
    append(particles, buffer);
  return static_cast<GlobalId>(left);
}

}  // namespace trevi

// usage: mpirun -np P bench_restart FOLDER [PARTICLES, default 1000000]
// A checkpoint of a full tank, ids with x fastest and slabs along x, so that in the order of ids all are far from home:
// written, read by all ranks and brought to their owners. Tells the bytes that a rank receives over those that it then
// owns, the number of exchanges of all ranks with all, messages between neighbours, seconds and resident memory. Exits
// 1 when a rank receives more than 1.2 times its own.
#include <fmt/format.h>
#include <mpi.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "domain/migrate.hpp"
#include "io/hdf5/checkpoint.hpp"
#include "io/run_directory/output_directory.hpp"
#include "support/count_received.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {
namespace {

using test::received, test::Received;

constexpr Real spacing = 0.1, radius = 0.2;

/// `side` points along each axis.
struct Tank {
  GlobalId side;
  CellGrid grid() const { return {Vec3::Zero(), Vec3::Constant(static_cast<Real>(side) * spacing), radius, 0}; }
};

Slabs slabs_of(const CellGrid& grid, int ranks) {
  return {std::vector<Real>(static_cast<std::size_t>(grid.planes()), 1.0), ranks};
}

/// This rank's slab of the tank.
Particles water(const Session& session, const Tank& tank) {
  const CellGrid grid = tank.grid();
  const Slabs slabs = slabs_of(grid, session.size());
  Particles particles;
  for (GlobalId x = 0; x < tank.side; ++x) {
    const Real px = (static_cast<Real>(x) + 0.5) * spacing;
    if (slabs.owner(grid, Vec3(px, 0, 0)) != session.rank()) continue;
    for (GlobalId y = 0; y < tank.side; ++y) {
      for (GlobalId z = 0; z < tank.side; ++z) {
        particles.id.push_back((z * tank.side + y) * tank.side + x);
        particles.position.emplace_back(px, (static_cast<Real>(y) + 0.5) * spacing,
                                        (static_cast<Real>(z) + 0.5) * spacing);
      }
    }
  }
  particles.velocity.assign(particles.id.size(), Vec3::Zero());
  return particles;
}

double largest(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return value;
}

double resident_megabytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e3;
}

int bench(const Session& session, const std::string& folder, GlobalId total) {
  const Tank tank{static_cast<GlobalId>(std::cbrt(static_cast<double>(total)) + 1e-9)};
  const std::string path = folder + "/checkpoint_000000.h5";
  make_output_directory(session.comm(), folder);
  {
    const Particles particles = water(session, tank);
    const Clock clock{0, 0.01, 1};
    write_checkpoint(session.comm(), path, {"a scene\n", "0", 1, 0}, Frame{clock, particles, {}, nullptr, {}});
  }
  const double resident_to_write = largest(resident_megabytes());
  received = {};
  const double start = MPI_Wtime();
  ParticleRows rows = std::move(read_checkpoint(session.comm(), path).rows);
  Particles particles = std::move(static_cast<Particles&>(rows));
  const double after_read = MPI_Wtime();
  const Received reading = received;
  particles.predicted = particles.position;
  const CellGrid grid = tank.grid();
  migrate(session.comm(), particles, &Particles::position, grid, slabs_of(grid, session.size()));
  const double end = MPI_Wtime();
  double own_bytes = 0;
  particles.for_each_field(
      [&](const auto& field) { own_bytes += static_cast<double>(field.size() * sizeof(field[0])); });
  const double to_home = largest(static_cast<double>(received.bytes - reading.bytes) / own_bytes),
               all = largest(static_cast<double>(received.bytes) / own_bytes);
  const double read_seconds = largest(after_read - start), home_seconds = largest(end - after_read);
  const double resident = largest(resident_megabytes());
  if (session.rank() == 0) {
    fmt::print(
        "{} particles on {} ranks: a rank receives {:.3f} of its own on the way home in {} exchanges and {} messages, "
        "{:.3f} with the checks of the file; reading {:.2f} s, home {:.2f} s; resident {:.0f} MB a rank (written with "
        "{:.0f})\n",
        tank.side * tank.side * tank.side, session.size(), to_home, received.exchanges - reading.exchanges,
        received.messages - reading.messages, all, read_seconds, home_seconds, resident, resident_to_write);
  }
  return all <= 1.2 ? 0 : 1;
}

}  // namespace
}  // namespace trevi

int main(int argc, char** argv) {
  const trevi::Session session(argc, argv);
  if (argc < 2) return 2;
  try {
    return trevi::bench(session, argv[1], argc > 2 ? std::atoll(argv[2]) : 1000000);
  } catch (const trevi::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
}

// usage: mpirun -np P bench_output FOLDER [PARTICLES, default 1000000 [mixed]]
// Checkpoint and frames of a cloud against plain writes of the same bytes to the same disk, all synced, in turns in one
// run so that the disk's moods strike all alike. Medians of nine; exits 1 when the ratio of a checkpoint or a VTKHDF
// frame is below one half (VTU frames are compressed). OMP_NUM_THREADS is the number of threads of a rank.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "io/frames/vtkhdf.hpp"
#include "io/frames/vtu.hpp"
#include "io/hdf5/checkpoint.hpp"
#include "io/run_directory/files.hpp"
#include "io/run_directory/output_directory.hpp"
#include "trevi/error.hpp"
#include "trevi/session.hpp"

namespace trevi {
namespace {

constexpr int rounds = 9;

/// This rank's slab of a cubic lattice of total particles or a few less, ids with x fastest: in cell order, as the
/// solver keeps them, or "mixed", any particle anywhere, the worst that a long run can come to.
Particles cloud(const Session& session, GlobalId total, bool mixed) {
  Particles particles;
  const auto side = static_cast<GlobalId>(std::cbrt(static_cast<double>(total)) + 1e-9);
  const GlobalId planes = side / 2;
  const GlobalId first = planes * session.rank() / session.size(),
                 last = planes * (session.rank() + 1) / session.size();
  for (GlobalId cell = first * planes * planes; cell < last * planes * planes; ++cell) {
    const GlobalId x = 2 * (cell / planes / planes), y = 2 * (cell / planes % planes), z = 2 * (cell % planes);
    for (const GlobalId k : {0, 1, 2, 3, 4, 5, 6, 7}) {
      particles.id.push_back(((z + k / 4) * side + y + k / 2 % 2) * side + x + k % 2);
    }
  }
  std::mt19937_64 random(1);
  if (mixed) {
    particles.id.clear();
    for (GlobalId id = session.rank(); id < side * side * side; id += session.size()) particles.id.push_back(id);
    std::shuffle(particles.id.begin(), particles.id.end(), random);
  }
  particles.resize(particles.id.size());
  std::uniform_real_distribution<Real> number(0, 1);
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    particles.position[i] = Vec3(number(random), number(random), number(random));
    particles.velocity[i] = Vec3(number(random), number(random), number(random));
  }
  return particles;
}

/// Wall seconds until the last rank is through.
double seconds_of(MPI_Comm comm, const std::function<void()>& work) {
  MPI_Barrier(comm);
  const double start = MPI_Wtime();
  work();
  MPI_Barrier(comm);
  return MPI_Wtime() - start;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void write_plainly(const Session& session, const std::string& path, std::int64_t bytes) {
  const std::int64_t share = bytes / session.size();
  const std::string data(static_cast<std::size_t>(share), 'x');
  if (session.rank() == 0) create_empty_file(path);
  MPI_Barrier(session.comm());
  RandomAccessFile file(path);
  file.write(share * session.rank(), data);
  file.sync();
}

/// Compares `write`, which leaves its file at `path`, with plain writes; returns the ratio of their speeds.
double compare(const Session& session, const std::string& name, const std::string& path,
               const std::function<void()>& write) {
  write();  // warm, and for the size
  const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(path));
  std::vector<double> ours, plain;
  for (int k = 0; k < rounds; ++k) {
    plain.push_back(seconds_of(session.comm(), [&] { write_plainly(session, path + ".plain", bytes); }));
    ours.push_back(seconds_of(session.comm(), write));
  }
  const double ratio = median(plain) / median(ours), megabytes = static_cast<double>(bytes) / 1e6;
  if (session.rank() == 0) {
    const double best = *std::min_element(ours.begin(), ours.end());
    fmt::print(
        "{}: {:.1f} ms (best {:.1f}), {:.1f} MB, {:.0f} MB/s (best {:.0f}); plain writes {:.0f} MB/s (best {:.0f}); "
        "ratio {:.2f}\n",
        name, 1e3 * median(ours), 1e3 * best, megabytes, megabytes / median(ours), megabytes / best,
        megabytes / median(plain), megabytes / *std::min_element(plain.begin(), plain.end()), ratio);
  }
  return ratio;
}

int bench(const Session& session, const std::string& folder, const Particles& particles) {
  const std::vector<Real> density(particles.id.size(), 1000);
  const Clock clock{0, 0.01, 1};
  const Frame frame{clock, particles, density, nullptr, {}};
  FrameOptions options;
  options.directory = folder;
  options.fields = {"velocity", "density", "rgb", "id"};
  options.colour.by = Colour::speed;
  options.colour.speed_max = 2;
  const auto writer = make_vtkhdf_writer(session.comm(), options);
  make_output_directory(session.comm(), folder);
  const std::string checkpoint = folder + "/checkpoint_000000.h5";
  const double first = compare(session, "checkpoint", checkpoint, [&] {
    write_checkpoint(session.comm(), checkpoint, {"a scene\n", "0", 1, 0}, frame);
  });
  const double second =
      compare(session, "vtkhdf frame", folder + "/particles_000000.hdf", [&] { writer->observe(frame); });
  if (vtk_version() != "absent") {
    const auto vtu = make_vtu_writer(session.comm(), options);
    compare(session, "vtu frame", folder + "/vtu/particles_000000_0.vtu", [&] { vtu->observe(frame); });
  }
  return first >= 0.5 && second >= 0.5 ? 0 : 1;
}

}  // namespace
}  // namespace trevi

int main(int argc, char** argv) {
  const trevi::Session session(argc, argv);
  if (argc < 2) return 2;
  try {
    const bool mixed = argc > 3 && std::string(argv[3]) == "mixed";
    return trevi::bench(session, argv[1], trevi::cloud(session, argc > 2 ? std::atoll(argv[2]) : 1000000, mixed));
  } catch (const trevi::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return static_cast<int>(error.code());
  }
}

#include "app/rescue.hpp"

#include <array>
#include <filesystem>
#include <system_error>

#include "io/hdf5/checkpoint.hpp"
#include "io/run_directory/files.hpp"
#include "io/run_directory/output_directory.hpp"
#include "parallel/collective.hpp"

namespace trevi {

namespace fs = std::filesystem;

namespace {

/// A name that is not taken, determined by rank 0.
std::string free_name(MPI_Comm comm, const fs::path& wanted) {
  std::string name;
  if (rank_of(comm) == 0) {
    name = wanted.string() + ".rescued";
    std::error_code ignored;
    for (int k = 1; fs::exists(name, ignored); ++k) name = wanted.string() + "." + std::to_string(k) + ".rescued";
  }
  return first_text(comm, name);
}

void write_state(MPI_Comm comm, const CheckpointInfo& info, const Solver& solver, const std::string& directory) {
  const std::vector<FountainState> fountains = solver.fountains();
  const Clock clock = solver.clock();
  const Frame frame{clock, solver.particles(), {}, nullptr, fountains, solver.flow(), {}, {}, solver.first_cell()};
  write_checkpoint(comm, directory + "/" + name_of_step(checkpoint_files, clock.step), info, frame);
}

}  // namespace

std::optional<std::string> rescue_state(const Session& session, const CheckpointInfo& info, const Solver& solver,
                                        const std::string& lost) {
  const MPI_Comm comm = session.comm();
  std::error_code ignored;
  const fs::path beside = (fs::absolute(lost, ignored) / "").lexically_normal().parent_path();
  const std::array places = {beside, fs::current_path(ignored) / beside.filename(),
                             fs::temp_directory_path(ignored) / beside.filename()};
  for (const fs::path& place : places) {
    const std::string directory = free_name(comm, place);
    try {
      make_output_directory(comm, directory);
      write_state(comm, info, solver, directory);
      return directory;
    } catch (const Error&) {  // on all ranks alike; the next place may work
      if (session.rank() == 0) fs::remove(directory, ignored);
    }
  }
  return std::nullopt;
}

}  // namespace trevi

#include "trevi/output/output_directory.hpp"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "trevi/base/error.hpp"
#include "trevi/output/collective.hpp"
#include "trevi/output/files.hpp"

namespace trevi {

namespace fs = std::filesystem;

namespace {

/// The first file found that only a run writes; empty when there is none.
std::string trace_of_a_run(const std::string& directory) {
  for (const char* name : {"series.csv", "particles.pvd", "particles.hdf.series", "run.json"}) {
    if (fs::exists(directory + "/" + name)) return name;
  }
  for (const auto& [prefix, suffix] : {std::pair{"checkpoint_", ".h5"}, std::pair{"particles_", ".hdf"}}) {
    const auto files = stepped_files(directory, prefix, suffix);
    if (!files.empty()) return fs::path(files.front().path).filename().string();
  }
  return {};
}

bool is_in(const std::string& file, const std::string& directory) {
  std::error_code error;
  const fs::path parent = fs::path(file).parent_path();
  return fs::equivalent(parent.empty() ? fs::path(".") : parent, directory, error);
}

void check(const std::string& directory, const std::optional<std::string>& restart_file) {
  const std::string trace = trace_of_a_run(directory);
  if (trace.empty() || (restart_file && is_in(*restart_file, directory))) return;
  throw InputError(directory + ": holds another run (" + trace +
                   "), which is not overwritten; choose another --output, or go on with --restart latest");
}

void make(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw_file_error(directory, "make this folder", error.value());
  if (::access(directory.c_str(), W_OK | X_OK) != 0) throw_file_error(directory, "write into this folder", errno);
}

}  // namespace

void check_output_directory(MPI_Comm comm, const std::string& directory,
                            const std::optional<std::string>& restart_file) {
  on_root(comm, [&] { check(directory, restart_file); });
}

void make_output_directory(MPI_Comm comm, const std::string& directory) {
  on_root(comm, [&] { make(directory); });
}

}  // namespace trevi

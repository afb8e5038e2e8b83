#include "io/run_directory/output_directory.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace fs = std::filesystem;

namespace {

/// The first file found that only a run writes; empty if there is none.
std::string trace_of_a_run(const std::string& directory) {
  for (const char* name : {"series.csv", vtu_list, vtkhdf_list, "run.json"}) {
    if (fs::exists(directory + "/" + name)) return name;
  }
  for (const SteppedName& kind : {checkpoint_files, vtkhdf_frames}) {
    const auto files = stepped_files(directory, kind);
    if (!files.empty()) return fs::path(files.front().path).filename().string();
  }
  for (const std::string& folder : frame_set_folders(directory)) {
    for (const char* list : {vtu_list, vtkhdf_list, cell_list})
      if (fs::exists(folder + "/" + list)) return fs::path(folder).filename().string() + "/" + list;
  }
  const auto frames = stepped_files(directory + "/" + vtu_folder, vtu_frames);
  return frames.empty() ? "" : vtu_folder + fs::path(frames.front().path).filename().string();
}

bool has_files_past_start(const std::string& folder, const SteppedName& kind) {
  const auto files = stepped_files(folder, kind);
  return !files.empty() && files.back().step > 0;
}

bool has_frames_past_start(const std::string& directory) {
  return has_files_past_start(directory, vtkhdf_frames) || has_files_past_start(directory, cell_frames) ||
         has_files_past_start(directory + "/" + vtu_folder, vtu_frames);
}

bool series_is_past_start(const std::string& path) {
  if (!fs::exists(path)) return false;
  std::istringstream text(read_text(path));
  std::string line;
  std::getline(text, line);  // the header
  while (std::getline(text, line)) {
    if (!line.starts_with("0,") && !text.eof()) return true;  // eof: a row that was never completed
  }
  return false;
}

bool is_in(const std::string& file, const std::string& directory) {
  std::error_code error;
  const fs::path parent = fs::path(file).parent_path();
  return fs::equivalent(parent.empty() ? fs::path(".") : parent, directory, error);
}

void check(const std::string& directory, const std::optional<std::string>& restart_file) {
  for (const std::string& folder : {directory, directory + "/vtu"}) {
    std::error_code error;
    const fs::file_type type = fs::status(folder, error).type();
    if (type == fs::file_type::directory || type == fs::file_type::not_found) continue;
    throw InputError(folder + ": cannot be the folder for the output (" + (error ? error.message() : "is a file") +
                     "); choose another --output");
  }
  const std::string stop = directory + "/stop";
  if (fs::is_regular_file(stop)) throw InputError(stop + ": would stop the run at once; remove it first");
  const std::string trace = trace_of_a_run(directory);
  if (trace.empty() || (restart_file && is_in(*restart_file, directory))) return;
  throw InputError(directory + ": holds another run (" + trace +
                   "), which is not overwritten; choose another --output, or go on with --restart latest");
}

void make(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  const auto refuse = [&](const char* action, int problem) {
    throw RunError(directory + ": cannot " + action + ": " + std::strerror(problem) + "; choose another --output");
  };
  if (error) refuse("make this folder", error.value());
  if (::access(directory.c_str(), W_OK | X_OK) != 0) refuse("write into this folder", errno);
}

}  // namespace

void check_output_directory(MPI_Comm comm, const std::string& directory,
                            const std::optional<std::string>& restart_file) {
  on_root(comm, [&] { check(directory, restart_file); });
}

void make_output_directory(MPI_Comm comm, const std::string& directory) {
  on_root(comm, [&] { make(directory); });
}

bool is_before_first_checkpoint(MPI_Comm comm, const std::string& directory) {
  int before = 1;
  on_root(comm, [&] {
    const std::vector<std::string> sets = frame_set_folders(directory);
    const bool past = !stepped_files(directory, checkpoint_files).empty() || has_frames_past_start(directory) ||
                      std::any_of(sets.begin(), sets.end(), has_frames_past_start) ||
                      series_is_past_start(directory + "/series.csv");
    before = past ? 0 : 1;
  });
  MPI_Bcast(&before, 1, MPI_INT, 0, comm);
  return before != 0;
}

}  // namespace trevi

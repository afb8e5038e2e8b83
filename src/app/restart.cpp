#include "app/restart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "base/damaged_file.hpp"
#include "io/frames/frame_list_file.hpp"
#include "io/run_directory/files.hpp"
#include "io/run_directory/output_directory.hpp"
#include "parallel/collective.hpp"
#include "scene/free_places.hpp"
#include "scene/scene_changes.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

std::string quoted_for_shell(std::string_view word) {
  constexpr std::string_view harmless = "_-./:=,+@%";
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [&](unsigned char c) {
    return std::isalnum(c) != 0 || harmless.find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return std::string(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// From the newest checkpoint of a folder that is not damaged. When a job is requeued, nobody can name an older one if
/// the disk has spoilt the last. If a good one cannot be read (permissions, memory, its version), this is reported.
Restart from_newest_good(MPI_Comm comm, const std::string& directory) {
  std::string spoilt;
  for (const std::string& file : newest_checkpoints(comm, directory)) {
    try {
      return {file, read_checkpoint(comm, file), spoilt};
    } catch (const DamagedFile& error) {  // on all ranks alike
      spoilt += std::string("\n  passed over, and set aside as .stale: ") + error.what();
    }
  }
  throw InputError(directory + ": holds no good checkpoint; name another with --restart FILE" + spoilt);
}

// The damaged ones among the lists of frames in the folder: a run that adds to one sets it aside.
std::string damaged_lists(const std::string& directory) {
  namespace fs = std::filesystem;
  std::vector<std::string> lists;
  std::error_code problem;
  std::vector<std::string> folders = frame_set_folders(directory);
  folders.push_back(directory);
  for (const std::string& folder : folders) {
    for (fs::directory_iterator file(folder, problem), end; !problem && file != end; file.increment(problem)) {
      const fs::path ending = file->path().extension();
      if (ending == ".pvd" || ending == ".series") lists.push_back(file->path().string());
    }
  }
  std::sort(lists.begin(), lists.end());
  std::string told;
  for (const std::string& list : lists) {
    try {
      read_frame_list(list);
    } catch (const Error& error) {
      told +=
          std::string("\n  a run that adds to it sets it aside as .stale, and lists anew what can be read of it: ") +
          error.what();
    }
  }
  return told;
}

// Water of the checkpoint may not end up inside solid obstacles that have changed since then. What is barely inside
// them is put outside by the first step.
void check_water(MPI_Comm comm, const Scene& scene, const Restart& restart) {
  const FreePlaces places(scene, restart.state->time);
  const ParticleRows& rows = restart.state->rows;
  all_or_none(comm, [&] {
    for (std::size_t i = 0; i < rows.position.size(); ++i) {
      const int k = places.solid_at(rows.position[i], scene.fluid.spacing / 2);
      if (k < 0) continue;
      throw InputError(fmt::format("{}: /particles/position: row {} would be in {}, which has changed; move it back",
                                   restart.file, rows.first + static_cast<GlobalId>(i), places.name_of(k)));
    }
  });
}

}  // namespace

std::optional<Restart> find_restart(const Session& session, const Scene& scene, const CheckpointInfo& now,
                                    const std::string& wanted, const std::string& directory) {
  if (wanted.empty()) return std::nullopt;
  const MPI_Comm comm = session.comm();
  if (wanted == "latest" && is_before_first_checkpoint(comm, directory)) {
    return Restart{directory + "/checkpoint_000000.h5", std::nullopt,
                   directory + ": no checkpoint and nothing past step 0 here; the run begins at step 0"};
  }
  Restart restart =
      wanted == "latest" ? from_newest_good(comm, directory) : Restart{wanted, read_checkpoint(comm, wanted), ""};
  restart.message = "goes on from " + restart.file + ", step " + std::to_string(restart.state->step) + restart.message;
  if (session.rank() == 0) restart.message += damaged_lists(directory);
  const std::vector<std::string> changes = scene_changes(restart.state->info, restart.file, scene, now);
  const auto of_obstacle = [](const std::string& change) { return change.starts_with("obstacle."); };
  if (std::any_of(changes.begin(), changes.end(), of_obstacle)) check_water(comm, scene, restart);
  for (const std::string& change : changes) restart.message += "\n  changed since: " + change;
  return restart;
}

std::string restart_command(const Session& session, int argc, const char* const* argv) {
  std::string command = session.size() > 1 ? "mpirun -np " + std::to_string(session.size()) + " " : "";
  for (int k = 0; k < argc; ++k) {
    const std::string_view word = argv[k];
    if (word == "--restart") ++k;  // and its value
    if (word == "--restart" || word.starts_with("--restart=")) continue;
    command += quoted_for_shell(word) + " ";
  }
  return command + "--restart latest";
}

}  // namespace trevi

// Plain files of a run: appended rows, whole texts replaced in one stroke, and the names that carry a step number.
// Invariant: a reader never sees half a file, as a new text is written under a temporary name, synced and renamed.
// Rank-local, no communication. Every failure is a RunError with path and the system's reason.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace trevi {

/// Throws RunError "path: cannot <action>: <reason>" with the text of `error`, an errno value.
[[noreturn]] void throw_file_error(const std::string& path, const std::string& action, int error);

/// "12.3 MB free there": what the folder of `path` has room for, to go with errors of libraries that hide their reason.
std::string free_space(const std::string& path);

/// An open file that only grows; what write() has returned for survives the death of the process.
class AppendFile {
 public:
  explicit AppendFile(const std::string& path);  ///< created when missing
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  void write(std::string_view text);

 private:
  std::string path_;
  int descriptor_;
};

std::string read_text(const std::string& path);

/// Temporary name, fsync, rename.
void replace_file(const std::string& path, std::string_view text);

/// fsync of `path`, rename to `target`, fsync of the folder, so that the new name stands for whole content after a
/// crash.
void publish_file(const std::string& path, const std::string& target);

/// A step as file names carry it: six digits at least.
std::string step_digits(std::int64_t step);

struct SteppedFile {
  std::int64_t step;
  std::string path;
};

/// The step in "<prefix><digits>...<suffix>"; nothing when `name` is not of that form.
std::optional<std::int64_t> step_in_name(std::string_view name, std::string_view prefix, std::string_view suffix);

/// Files of `directory` named "<prefix><digits>...<suffix>", by step and name; empty when there is no such folder.
std::vector<SteppedFile> stepped_files(const std::string& directory, std::string_view prefix, std::string_view suffix);

/// Renames those of them past `step` to "<name>.stale" (".1.stale", ... when that is taken): a restart deletes nothing.
void set_aside_after(const std::string& directory, std::string_view prefix, std::string_view suffix, std::int64_t step);

}  // namespace trevi

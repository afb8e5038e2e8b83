// Plain files of a run: appended rows, texts replaced as a whole, and the names that carry a step number. Invariant: a
// reader never sees half a file, because a new text is written under a temporary name, synced and renamed. Rank-local,
// no communication. Every failure is a RunError with the path and the system's reason.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace trevi {

/// Throws RunError "path: cannot <action>: <reason>" with the text of `error`, an errno value.
[[noreturn]] void throw_file_error(const std::string& path, const std::string& action, int error);

/// The largest size in bytes of a file of this process (ulimit -f); none if there is no limit.
std::optional<std::int64_t> file_size_limit();

/// "12.3 MB free there": the free space for the folder of `path`, to go with errors of libraries that hide their
/// reason.
std::string free_space(const std::string& path);

/// Whether a path still leads to the file that a process has open.
bool has_name(int descriptor, const std::string& path);

/// An open file that only grows; once write() has returned, its text survives the death of the process. A RunError is
/// also thrown when the file no longer has its name: rows that nobody can find are lost.
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

/// A file that lives in memory; parts that were never written take no space.
class MemoryFile {
 public:
  MemoryFile();
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const;
  void forget_name();  ///< once a library has opened the file, so that even a killed process leaves nothing behind
  std::int64_t size() const;
  std::string read(std::int64_t begin, std::int64_t end) const;

 private:
  std::string name_;
  int descriptor_;
};

/// An open file that exists already, written to at any offset.
class RandomAccessFile {
 public:
  explicit RandomAccessFile(const std::string& path);
  ~RandomAccessFile();
  RandomAccessFile(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(const RandomAccessFile&) = delete;

  void write(std::int64_t offset, std::string_view bytes);
  void sync();  ///< returns when what was written is on the disk

 private:
  std::string path_;
  int descriptor_;
};

std::string read_text(const std::string& path);

/// Creates an empty file, or empties the existing one of that name.
void create_empty_file(const std::string& path);

/// Temporary name, fsync, rename.
void replace_file(const std::string& path, std::string_view text);

/// fsync of `path`, rename to `target`, fsync of the folder, so that after a crash the new name stands for complete
/// content. `path` is removed when that fails.
void publish_file(const std::string& path, const std::string& target);

/// fsync of a file if there is one of that name.
void sync_if_there(const std::string& path);

/// A step as in file names: at least six digits.
std::string step_digits(std::int64_t step);

/// A name that carries a step: "<prefix><digits><suffix>", where a # in the suffix stands for a number.
struct SteppedName {
  const char *prefix, *suffix;
};
inline constexpr SteppedName checkpoint_files{"checkpoint_", ".h5"};
inline constexpr SteppedName vtkhdf_frames{"particles_", ".hdf"};
inline constexpr SteppedName vtu_frames{"particles_", ".pvtu"}, vtu_pieces{"particles_", "_#.vtu"};  ///< in vtu_folder
inline constexpr const char* vtu_folder = "vtu/";
inline constexpr SteppedName cell_frames{"cells_", ".hdf"};
/// Surfaces of obstacles, beside the frames: of moving ones, and, without a step, of those that do not move.
inline constexpr SteppedName obstacle_frames{"obstacles_", ".vtp"};
inline constexpr const char* still_obstacles = "obstacles.vtp";

/// The lists of frames.
inline constexpr const char *vtu_list = "particles.pvd", *vtkhdf_list = "particles.hdf.series";
inline constexpr const char* cell_list = "cells.hdf.series";
inline constexpr const char* obstacle_list = "obstacles.vtp.series";

/// Each of [[output.frames]] has its own folder in that of the run, with files as those above: frames_NAME.
inline constexpr const char* frame_set_prefix = "frames_";

/// The folders of this directory that begin with this prefix, by name.
std::vector<std::string> frame_set_folders(const std::string& directory);

struct SteppedFile {
  std::int64_t step;
  std::string path;
};

std::string name_of_step(const SteppedName& kind, std::int64_t step);  ///< of a kind without a #

/// Nothing if `name` is not exactly what a run would write, as for a copy that somebody made:
/// checkpoint_000120_good.h5.
std::optional<std::int64_t> step_in_name(std::string_view name, const SteppedName& kind);

/// Files of `directory` with such names, by step and name; empty if there is no such folder.
std::vector<SteppedFile> stepped_files(const std::string& directory, const SteppedName& kind);

/// Renames those past `step` to "<name>.stale" (".1.stale", ... if that is taken): a restart deletes nothing.
void set_aside_after(const std::string& directory, const SteppedName& kind, std::int64_t step);

}  // namespace trevi

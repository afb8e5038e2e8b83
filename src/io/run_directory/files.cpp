#include "io/run_directory/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <tuple>

#include "trevi/error.hpp"

namespace trevi {

namespace fs = std::filesystem;

namespace {

void write_all(int descriptor, std::string_view text, const std::string& path) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw_file_error(path, "write", errno);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void sync_folder_of(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  const int descriptor = ::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return;
  // Some network file systems refuse to sync a folder; the rename itself has succeeded all the same.
  static_cast<void>(::fsync(descriptor));
  ::close(descriptor);
}

void sync_descriptor(int descriptor, const std::string& path) {
  // EINVAL: a special file or a file system without sync.
  if (::fsync(descriptor) != 0 && errno != EINVAL) throw_file_error(path, "sync", errno);
}

void sync_file(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR);
  if (descriptor < 0) throw_file_error(path, "open", errno);
  try {
    sync_descriptor(descriptor, path);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  ::close(descriptor);
}

void rename_file(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) throw_file_error(to, "rename " + from + " to it", errno);
}

/// Removes the digits that `text` begins with, and returns them.
std::string_view read_digits(std::string_view& text) {
  const std::string_view digits = text.substr(0, text.find_first_not_of("0123456789"));
  text.remove_prefix(digits.size());
  return digits;
}

void set_aside(const std::string& path) {
  std::string target = path + ".stale";
  for (int k = 1; fs::exists(target); ++k) target = fmt::format("{}.{}.stale", path, k);
  rename_file(path, target);
}

}  // namespace

void throw_file_error(const std::string& path, const std::string& action, int error) {
  throw RunError(fmt::format("{}: cannot {}: {}", path, action, std::strerror(error)));
}

std::optional<std::int64_t> file_size_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return static_cast<std::int64_t>(limit.rlim_cur);
}

std::string free_space(const std::string& path) {
  std::error_code error;
  const fs::path parent = fs::path(path).parent_path();
  const fs::space_info space = fs::space(parent.empty() ? fs::path(".") : parent, error);
  return error ? error.message() : fmt::format("{:.1f} MB free there", static_cast<double>(space.available) / 1e6);
}

bool has_name(int descriptor, const std::string& path) {
  struct stat held = {}, named = {};
  if (::fstat(descriptor, &held) != 0) return false;
  if (::stat(path.c_str(), &named) != 0) return errno != ENOENT && errno != ENOTDIR;  // a file system out of reach
  return held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

AppendFile::AppendFile(const std::string& path)
    : path_(path), descriptor_(::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT, 0666)) {
  if (descriptor_ < 0) throw_file_error(path, "open", errno);
}

AppendFile::~AppendFile() { ::close(descriptor_); }

void AppendFile::write(std::string_view text) {
  write_all(descriptor_, text, path_);
  if (!has_name(descriptor_, path_)) throw RunError(path_ + ": cannot write: it was removed or replaced under the run");
}

// memfd_create would need no name, but HDF5 insists on one that is not a symbolic link.
MemoryFile::MemoryFile()
    : name_(fmt::format("/trevi-{}-{}", ::getpid(), fmt::ptr(this))),
      descriptor_(::shm_open(name_.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0600)) {
  if (descriptor_ < 0) throw_file_error(path(), "make a file in memory", errno);
}

MemoryFile::~MemoryFile() {
  forget_name();
  ::close(descriptor_);
}

std::string MemoryFile::path() const { return "/dev/shm" + name_; }

void MemoryFile::forget_name() {
  if (!name_.empty()) ::shm_unlink(name_.c_str());
  name_.clear();
}

std::int64_t MemoryFile::size() const { return ::lseek(descriptor_, 0, SEEK_END); }

std::string MemoryFile::read(std::int64_t begin, std::int64_t end) const {
  std::string bytes(static_cast<std::size_t>(end - begin), '\0');
  const ssize_t count = ::pread(descriptor_, bytes.data(), bytes.size(), begin);
  if (count != static_cast<ssize_t>(bytes.size())) throw_file_error("memory", "read from it", errno);
  return bytes;
}

RandomAccessFile::RandomAccessFile(const std::string& path) : path_(path), descriptor_(::open(path.c_str(), O_WRONLY)) {
  if (descriptor_ < 0) throw_file_error(path, "open", errno);
}

RandomAccessFile::~RandomAccessFile() { ::close(descriptor_); }

void RandomAccessFile::write(std::int64_t offset, std::string_view bytes) {
  const std::int64_t start = offset;
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), offset);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw_file_error(path_, "write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += written;
  }
  // The disk starts writing now, while the next rows are being prepared; sync() waits for it and receives its errors.
  static_cast<void>(::sync_file_range(descriptor_, start, offset - start, SYNC_FILE_RANGE_WRITE));
}

void RandomAccessFile::sync() { sync_descriptor(descriptor_, path_); }

std::string read_text(const std::string& path) {
  std::error_code ignored;
  if (fs::is_character_file(path, ignored)) throw RunError(path + ": cannot read: is a device, not a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw_file_error(path, "open", errno);
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) throw_file_error(path, "read", errno);
  return text.str();
}

void replace_file(const std::string& path, std::string_view text) {
  const std::string temporary = path + ".tmp";
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (descriptor < 0) throw_file_error(temporary, "open", errno);
  try {
    write_all(descriptor, text, temporary);
  } catch (...) {
    ::close(descriptor);
    ::unlink(temporary.c_str());
    throw;
  }
  if (::close(descriptor) != 0) throw_file_error(temporary, "close", errno);
  publish_file(temporary, path);
}

void create_empty_file(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (descriptor < 0) throw_file_error(path, "create", errno);
  ::close(descriptor);
}

void publish_file(const std::string& path, const std::string& target) {
  try {
    sync_file(path);
    rename_file(path, target);
  } catch (...) {
    ::unlink(path.c_str());
    throw;
  }
  sync_folder_of(target);
}

void sync_if_there(const std::string& path) {
  if (fs::exists(path)) sync_file(path);
}

std::string step_digits(std::int64_t step) { return fmt::format("{:06}", step); }

std::string name_of_step(const SteppedName& kind, std::int64_t step) {
  return kind.prefix + step_digits(step) + kind.suffix;
}

std::optional<std::int64_t> step_in_name(std::string_view name, const SteppedName& kind) {
  const std::string_view prefix = kind.prefix;
  std::string_view suffix = kind.suffix;
  if (!name.starts_with(prefix)) return std::nullopt;
  name.remove_prefix(prefix.size());
  const std::string_view digits = read_digits(name);
  std::int64_t step = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), step);
  if (error != std::errc() || digits != step_digits(step)) return std::nullopt;
  const std::size_t mark = std::min(suffix.find('#'), suffix.size());
  if (!name.starts_with(suffix.substr(0, mark))) return std::nullopt;
  name.remove_prefix(mark);
  suffix.remove_prefix(mark);
  if (suffix.starts_with('#')) {
    if (read_digits(name).empty()) return std::nullopt;
    suffix.remove_prefix(1);
  }
  return name == suffix ? std::optional(step) : std::nullopt;
}

std::vector<std::string> frame_set_folders(const std::string& directory) {
  std::vector<std::string> folders;
  std::error_code error;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->is_directory(error) && entry->path().filename().string().starts_with(frame_set_prefix))
      folders.push_back(entry->path().string());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

std::vector<SteppedFile> stepped_files(const std::string& directory, const SteppedName& kind) {
  std::vector<SteppedFile> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    if (const auto step = step_in_name(entry.path().filename().string(), kind)) {
      files.push_back({*step, entry.path().string()});
    }
  }
  std::sort(files.begin(), files.end(), [](const SteppedFile& a, const SteppedFile& b) {
    return std::tie(a.step, a.path) < std::tie(b.step, b.path);
  });
  return files;
}

void set_aside_after(const std::string& directory, const SteppedName& kind, std::int64_t step) {
  for (const SteppedFile& file : stepped_files(directory, kind)) {
    if (file.step > step) set_aside(file.path);
  }
}

}  // namespace trevi

#include "live/viewer_key.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "trevi/error.hpp"

namespace trevi {

namespace {

constexpr std::size_t key_length = 40;  // in Z85

ViewerKey key_of_secret(const std::string& secret, const std::string& origin) {
  std::array<char, key_length + 1> open{};
  if (secret.size() != key_length || zmq_curve_public(open.data(), secret.c_str()) != 0)
    throw InputError(origin + ": holds no key of a viewer; remove it");
  return {secret, open.data()};
}

[[noreturn]] void fail(const std::string& path, const char* action) {
  throw InputError(
      fmt::format("{}: cannot {}: {}; a viewer and its run share this file", path, action, std::strerror(errno)));
}

/// Reads the key of a file that only its owner, who must be this user, can read.
ViewerKey read_key(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) fail(path, "open");
  struct stat status = {};
  std::array<char, key_length + 1> text{};
  const bool told = ::fstat(file, &status) == 0;
  const ssize_t count = told && S_ISREG(status.st_mode) ? ::read(file, text.data(), text.size()) : 0;
  ::close(file);
  if (!told || status.st_uid != ::geteuid() || (status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw InputError(path + ": others may know this key (it must be yours, with mode 600); remove it");
  return key_of_secret(std::string(text.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))), path);
}

/// Leaves an existing file alone, even one that was created at this moment.
void write_key(const std::string& path, const std::string& secret) {
  const std::string temporary = fmt::format("{}.{}.tmp", path, ::getpid());
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) fail(temporary, "create");
  const bool written = ::write(file, secret.data(), secret.size()) == static_cast<ssize_t>(secret.size());
  ::close(file);
  const bool linked = written && (::link(temporary.c_str(), path.c_str()) == 0 || errno == EEXIST);
  const int error = errno;
  ::unlink(temporary.c_str());
  errno = error;
  if (!linked) fail(path, "write");
}

}  // namespace

ViewerKey new_viewer_key() {
  std::array<char, key_length + 1> open{}, secret{};
  if (zmq_curve_keypair(open.data(), secret.data()) != 0)
    throw InputError("live viewing needs a ZeroMQ that was built with CURVE (libsodium); leave --view out");
  return {secret.data(), open.data()};
}

ViewerKey viewer_key_of(const std::string& directory) {
  if (const char* secret = std::getenv(viewer_key_variable)) return key_of_secret(secret, viewer_key_variable);
  const std::string path = directory + "/" + viewer_key_file;
  struct stat status = {};
  if (::lstat(path.c_str(), &status) != 0) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) throw InputError(fmt::format("{}: cannot make this folder: {}", directory, error.message()));
    write_key(path, new_viewer_key().secret);
  }
  return read_key(path);
}

}  // namespace trevi

#include "io/run_directory/output_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "io/run_directory/files.hpp"
#include "parallel/collective.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

void write_holder(int descriptor) {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  const std::string text = fmt::format("host {}, process {}", host.data(), ::getpid());
  // Only for the message of a run that is refused.
  static_cast<void>(::ftruncate(descriptor, 0) == 0 && ::pwrite(descriptor, text.data(), text.size(), 0) > 0);
}

std::string read_holder(int descriptor) {
  std::array<char, 300> text{};
  const ssize_t count = ::pread(descriptor, text.data(), text.size(), 0);
  return count > 0 ? std::string(text.data(), static_cast<std::size_t>(count)) : "which has not said yet who it is";
}

bool lock_file(int descriptor, const std::string& directory) {
  struct flock whole = {};
  whole.l_type = F_WRLCK;
  if (::fcntl(descriptor, F_SETLK, &whole) == 0) return true;
  if (errno != EACCES && errno != EAGAIN) return false;  // this file system has no locks
  const std::string holder = read_holder(descriptor);
  ::close(descriptor);
  throw InputError(fmt::format("{}: another run is writing here ({}); wait for its end or choose another --output",
                               directory, holder));
}

}  // namespace

OutputLock::OutputLock(MPI_Comm comm, const std::string& directory)
    : comm_(comm), directory_(directory), path_(directory + "/run.lock") {
  take();
}

OutputLock::~OutputLock() {
  if (descriptor_ < 0) return;
  if (has_name(descriptor_, path_)) ::unlink(path_.c_str());  // otherwise it belongs to another run
  ::close(descriptor_);
}

bool OutputLock::lost() const {
  int lost = descriptor_ >= 0 && !has_name(descriptor_, path_) ? 1 : 0;
  MPI_Bcast(&lost, 1, MPI_INT, 0, comm_);
  return lost != 0;
}

void OutputLock::take() {
  on_root(comm_, [&] {
    while (descriptor_ < 0) {
      const int file = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (file < 0) return;  // no folder yet, or one that is not writable, which is reported where it is needed
      const bool locked = lock_file(file, directory_);
      struct stat status = {};
      const bool removed =
          locked && ::fstat(file, &status) == 0 && status.st_nlink == 0;  // by a run that has just ended
      if (removed) ::close(file);
      if (!removed) descriptor_ = file;
    }
    write_holder(descriptor_);
  });
}

}  // namespace trevi

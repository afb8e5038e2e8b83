// To be preloaded: a disk that is not well. TREVI_FAULT names the call that fails and which one of them, "rename:3" for
// instance, counted over calls on files below TREVI_FAULT_FOLDER; TREVI_FAULT_ERRNO is its error (5, EIO, by default).
// "slow:N" makes each fsync take N ms instead.
#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <string>

namespace {

struct Fault {
  std::string call, folder;
  long number = 0;
  int error = EIO;
};

const Fault& fault() {
  static const Fault the_one = [] {
    Fault read;
    const char *wanted = std::getenv("TREVI_FAULT"), *folder = std::getenv("TREVI_FAULT_FOLDER"),
               *error = std::getenv("TREVI_FAULT_ERRNO");
    if (wanted == nullptr || folder == nullptr) return read;
    const std::string text = wanted;
    read.call = text.substr(0, text.find(':'));
    read.number = std::atol(text.c_str() + read.call.size() + 1);
    read.folder = folder;
    if (error != nullptr) read.error = std::atoi(error);
    return read;
  }();
  return the_one;
}

bool fails(const char* call, const std::string& path) {
  static long count = 0;
  if (fault().call != call || !path.starts_with(fault().folder) || ++count != fault().number) return false;
  errno = fault().error;
  return true;
}

std::string path_of(int descriptor) {
  std::array<char, 4096> name{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return ::readlink(link.c_str(), name.data(), name.size() - 1) > 0 ? name.data() : "";
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" int rename(const char* from, const char* to) noexcept {
  return fails("rename", to) ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}

extern "C" int fsync(int descriptor) {
  if (fault().call == "slow" && path_of(descriptor).starts_with(fault().folder))
    ::usleep(static_cast<useconds_t>(1000 * fault().number));
  return fails("fsync", path_of(descriptor)) ? -1 : next<int(int)>("fsync")(descriptor);
}

extern "C" ssize_t pwrite64(int descriptor, const void* bytes, size_t count, off64_t offset) {
  if (fails("pwrite", path_of(descriptor))) return -1;
  return next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(descriptor, bytes, count, offset);
}

extern "C" ssize_t pwrite(int descriptor, const void* bytes, size_t count, off_t offset) {
  return pwrite64(descriptor, bytes, count, offset);
}

extern "C" ssize_t write(int descriptor, const void* bytes, size_t count) {
  if (fails("write", path_of(descriptor))) return -1;
  return next<ssize_t(int, const void*, size_t)>("write")(descriptor, bytes, count);
}

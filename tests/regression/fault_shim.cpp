// To be preloaded: a disk that is not well, a node that is lost, a clock that jumps. TREVI_FAULT names what happens:
//   rename:3   the third rename fails, so fsync, write, pwrite; TREVI_FAULT_ERRNO is the error (5, EIO, by default)
//   full:3     the third write and all later ones find no space left
//   slow:20    each write and fsync takes 20 ms
//   kill:100   the rank TREVI_FAULT_RANK is killed at its hundredth call of MPI; calls:0 tells their
//              number at the end
//   clock:100  the clock of the day, not the monotonic one, jumps by a day, forwards and backwards in turn, at each
//              hundredth reading
// Calls on files count below TREVI_FAULT_FOLDER and where the path has TREVI_FAULT_FILE in it. The first time that a
// process is struck is told: "fault: full strikes trevi at /a/path"; a test that sees no such line has tested nothing.
#define OMPI_SKIP_MPICXX  // objects of the C++ bindings would have to be found when the shim is loaded
#define MPICH_SKIP_MPICXX
#include <dlfcn.h>
#include <fcntl.h>
#include <mpi.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>
#include <utility>

namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

// As mpirun of Open MPI or of MPICH tells it; also before MPI has begun.
std::string own_rank() {
  const std::string rank = variable("OMPI_COMM_WORLD_RANK");
  return rank.empty() ? variable("PMI_RANK") : rank;
}

struct Fault {
  std::string call, folder, file;
  long number = 0;
  int error = EIO;
  bool this_rank = false;
};

const Fault& fault() {
  static const Fault the_one = [] {
    Fault read;
    const std::string text = variable("TREVI_FAULT"), error = variable("TREVI_FAULT_ERRNO");
    if (text.empty()) return read;
    read.call = text.substr(0, text.find(':'));
    read.number = std::atol(text.c_str() + read.call.size() + 1);
    read.folder = variable("TREVI_FAULT_FOLDER");
    read.file = variable("TREVI_FAULT_FILE");
    if (!error.empty()) read.error = std::atoi(error.c_str());
    read.this_rank = variable("TREVI_FAULT_RANK") == own_rank();
    return read;
  }();
  return the_one;
}

bool chosen(const std::string& path) {
  return !fault().folder.empty() && path.starts_with(fault().folder) && path.find(fault().file) != std::string::npos;
}

void tell(const std::string& where) {
  static bool told = false;
  if (!std::exchange(told, true))
    ::dprintf(STDERR_FILENO, "fault: %s strikes %s at %s\n", fault().call.c_str(), program_invocation_short_name,
              where.c_str());
}

bool fails(std::string_view call, const std::string& path) {
  static long count = 0;
  if (fault().call != call || !chosen(path) || ++count != fault().number) return false;
  tell(path);
  errno = fault().error;
  return true;
}

std::string path_of(int descriptor) {
  std::array<char, 4096> name{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return ::readlink(link.c_str(), name.data(), name.size() - 1) > 0 ? name.data() : "";
}

void be_slow(int descriptor) {
  if (fault().call != "slow") return;
  const std::string path = path_of(descriptor);
  if (!chosen(path)) return;
  tell(path);
  ::usleep(static_cast<useconds_t>(1000 * fault().number));
}

/// Whether a write fails; `call` is how the fault names it.
bool write_fails(std::string_view call, int descriptor) {
  static long count = 0;
  be_slow(descriptor);
  if (fault().call == "full" && chosen(path_of(descriptor)) && ++count >= fault().number) {
    tell(path_of(descriptor));
    errno = ENOSPC;
    return true;
  }
  return fault().call == call && fails(call, path_of(descriptor));
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

long calls_of_mpi = 0;

void count_mpi(const char* name) {
  ++calls_of_mpi;
  if (fault().call != "kill" || !fault().this_rank || calls_of_mpi != fault().number) return;
  tell(name);
  ::raise(SIGKILL);
}

/// Seconds by which the clock of the day is wrong now.
long jumped() {
  static long readings = 0;
  if (fault().call != "clock" || (++readings / fault().number) % 2 == 0) return 0;
  tell("a reading of the clock");
  return 86400;
}

}  // namespace

extern "C" int rename(const char* from, const char* to) noexcept {
  return fails("rename", to) ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}

extern "C" int fsync(int descriptor) {
  be_slow(descriptor);
  return fails("fsync", path_of(descriptor)) ? -1 : next<int(int)>("fsync")(descriptor);
}

extern "C" ssize_t pwrite64(int descriptor, const void* bytes, size_t count, off64_t offset) {
  if (write_fails("pwrite", descriptor)) return -1;
  return next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(descriptor, bytes, count, offset);
}

extern "C" ssize_t pwrite(int descriptor, const void* bytes, size_t count, off_t offset) {
  return pwrite64(descriptor, bytes, count, offset);
}

extern "C" ssize_t pwritev(int descriptor, const iovec* parts, int count, off_t offset) {
  if (write_fails("pwrite", descriptor)) return -1;
  return next<ssize_t(int, const iovec*, int, off_t)>("pwritev")(descriptor, parts, count, offset);
}

extern "C" ssize_t write(int descriptor, const void* bytes, size_t count) {
  if (write_fails("write", descriptor)) return -1;
  return next<ssize_t(int, const void*, size_t)>("write")(descriptor, bytes, count);
}

extern "C" ssize_t writev(int descriptor, const iovec* parts, int count) {
  if (write_fails("write", descriptor)) return -1;
  return next<ssize_t(int, const iovec*, int)>("writev")(descriptor, parts, count);
}

extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
  const int result = next<int(clockid_t, timespec*)>("clock_gettime")(clock, now);
  if (clock == CLOCK_REALTIME) now->tv_sec += jumped();
  return result;
}

extern "C" time_t time(time_t* now) noexcept {
  timespec read{};
  clock_gettime(CLOCK_REALTIME, &read);
  if (now != nullptr) *now = read.tv_sec;
  return read.tv_sec;
}

extern "C" int gettimeofday(timeval* now, void* zone) noexcept {
  const int result = next<int(timeval*, void*)>("gettimeofday")(now, zone);
  now->tv_sec += jumped();
  return result;
}

// The calls of MPI that Trevi and HDF5 make while a run computes and writes.
#define TREVI_COUNTED(name, parameters, arguments) \
  extern "C" int name parameters {                 \
    count_mpi(#name);                              \
    return P##name arguments;                      \
  }
TREVI_COUNTED(MPI_Isend, (const void* b, int n, MPI_Datatype t, int to, int tag, MPI_Comm c, MPI_Request* r),
              (b, n, t, to, tag, c, r))
TREVI_COUNTED(MPI_Irecv, (void* b, int n, MPI_Datatype t, int from, int tag, MPI_Comm c, MPI_Request* r),
              (b, n, t, from, tag, c, r))
TREVI_COUNTED(MPI_Waitall, (int n, MPI_Request r[], MPI_Status s[]), (n, r, s))
TREVI_COUNTED(MPI_Wait, (MPI_Request * r, MPI_Status* s), (r, s))
TREVI_COUNTED(MPI_Sendrecv,
              (const void* b, int n, MPI_Datatype t, int to, int tag, void* rb, int rn, MPI_Datatype rt, int from,
               int rtag, MPI_Comm c, MPI_Status* s),
              (b, n, t, to, tag, rb, rn, rt, from, rtag, c, s))
TREVI_COUNTED(MPI_Allreduce, (const void* b, void* r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (b, r, n, t, o, c))
TREVI_COUNTED(MPI_Bcast, (void* b, int n, MPI_Datatype t, int root, MPI_Comm c), (b, n, t, root, c))
TREVI_COUNTED(MPI_Exscan, (const void* b, void* r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (b, r, n, t, o, c))
TREVI_COUNTED(MPI_Allgather, (const void* b, int n, MPI_Datatype t, void* r, int rn, MPI_Datatype rt, MPI_Comm c),
              (b, n, t, r, rn, rt, c))
TREVI_COUNTED(MPI_Allgatherv,
              (const void* b, int n, MPI_Datatype t, void* r, const int rn[], const int at[], MPI_Datatype rt,
               MPI_Comm c),
              (b, n, t, r, rn, at, rt, c))
TREVI_COUNTED(MPI_Gatherv,
              (const void* b, int n, MPI_Datatype t, void* r, const int rn[], const int at[], MPI_Datatype rt, int root,
               MPI_Comm c),
              (b, n, t, r, rn, at, rt, root, c))
TREVI_COUNTED(MPI_Alltoall, (const void* b, int n, MPI_Datatype t, void* r, int rn, MPI_Datatype rt, MPI_Comm c),
              (b, n, t, r, rn, rt, c))
TREVI_COUNTED(MPI_Alltoallv,
              (const void* b, const int n[], const int at[], MPI_Datatype t, void* r, const int rn[], const int rat[],
               MPI_Datatype rt, MPI_Comm c),
              (b, n, at, t, r, rn, rat, rt, c))
TREVI_COUNTED(MPI_Barrier, (MPI_Comm c), (c))
TREVI_COUNTED(MPI_File_open, (MPI_Comm c, const char* name, int mode, MPI_Info i, MPI_File* f), (c, name, mode, i, f))
TREVI_COUNTED(MPI_File_write_at_all, (MPI_File f, MPI_Offset at, const void* b, int n, MPI_Datatype t, MPI_Status* s),
              (f, at, b, n, t, s))
TREVI_COUNTED(MPI_File_write_at, (MPI_File f, MPI_Offset at, const void* b, int n, MPI_Datatype t, MPI_Status* s),
              (f, at, b, n, t, s))
TREVI_COUNTED(MPI_File_sync, (MPI_File f), (f))
TREVI_COUNTED(MPI_File_close, (MPI_File * f), (f))

extern "C" int MPI_Finalize() {
  if (fault().call == "calls") std::fprintf(stderr, "rank %s: %ld calls of MPI\n", own_rank().c_str(), calls_of_mpi);
  return PMPI_Finalize();
}

#include "trevi/session.hpp"

#include <fcntl.h>
#include <petscsys.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <utility>

#include "base/cores.hpp"
#include "base/simd.hpp"
#include "base/threads.hpp"
#include "parallel/core_share.hpp"
#include "parallel/log.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// All ranks use the best instruction set that all of them support, because a job may mix different processors.
void agree_on_instruction_set(MPI_Comm comm) {
  std::int64_t sets = supported_instruction_sets();
  MPI_Allreduce(MPI_IN_PLACE, &sets, 1, MPI_INT64_T, MPI_BAND, comm);
  restrict_instruction_sets(sets);
}

// A process that was not started by a launcher has no other to talk to, so it needs no daemon, no search for networks
// and no folder for messages in /tmp. These take two thirds of the time that Open MPI needs to start. Besides, if there
// are several such processes, one that ends may remove the folder in which another is about to create its own, which
// then fails. Existing settings of the environment are kept, and what is set here is removed after the start, because
// programs that this one starts inherit it.
class StartAlone {
 public:
  StartAlone() {
    for (const char* launched :
         {"PMIX_NAMESPACE", "PMIX_RANK", "PMI_FD", "PMI_RANK", "OMPI_COMM_WORLD_SIZE", "SLURM_STEP_NUM_TASKS"}) {
      if (std::getenv(launched) != nullptr) return;
    }
    for (std::size_t k = 0; k < settings.size(); ++k) {
      set_[k] = std::getenv(settings[k].first) == nullptr && setenv(settings[k].first, settings[k].second, 0) == 0;
    }
  }
  ~StartAlone() {
    for (std::size_t k = 0; k < settings.size(); ++k) {
      if (set_[k]) unsetenv(settings[k].first);
    }
  }
  StartAlone(const StartAlone&) = delete;
  StartAlone& operator=(const StartAlone&) = delete;

 private:
  static constexpr std::array<std::pair<const char*, const char*>, 3> settings = {{
      {"OMPI_MCA_ess_singleton_isolated", "1"},
      {"OMPI_MCA_orte_create_session_dirs", "0"},
      {"OMPI_MCA_pml", "ob1"},
  }};
  std::array<bool, settings.size()> set_ = {};
};

// Libraries run threads of their own (ZeroMQ, MPI's progress), while Trevi calls MPI from the main thread only.
void require_threads() {
  int provided = MPI_THREAD_SINGLE;
  MPI_Query_thread(&provided);
  if (provided >= MPI_THREAD_FUNNELED) return;
  throw RunError("this MPI allows no threads beside it (MPI_THREAD_FUNNELED); use one that does", Reach::all_ranks);
}

// Without this test PETSc would fail on one rank alone, with a stack trace.
void check_options_files(MPI_Comm comm, int argc, const char* const* argv) {
  for (int k = 1; k + 1 < argc; ++k) {
    if (std::string_view(argv[k]) == "-options_file") read_file_everywhere(comm, argv[k + 1]);
  }
}

// A pipe or a device may never end. What is read here goes to all ranks, and MPI has the number of bytes as an int.
std::int64_t max_bytes_of(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored) ? 1 << 30 : 1 << 26;
}

// Returns an errno; EFBIG for a file of more than `most` bytes, ETIMEDOUT for a pipe that sends nothing for ten
// seconds.
int read_file(const std::string& path, std::int64_t most, std::string& text) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);  // also for a pipe that nobody writes to
  if (file < 0) return errno;
  int error = 0;
  std::array<char, 1 << 16> block;
  pollfd ready{file, POLLIN, 0};
  for (ssize_t count = 1; count != 0 && error == 0;) {
    const int waited = ::poll(&ready, 1, 10'000);
    count = waited > 0 ? ::read(file, block.data(), block.size()) : -1;
    if (waited == 0) errno = ETIMEDOUT;
    if (count < 0 && errno != EINTR) error = errno;
    if (count > 0) text.append(block.data(), static_cast<std::size_t>(count));
    if (std::ssize(text) > most) error = EFBIG;
  }
  ::close(file);
  return error;
}

}  // namespace

Mpi::Mpi(int& argc, char**& argv) {
  int begun = 0;
  MPI_Initialized(&begun);
  owner_ = begun == 0;
  int provided = 0;  // tested by the Session, which can report an error
  if (!owner_) return;
  const StartAlone settings;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
}

Mpi::~Mpi() {
  if (owner_) MPI_Finalize();
}

Session::Session(int& argc, char**& argv) {
  mpi_.emplace(argc, argv);
  comm_ = MPI_COMM_WORLD;
  require_threads();
  check_options_files(comm_, argc, argv);
  struct sigaction hangup = {};
  sigaction(SIGHUP, nullptr, &hangup);
  require(PetscInitialize(&argc, &argv, nullptr, nullptr) == 0, "PETSc could not start");
  PetscPopSignalHandler();
  sigaction(SIGHUP, &hangup, nullptr);  // PETSc's handler, too, leaves the default where nohup had set it to ignore
  std::signal(SIGXFSZ, SIG_IGN);        // a file over the limit of the shell is then a failed write, with its reason
  std::signal(SIGPIPE, SIG_IGN);        // a run continues when nobody reads its progress any more
  begin();
}

Session::Session(MPI_Comm comm) : comm_(comm) {
  PetscBool begun = PETSC_FALSE;
  PetscInitialized(&begun);
  owns_petsc_ = begun == PETSC_FALSE;
  if (owns_petsc_) {
    PETSC_COMM_WORLD = comm;
    require(PetscInitializeNoArguments() == 0, "PETSc could not start");
    PetscPopSignalHandler();
  }
  begin();
}

void Session::begin() {
  rank_ = rank_of(comm_);
  size_ = size_of(comm_);
  PetscLogDefaultBegin();  // run.json reads its phases from the log, -log_view or not
  agree_on_instruction_set(comm_);
  flush_denormals();
}

Session::~Session() {
  forget_events();
  if (owns_petsc_) PetscFinalize();
}

void Session::use_threads(int count) {
  if (count < 1 || count > max_threads) {
    throw InputError(std::to_string(count) + " threads: must be from 1 to " + std::to_string(max_threads));
  }
  trevi::use_threads(count);
}

int Session::threads() { return thread_count(); }

int Session::fair_threads() const { return trevi::fair_threads(comm_, usable_cores(), allowed_processors()); }

std::vector<std::string> Session::unused_options() const {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  std::vector<std::string> unused;
  PetscBool given = PETSC_FALSE;
  PetscOptionsHasName(nullptr, nullptr, "-options_left", &given);  // marks it as used: PETSc reads it at its end
  if (PetscOptionsLeftGet(nullptr, &count, &names, &values) != 0) return unused;
  for (PetscInt k = 0; k < count; ++k) {
    if (names[k][0] != '-') unused.push_back(std::string("-") + names[k]);  // others are Trevi's own: --name
  }
  PetscOptionsLeftRestore(nullptr, &count, &names, &values);
  return unused;
}

int rank_of(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank;
}

int size_of(MPI_Comm comm) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  return size;
}

std::string read_file_everywhere(MPI_Comm comm, const std::string& path) {
  std::string text;
  std::int64_t status[2] = {0, 0};  // errno, length
  if (rank_of(comm) == 0) {
    status[0] = read_file(path, max_bytes_of(path), text);
    status[1] = std::ssize(text);
  }
  MPI_Bcast(status, 2, MPI_INT64_T, 0, comm);
  if (status[0] == EFBIG) {
    throw InputError(path +
                     ": holds more than 64 MB (a file: 1 GB), which no scene and no piece of music does; check the "
                     "path");
  }
  if (status[0] == ETIMEDOUT) {
    throw InputError(path + ": a pipe that nobody has written to for ten seconds; check the path");
  }
  if (status[0] != 0) {
    throw InputError(path + ": cannot be read (" + std::strerror(static_cast<int>(status[0])) + "); check the path");
  }
  text.resize(static_cast<std::size_t>(status[1]));
  MPI_Bcast(text.data(), static_cast<int>(status[1]), MPI_CHAR, 0, comm);
  return text;
}

}  // namespace trevi

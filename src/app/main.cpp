#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "app/run.hpp"
#include "base/memory.hpp"

namespace {

// Threads that wait for each other spin. On a core that other work wants, too, a wait of microseconds then lasts as
// long as the time slices of the others: a step took five times as long beside two busy processes. They therefore spin
// for about 50 µs and then sleep. The OpenMP library reads this setting when it is loaded, so the program restarts
// itself; settings of the user are kept.
void bound_waiting(char** argv) {
  // Where OpenMP binds threads it has already bound this one, and the new program would see only this one core.
  for (const char* set : {"GOMP_SPINCOUNT", "OMP_PROC_BIND", "OMP_PLACES", "GOMP_CPU_AFFINITY"})
    if (std::getenv(set) != nullptr) return;
  setenv("GOMP_SPINCOUNT", "3000", 0);
  std::error_code unknown;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", unknown);  // whose name the process keeps
  execv(program.c_str(), argv);  // returns only if it fails: then the program goes on as it is
}

}  // namespace

int main(int argc, char** argv) {
  bound_waiting(argv);
  trevi::give_freed_memory_back();  // libraries have been loaded now
  const trevi::Mpi mpi(argc, argv);
  std::optional<trevi::Session> session;  // outlives the report of an error, because its end needs all ranks
  try {
    session.emplace(argc, argv);
    return static_cast<int>(trevi::run(*session, argc, argv));
  } catch (const trevi::Error& error) {
    return trevi::report_error(error);
  } catch (const std::exception& error) {  // out of memory, for instance
    return trevi::report_error(trevi::RunError(trevi::text_of(error)));
  }
}

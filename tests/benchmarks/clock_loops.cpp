// What threads do not share: to be preloaded, on one rank of one thread.
//   LD_PRELOAD=.../libclock_loops.so build/release/trevi SCENE --steps N
// Every loop that threads share goes through run_parts() (base/threads.hpp). At the end a table of them stands on the
// standard error: processor time in seconds, that since the loop before, calls, parts in the mean, and where it was
// called from, as the library's file and an address in it, which addr2line takes; then the processor time of the whole
// run. What a step costs is the difference of two runs, whose start and end are the same; what the first thread does
// alone is in no loop, and a loop with as many parts as there are planes is one by planes.
#include <dlfcn.h>

#include <cstdint>
#include <cstdio>
#include <ctime>
#include <map>

namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What it takes to ask for the time, which is in no loop.
double cost_of_asking() {
  constexpr int times = 1000;
  const double begin = processor_seconds();
  for (int k = 1; k < times; ++k) processor_seconds();
  return (processor_seconds() - begin) / times;
}

struct Loop {
  double seconds = 0, before = 0, parts = 0;
  long calls = 0;
};

struct Table {
  std::map<const void*, Loop> loops;
  double end = 0;  // of the loop before
  const double asking = cost_of_asking();
  ~Table() {
    for (const auto& [from, loop] : loops) {
      Dl_info place{};
      dladdr(from, &place);
      std::fprintf(stderr, "loop %.6f %.6f %ld %.1f %s %#zx\n", loop.seconds, loop.before, loop.calls,
                   loop.parts / static_cast<double>(loop.calls), place.dli_fname != nullptr ? place.dli_fname : "?",
                   reinterpret_cast<std::uintptr_t>(from) - reinterpret_cast<std::uintptr_t>(place.dli_fbase));
    }
    std::fprintf(stderr, "all %.6f\n", processor_seconds());
  }
} table;

}  // namespace

namespace trevi {

using RunParts = void (*)(std::int32_t parts, void (*work)(const void* context, std::int32_t part),
                          const void* context);

void run_parts(std::int32_t parts, void (*work)(const void* context, std::int32_t part), const void* context) {
  static const auto real = reinterpret_cast<RunParts>(dlsym(RTLD_NEXT, "_ZN5trevi9run_partsEiPFvPKviES1_"));
  const double arrival = processor_seconds();
  Loop& loop = table.loops[__builtin_return_address(0)];
  if (table.end > 0) loop.before += arrival - table.end - table.asking;
  loop.parts += parts;
  ++loop.calls;
  const double begin = processor_seconds();
  real(parts, work, context);
  table.end = processor_seconds();
  loop.seconds += table.end - begin - table.asking;
}

}  // namespace trevi

#include "base/threads.hpp"

#include <omp.h>

#include <cstdlib>
#include <exception>
#include <mutex>

#include "base/simd.hpp"

// GCC's OpenMP library waits by system calls that its thread sanitizer does not see, so it is told what happens before
// what: all that came before a loop before its parts, and all parts before what follows.
#if defined(__SANITIZE_THREAD__)
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#define TREVI_UNSEEN_BY_TSAN __attribute__((no_sanitize("thread")))
#else
#define TREVI_UNSEEN_BY_TSAN
static void __tsan_acquire(void*) {}
static void __tsan_release(void*) {}
#endif

namespace trevi {

namespace {

// The runtime's own default is one thread for every processor that it may use, which several ranks of a node share.
int& wanted_threads() {
  static int count = std::getenv("OMP_NUM_THREADS") != nullptr ? omp_get_max_threads() : 1;
  return count;
}

// The first exception, in the order of the parts.
class FirstFailure {
 public:
  void note(LocalId part, std::exception_ptr failure) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_ && part_ < part) return;
    part_ = part;
    failure_ = std::move(failure);
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::mutex mutex_;
  LocalId part_ = 0;
  std::exception_ptr failure_;
};

}  // namespace

int thread_count() { return wanted_threads(); }
void use_threads(int count) { wanted_threads() = count; }
int thread_number() { return omp_get_thread_num(); }

std::vector<int> placed_processors() {
  std::vector<int> all;
  for (int place = 0; place < omp_get_num_places(); ++place) {
    std::vector<int> some(static_cast<std::size_t>(omp_get_place_num_procs(place)));
    omp_get_place_proc_ids(place, some.data());
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

TREVI_UNSEEN_BY_TSAN void run_parts(LocalId parts, void (*work)(const void* context, LocalId part),
                                    const void* context) {
  const int threads = std::min(thread_count(), parts);
  if (threads <= 1) {
    for (LocalId k = 0; k < parts; ++k) work(context, k);
    return;
  }
  FirstFailure failure;
  char begun = 0, done = 0;  // their addresses alone matter
  __tsan_release(&begun);
#pragma omp parallel num_threads(threads)
  {
    __tsan_acquire(&begun);
    flush_denormals();
#pragma omp for schedule(dynamic) nowait
    for (LocalId k = 0; k < parts; ++k) {
      try {
        work(context, k);
      } catch (...) {
        failure.note(k, std::current_exception());
      }
    }
    __tsan_release(&done);
  }
  __tsan_acquire(&done);
  failure.rethrow();
}

}  // namespace trevi

#include "base/threads.hpp"

#include <omp.h>

#include <atomic>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>

#include "base/growth.hpp"
#include "base/simd.hpp"

// GCC's OpenMP library waits by system calls that its thread sanitizer does not see, so the order of events must be
// declared: everything before a loop happens before its parts, and all parts happen before what follows.
#if defined(__SANITIZE_THREAD__)
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#define TREVI_UNSEEN_BY_TSAN __attribute__((no_sanitize("thread")))
static constexpr bool watched = true;
#else
static constexpr bool watched = false;
#define TREVI_UNSEEN_BY_TSAN
static void __tsan_acquire(void*) {}
static void __tsan_release(void*) {}
#endif

namespace trevi {

namespace {

// The default of the runtime is one thread for every processor that it may use, which several ranks of a node share.
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

// Which parts are still to be done. Each thread has its own range of parts, so that it finds in its cache what it left
// there in the previous loop; when it has finished, it helps the others. The counters order nothing but themselves:
// parts are independent of each other, and a sanitizer that took a counter for a synchronization would not notice if
// they were not.
class ThreadParts {
 public:
  ThreadParts(LocalId parts, int threads) : threads_(static_cast<std::size_t>(threads)) {
    for (int t = 0; t < threads; ++t) {
      const auto begin = [&](int k) { return static_cast<LocalId>(std::int64_t{parts} * k / threads); };
      threads_[static_cast<std::size_t>(t)].next = begin(t);
      threads_[static_cast<std::size_t>(t)].end = begin(t + 1);
    }
  }

  template <class Work>
  void do_all(int thread, const Work& work) {
    for (std::size_t k = 0; k < threads_.size(); ++k) {
      Parts& parts_of_thread = threads_[(static_cast<std::size_t>(thread) + k) % threads_.size()];
      for (LocalId part = parts_of_thread.take(); part < parts_of_thread.end; part = parts_of_thread.take()) work(part);
      // The sanitizer reports what two threads do, and in a short loop the first may have done everything before
      // another wakes up. Therefore no thread helps before all have finished their own range, and two ranges that touch
      // the same memory are always detected.
      if (watched && k == 0) {
#pragma omp barrier
      }
    }
  }

 private:
  struct alignas(128) Parts {
    std::atomic<LocalId> next = 0;
    LocalId end = 0;
    LocalId take() { return next.fetch_add(1, std::memory_order_relaxed); }
  };
  std::vector<Parts> threads_;
};

}  // namespace

int thread_count() { return wanted_threads(); }
void use_threads(int count) { wanted_threads() = count; }
int thread_number() { return omp_get_thread_num(); }

bool can_start_threads(int count) {
  std::mutex gate;
  std::vector<std::thread> started;
  bool enough = true;
  {
    const std::lock_guard<std::mutex> closed(gate);  // they wait for each other, so all exist at the same time
    try {
      while (std::ssize(started) < count - 1)
        started.emplace_back([&gate] { const std::lock_guard<std::mutex> lock(gate); });
    } catch (const std::exception&) {  // no thread, or no memory for it
      enough = false;
    }
  }
  for (std::thread& thread : started) thread.join();
  return enough;
}

std::vector<int> placed_processors() {
  std::vector<int> all;
  for (int place = 0; place < omp_get_num_places(); ++place) {
    std::vector<int> some(static_cast<std::size_t>(omp_get_place_num_procs(place)));
    omp_get_place_proc_ids(place, some.data());
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

void touch_pages(std::byte* memory, std::size_t bytes) {
  constexpr std::size_t page = 4096, fewest = 16 * page;  // smaller arrays come from memory that has been used before
  if (thread_count() == 1 || bytes < fewest) return;
  const auto parts =
      static_cast<LocalId>(std::min<std::size_t>(bytes / page, 64 * static_cast<std::size_t>(thread_count())));
  for_each_part(parts, [&](LocalId part) {
    const auto from = [&](LocalId k) {
      return bytes / page * static_cast<std::size_t>(k) / static_cast<std::size_t>(parts) * page;
    };
    for (std::size_t at = from(part); at < from(part + 1); at += page) memory[at] = std::byte{0};
  });
}

TREVI_UNSEEN_BY_TSAN void run_parts(LocalId parts, void (*work)(const void* context, LocalId part),
                                    const void* context) {
  const int threads = std::min(thread_count(), parts);
  if (threads <= 1) {
    for (LocalId k = 0; k < parts; ++k) work(context, k);
    return;
  }
  FirstFailure failure;
  ThreadParts all_parts(parts, threads);
  char begun = 0, done = 0;  // only their addresses matter
  __tsan_release(&begun);
#pragma omp parallel num_threads(threads)
  {
    __tsan_acquire(&begun);
    const Denormals denormals;  // the threads belong to the whole process
    all_parts.do_all(thread_number(), [&](LocalId part) {
      try {
        work(context, part);
      } catch (...) {
        failure.note(part, std::current_exception());
      }
    });
    __tsan_release(&done);
  }
  __tsan_acquire(&done);
  failure.rethrow();
}

}  // namespace trevi

// Loops that the threads of this rank share (OpenMP). A loop is divided into parts; which thread does which part
// differs from run to run. A part therefore writes only what no other part reads or writes, and a sum is formed within
// one part or by adding the numbers of parts in their order: no bit depends on the number of threads. Loops are not
// nested, and MPI and PETSc are called only outside of them. Not collective.
#pragma once

#include <algorithm>
#include <memory>
#include <type_traits>
#include <vector>

#include "base/range.hpp"

namespace trevi {

/// Threads that share the loops of this process: OMP_NUM_THREADS if that is set, else 1, until use_threads() is called.
int thread_count();
void use_threads(int count);
inline constexpr int max_threads = 1024;  ///< a larger number is assumed to be a mistake

/// Whether the system grants this process this many threads at a time: if it does not, the OpenMP library ends the
/// program.
bool can_start_threads(int count);

/// Limits the number of threads to that when a solver was made, which determines its memory for each thread.
class ThreadLimit {
 public:
  explicit ThreadLimit(int most) : before_(thread_count()) { use_threads(std::min(before_, most)); }
  ~ThreadLimit() { use_threads(before_); }
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  int before_;
};

/// The processors of all places of OpenMP, if OMP_PLACES, OMP_PROC_BIND or GOMP_CPU_AFFINITY defines any.
std::vector<int> placed_processors();

/// Inside of a loop, the number of the thread, from 0; outside, 0.
int thread_number();

/// Calls work(context, k) for each k in [0, parts). If parts throw, the exception of the first is rethrown when all are
/// done.
void run_parts(LocalId parts, void (*work)(const void* context, LocalId part), const void* context);

template <class Work>
void for_each_part(LocalId parts, const Work& work) {
  run_parts(
      parts, [](const void* context, LocalId part) { (*static_cast<const Work*>(context))(part); },
      std::addressof(work));
}

/// Consecutive parts of `range`, each of `size` except the last.
template <class Work>
void for_each_part(Range range, LocalId size, const Work& work) {
  for_each_part((range.size() + size - 1) / size, [&](LocalId k) {
    const LocalId begin = range.begin + k * size;
    work(Range{begin, std::min(begin + size, range.end)});
  });
}

/// Calls work(i) for each i in the range; for loops whose body is short.
template <class Work>
void for_each_index(Range range, const Work& work) {
  constexpr LocalId part_size = 2048;
  for_each_part(range, part_size, [&](Range part) {
    const Work own = work;  // a copy that nobody else can change, so that the compiler may keep it in registers
    for (LocalId i = part.begin; i < part.end; ++i) own(static_cast<std::size_t>(i));
  });
}

/// One object for each thread: memory that a part needs while it works.
template <class T>
class PerThread {
 public:
  T& mine() { return all_[static_cast<std::size_t>(thread_number())].value; }
  /// Visits all of them, when the loop is done.
  template <class Visit>
  void for_each(const Visit& visit) {
    for (Padded& one : all_) visit(one.value);
  }

 private:
  // Two threads that write to one cache line, or to a pair of them, would wait for each other.
  struct alignas(128) Padded {
    T value{};
  };
  std::vector<Padded> all_ = std::vector<Padded>(static_cast<std::size_t>(thread_count()));
};

/// The largest of `least` and the value(i) in the range; NaNs are ignored.
template <class Value>
Real largest(Range range, Real least, const Value& value) {
  PerThread<Real> found;
  found.for_each([&](Real& most) { most = least; });
  constexpr LocalId part_size = 2048;
  for_each_part(range, part_size, [&](Range part) {
    const Value own = value;
    Real most = least;
    for (LocalId i = part.begin; i < part.end; ++i) most = std::max(most, own(static_cast<std::size_t>(i)));
    found.mine() = std::max(found.mine(), most);
  });
  Real most = least;
  found.for_each([&](Real one) { most = std::max(most, one); });
  return most;
}

/// The first i of the range for which `is` holds, range.end if there is none; `is` is called for every i.
template <class Is>
LocalId first_index(Range range, const Is& is) {
  PerThread<LocalId> found;
  found.for_each([&](LocalId& first) { first = range.end; });
  constexpr LocalId part_size = 2048;
  for_each_part(range, part_size, [&](Range part) {
    const Is own = is;
    LocalId first = range.end;
    for (LocalId i = part.begin; i < part.end; ++i) {
      if (own(static_cast<std::size_t>(i))) first = std::min(first, i);
    }
    found.mine() = std::min(found.mine(), first);
  });
  LocalId first = range.end;
  found.for_each([&](LocalId one) { first = std::min(first, one); });
  return first;
}

}  // namespace trevi

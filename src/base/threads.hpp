// Loops that the threads of this rank share (OpenMP). A loop is cut into parts; which thread does which part differs
// from run to run, so a part writes only what no other part reads or writes, and a sum is formed within one part or by
// adding numbers of parts in their order: no bit depends on the number of threads. Loops are not nested, and MPI and
// PETSc are called outside of them only. Not collective.
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
inline constexpr int most_threads = 1024;  ///< a larger number is taken for a mistake

/// The processors of all of OpenMP's places, where OMP_PLACES, OMP_PROC_BIND or GOMP_CPU_AFFINITY makes some.
std::vector<int> placed_processors();

/// Inside of a loop the number of the thread, from 0; outside 0.
int thread_number();

/// work(context, k) for each k of [0, parts). Of the exceptions of parts that of the first is thrown when all are done.
void run_parts(LocalId parts, void (*work)(const void* context, LocalId part), const void* context);

template <class Work>
void for_each_part(LocalId parts, const Work& work) {
  run_parts(
      parts, [](const void* context, LocalId part) { (*static_cast<const Work*>(context))(part); },
      std::addressof(work));
}

/// Consecutive parts of `range`, each of `size` but for the last.
template <class Work>
void for_each_part(Range range, LocalId size, const Work& work) {
  for_each_part((range.size() + size - 1) / size, [&](LocalId k) {
    const LocalId begin = range.begin + k * size;
    work(Range{begin, std::min(begin + size, range.end)});
  });
}

/// work(i) for each i of the range; for loops whose body is short.
template <class Work>
void for_each_index(Range range, const Work& work) {
  constexpr LocalId part_size = 2048;
  for_each_part(range, part_size, [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) work(static_cast<std::size_t>(i));
  });
}

/// One object for each thread: memory that a part needs while it works.
template <class T>
class PerThread {
 public:
  T& mine() { return all_[static_cast<std::size_t>(thread_number())]; }
  auto begin() { return all_.begin(); }
  auto end() { return all_.end(); }

 private:
  std::vector<T> all_ = std::vector<T>(static_cast<std::size_t>(thread_count()));
};

/// The largest of `least` and value(i) of the range; a NaN counts as nothing.
template <class Value>
Real largest(Range range, Real least, const Value& value) {
  PerThread<Real> found;
  std::fill(found.begin(), found.end(), least);
  constexpr LocalId part_size = 2048;
  for_each_part(range, part_size, [&](Range part) {
    Real most = least;
    for (LocalId i = part.begin; i < part.end; ++i) most = std::max(most, value(static_cast<std::size_t>(i)));
    found.mine() = std::max(found.mine(), most);
  });
  return *std::max_element(found.begin(), found.end());
}

/// The first i of the range for which `is` holds, range.end where there is none.
template <class Is>
LocalId first_index(Range range, const Is& is) {
  PerThread<LocalId> found;
  std::fill(found.begin(), found.end(), range.end);
  constexpr LocalId part_size = 2048;
  for_each_part(range, part_size, [&](Range part) {
    LocalId i = part.begin;
    while (i < part.end && !is(static_cast<std::size_t>(i))) ++i;
    if (i < part.end) found.mine() = std::min(found.mine(), i);
  });
  return *std::min_element(found.begin(), found.end());
}

}  // namespace trevi

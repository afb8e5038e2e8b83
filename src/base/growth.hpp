// For arrays whose length changes a little from step to step. std::vector doubles its memory when it must grow, which
// on several ranks would happen to every array in the first steps; a sixteenth more is enough. New memory is first
// written by the threads that will work on it: on machines with separate memory for groups of cores, a page is placed
// near the core whose thread writes to it first. Not collective.
#pragma once

#include <cstddef>
#include <vector>

#include "base/threads.hpp"

namespace trevi {

/// Writes to each page of memory that has never been written, in the same parts as a loop over as many particles.
void touch_pages(std::byte* memory, std::size_t bytes);

/// v.resize(n), with a capacity of just n for an empty array and n + n/16 for one that must grow.
template <class T>
void resize_tightly(std::vector<T>& v, std::size_t n) {
  if (n > v.capacity()) {
    std::vector<T> larger;
    larger.reserve(v.capacity() == 0 ? n : n + n / 16);
    touch_pages(reinterpret_cast<std::byte*>(larger.data()), larger.capacity() * sizeof(T));
    larger.insert(larger.end(), v.begin(), v.end());
    v.swap(larger);
  }
  v.resize(n);
}

}  // namespace trevi

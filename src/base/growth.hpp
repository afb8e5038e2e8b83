// For arrays whose length changes a little from step to step. std::vector doubles its memory when it must grow, which
// on several ranks would happen to every array in the first steps; a sixteenth more is enough.
#pragma once

#include <cstddef>
#include <vector>

namespace trevi {

/// v.resize(n), with a capacity of just n for an empty array and n + n/16 for one that must grow.
template <class T>
void resize_tightly(std::vector<T>& v, std::size_t n) {
  if (n > v.capacity()) v.reserve(v.capacity() == 0 ? n : n + n / 16);
  v.resize(n);
}

}  // namespace trevi

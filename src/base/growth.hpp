// Arrays of a particle count that wanders from step to step. std::vector doubles its memory when it runs out, which on
// several ranks would happen to every array in the first steps; here a sixteenth is enough.
#pragma once

#include <cstddef>
#include <vector>

namespace trevi {

/// v.resize(n); an empty array takes what it needs, one that must grow a sixteenth more.
template <class T>
void resize_tightly(std::vector<T>& v, std::size_t n) {
  if (n > v.capacity()) v.reserve(v.capacity() == 0 ? n : n + n / 16);
  v.resize(n);
}

}  // namespace trevi

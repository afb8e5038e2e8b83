// Loops that are wrong, each in its own way: the thread sanitizer must say so, or it would say nothing of ours either.
// And one that is right, though each of its loops reads what other threads wrote in the loop before.
#include <cstddef>
#include <string>
#include <vector>

#include "base/threads.hpp"

int main(int, char** argv) {
  using namespace trevi;
  constexpr LocalId parts = 40;
  const std::string race = argv[1];
  std::vector<int> one(parts + 1, 0), other = one;
  const auto at = [](std::vector<int>& values, LocalId k) -> int& { return values[static_cast<std::size_t>(k)]; };
  use_threads(3);
  if (race == "sum") for_each_part(parts, [&](LocalId) { ++at(one, 0); });
  if (race == "border") for_each_part(parts, [&](LocalId k) { ++at(one, k), ++at(one, k + 1); });
  if (race == "read") for_each_part(parts, [&](LocalId k) { at(one, k) = at(one, k + 1) + 1; });
  for (int round = 0; race == "none" && round < 20; ++round) {
    for_each_part(parts, [&](LocalId k) { at(other, k) = at(one, (k + 17) % parts) + 1; });
    one.swap(other);
  }
  return race == "none" && at(one, 0) != 20 ? 1 : 0;
}

#include "io/checksums.hpp"

#include <array>
#include <cstring>

namespace trevi {

namespace {

constexpr std::uint64_t start = 0xcbf29ce484222325u, prime = 0x100000001b3u;

std::uint64_t word_at(std::string_view bytes, std::size_t place) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes.data() + place, sizeof word);
  return word;
}

}  // namespace

std::int64_t checksum(std::string_view bytes) {
  // Four sums side by side, as each waits for its last multiplication; then one over these and the rest.
  std::array<std::uint64_t, 4> sums;
  sums.fill(start);
  for (; bytes.size() >= sizeof sums; bytes.remove_prefix(sizeof sums)) {
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = (sums[k] ^ word_at(bytes, 8 * k)) * prime;
  }
  std::uint64_t sum = start;
  for (const std::uint64_t part : sums) sum = (sum ^ part) * prime;
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t count = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), count);
    sum = (sum ^ word) * prime;
    bytes.remove_prefix(count);
  }
  return static_cast<std::int64_t>(sum);
}

}  // namespace trevi

#include "base/hash.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace trevi {

namespace {

constexpr std::uint64_t start = 0xcbf29ce484222325u, prime = 0x100000001b3u;

/// The first 8 bytes as a number; missing bytes count as zero.
std::uint64_t first_word(std::string_view bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes.data(), std::min(bytes.size(), sizeof word));
  return word;
}

}  // namespace

std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t hash = start;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * prime;
  return hash;
}

std::int64_t checksum(std::string_view bytes) {
  // Four independent sums, so that a multiplication need not wait for the previous one; then one sum over these and the
  // remainder.
  std::array<std::uint64_t, 4> sums;
  sums.fill(start);
  for (; bytes.size() >= sizeof sums; bytes.remove_prefix(sizeof sums)) {
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] = (sums[k] ^ first_word(bytes.substr(8 * k))) * prime;
  }
  std::uint64_t sum = start;
  for (const std::uint64_t part : sums) sum = (sum ^ part) * prime;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), sizeof sum)))
    sum = (sum ^ first_word(bytes)) * prime;
  return static_cast<std::int64_t>(sum);
}

}  // namespace trevi

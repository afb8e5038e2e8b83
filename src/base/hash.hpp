// All hashes of Trevi. Their values are stored in checkpoints and reports, select the particles that are drawn, and
// give coincident particles a direction, so they must never change. Not for cryptography. Rank-local.
#pragma once

#include <cstdint>
#include <string_view>

namespace trevi {

/// FNV-1a (Fowler, Noll, Vo), 64 bits.
std::uint64_t fnv1a(std::string_view bytes);

/// For long tables: FNV-1a over 8-byte words in four interleaved sums. Any change within one word changes the result.
std::int64_t checksum(std::string_view bytes);

/// The mixer of SplitMix64 (Steele, Lea, Flood 2014): every bit of x moves every bit of the result.
constexpr std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

}  // namespace trevi

#include "trevi/output/checksums.hpp"

#include <cstring>

namespace trevi {

std::int64_t checksum(std::string_view bytes) {
  std::uint64_t sum = 0xcbf29ce484222325u;
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t count = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), count);
    sum = (sum ^ word) * 0x100000001b3u;
    bytes.remove_prefix(count);
  }
  return static_cast<std::int64_t>(sum);
}

}  // namespace trevi

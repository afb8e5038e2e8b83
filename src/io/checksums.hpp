// Checksums of tables, one for each block of rows, so that a damaged checkpoint is refused and the place is named.
// HDF5's own Fletcher-32 filter is not used, as it needs chunks and HDF5's own hands on the rows (hdf5_writer.hpp says
// why not). FNV-1a, 64 bits, over 8-byte words in four interleaved sums: any change confined to one word changes the
// sum. Rank-local.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace trevi {

/// Writers and readers of checked tables split them among ranks at multiples of it.
inline constexpr std::int64_t rows_per_block = 1024;

std::int64_t checksum(std::string_view bytes);

/// One checksum for each block of `rows_per_block` rows; the last block may be shorter.
template <class T>
std::vector<std::int64_t> block_checksums(std::span<const T> rows) {
  std::vector<std::int64_t> sums;
  for (std::size_t first = 0; first < rows.size(); first += rows_per_block) {
    const auto block = rows.subspan(first, std::min<std::size_t>(rows_per_block, rows.size() - first));
    sums.push_back(checksum({reinterpret_cast<const char*>(block.data()), block.size_bytes()}));
  }
  return sums;
}

}  // namespace trevi

// The rows of a CSV file that a run goes on with after a restart. Rank-local.
#pragma once

#include <cstdint>
#include <string>

namespace trevi {

struct KeptRows {
  std::string text;  ///< header and rows
  std::int64_t last_step = -1;
  std::string last_row;  ///< empty where there is none
};

/// The rows up to step `last`, without a row that a killed run left unfinished. InputError where the columns are
/// others.
KeptRows rows_up_to(const std::string& path, std::int64_t last, const std::string& header);

}  // namespace trevi

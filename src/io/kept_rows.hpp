// The start of a CSV file that a run writes, or goes on with after a restart. Rank-local.
#pragma once

#include <cstdint>
#include <optional>
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

/// Makes the file anew, with these rows after a restart from a step, and otherwise with none.
KeptRows begin_table(const std::string& path, const std::string& header,
                     const std::optional<std::int64_t>& restart_step);

}  // namespace trevi

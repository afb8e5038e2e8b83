// A CSV file that a run writes, or continues after a restart. Rank-local.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "io/run_directory/files.hpp"

namespace trevi {

struct KeptRows {
  std::string text;  ///< header and rows
  std::int64_t last_step = -1;
  std::string last_row;  ///< empty if there is none
};

/// What is written to it survives the death of the process. A run that continues a file leaves it unchanged until it
/// writes the first row of its own, so that a run that is refused has removed nothing.
class Table {
 public:
  /// The file is created, or continued with its rows up to `restart_step`, without a row that a killed run left
  /// incomplete. InputError if the columns of the existing file are different.
  Table(std::string path, const std::string& header, const std::optional<std::int64_t>& restart_step);

  const KeptRows& kept() const { return kept_; }
  void write(std::string_view row);

 private:
  void open();

  std::string path_;
  KeptRows kept_;
  std::optional<AppendFile> file_;
};

}  // namespace trevi

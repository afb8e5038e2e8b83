// A CSV file that a run writes, or goes on with after a restart. Rank-local.
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
  std::string last_row;  ///< empty where there is none
};

/// What is written to it survives the death of the process. A run that goes on leaves the file as it is up to the first
/// row of its own, so that one that is refused has cut nothing.
class Table {
 public:
  /// The file is made anew, or goes on with its rows up to `restart_step`, without one that a killed run left
  /// unfinished. InputError where the columns of that file are others.
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

#include "io/tables/table.hpp"

#include <charconv>
#include <filesystem>
#include <sstream>
#include <utility>

#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

KeptRows rows_up_to(const std::string& path, std::int64_t last, const std::string& header) {
  std::istringstream old(read_text(path));
  std::string line;
  std::getline(old, line);
  if (line != header) {
    throw InputError(path + ": its columns are not those of this scene; restart with another --output");
  }
  KeptRows kept{header + "\n", -1, {}};
  while (std::getline(old, line) && !old.eof()) {  // eof: the line has no newline
    std::int64_t step = -1;
    const auto result = std::from_chars(line.data(), line.data() + line.size(), step);
    if (result.ec != std::errc() || step > last) continue;
    kept.text += line + "\n";
    kept.last_step = step;
    kept.last_row = line;
  }
  return kept;
}

}  // namespace

Table::Table(std::string path, const std::string& header, const std::optional<std::int64_t>& restart_step)
    : path_(std::move(path)), kept_{header + "\n", -1, {}} {
  if (restart_step && std::filesystem::exists(path_)) kept_ = rows_up_to(path_, *restart_step, header);
  if (!restart_step) open();
}

void Table::open() {
  replace_file(path_, kept_.text);
  kept_.text.clear();
  file_.emplace(path_);
}

void Table::write(std::string_view row) {
  if (!file_) open();
  file_->write(row);
}

}  // namespace trevi

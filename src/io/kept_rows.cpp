#include "io/kept_rows.hpp"

#include <charconv>
#include <filesystem>
#include <sstream>

#include "io/files.hpp"
#include "trevi/error.hpp"

namespace trevi {

KeptRows rows_up_to(const std::string& path, std::int64_t last, const std::string& header) {
  std::istringstream old(read_text(path));
  std::string line;
  std::getline(old, line);
  if (line != header) {
    throw InputError(path + ": its columns are not those of this scene; restart with another --output");
  }
  KeptRows kept{header + "\n", -1, {}};
  while (std::getline(old, line) && !old.eof()) {  // eof: the line has no end
    std::int64_t step = -1;
    const auto result = std::from_chars(line.data(), line.data() + line.size(), step);
    if (result.ec != std::errc() || step > last) continue;
    kept.text += line + "\n";
    kept.last_step = step;
    kept.last_row = line;
  }
  return kept;
}

KeptRows begin_table(const std::string& path, const std::string& header,
                     const std::optional<std::int64_t>& restart_step) {
  KeptRows kept{header + "\n", -1, {}};
  if (restart_step && std::filesystem::exists(path)) kept = rows_up_to(path, *restart_step, header);
  replace_file(path, kept.text);
  return kept;
}

}  // namespace trevi

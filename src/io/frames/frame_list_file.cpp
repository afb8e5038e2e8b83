#include "io/frames/frame_list_file.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool is_pvd(const std::string& path) { return path.ends_with(".pvd"); }

std::int64_t step_of(const std::string& file) {
  const std::string name = fs::path(file).filename().string();
  constexpr SteppedName single_file{"particles_", ".vtu"};
  for (const SteppedName& kind : {vtu_frames, single_file, vtu_pieces, vtkhdf_frames, cell_frames, obstacle_frames}) {
    if (const auto step = step_in_name(name, kind)) return *step;
  }
  return -1;
}

std::string attribute(const std::string& element, const std::string& name) {
  std::smatch found;
  return std::regex_search(element, found, std::regex("\\b" + name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

// If `keep_going`, the complete entries of a damaged file.
std::vector<FrameEntry> pvd_entries(const std::string& path, const std::string& text, bool keep_going) {
  std::vector<FrameEntry> entries;
  static const std::regex data_set("<DataSet\\b[^>]*>");
  for (std::sregex_iterator it(text.begin(), text.end(), data_set), end; it != end; ++it) {
    const std::string time = attribute(it->str(), "timestep"), file = attribute(it->str(), "file");
    char* rest = nullptr;
    const double seconds = std::strtod(time.c_str(), &rest);
    const bool is_whole = !file.empty() && !time.empty() && *rest == '\0';
    if (!is_whole && keep_going) continue;
    if (!is_whole) throw InputError(path + ": damaged: " + it->str() + " has no time or no file; use another copy");
    const std::string part = attribute(it->str(), "part");
    if (part.empty() || part == "0" || entries.empty()) {
      entries.push_back({step_of(file), seconds, file, {}});
    } else {
      entries.back().others.push_back(file);
    }
  }
  return entries;
}

std::vector<FrameEntry> read_pvd(const std::string& path) {
  const std::string text = read_text(path);
  if (text.find("</VTKFile>") == std::string::npos)
    throw InputError(path + ": damaged or cut short (no </VTKFile>); use another copy, or the .hdf.series beside it");
  return pvd_entries(path, text, false);
}

std::vector<FrameEntry> read_series(const std::string& path) {
  try {
    const auto json = Json::parse(read_text(path));
    std::vector<FrameEntry> entries;
    for (const auto& file : json.at("files")) {
      const std::string name = file.at("name");
      entries.push_back({step_of(name), file.at("time").get<double>(), name, {}});
    }
    return entries;
  } catch (const Json::exception& error) {
    throw InputError(path + ": damaged or cut short (" + error.what() + "); use another copy");
  }
}

// For a truncated file, the entries whose lines are complete.
std::vector<FrameEntry> whole_lines(const std::string& text) {
  std::vector<FrameEntry> entries;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto json = Json::parse(line.substr(0, line.find_last_of('}') + 1), nullptr, false);
    if (!json.is_object() || !json.contains("name") || !json.contains("time") || !json["name"].is_string() ||
        !json["time"].is_number())
      continue;
    const std::string name = json["name"];
    entries.push_back({step_of(name), json["time"].get<double>(), name, {}});
  }
  return entries;
}

// One frame per line in both formats, for people and diff.
std::string pvd_text(const std::vector<FrameEntry>& entries) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (const FrameEntry& entry : entries) {
    const auto add = [&](std::size_t part, const std::string& file) {
      text +=
          fmt::format("    <DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n", entry.time, part, file);
    };
    add(0, entry.path);
    for (std::size_t k = 0; k < entry.others.size(); ++k) add(k + 1, entry.others[k]);
  }
  return text + "  </Collection>\n</VTKFile>\n";
}

std::string series_text(const std::vector<FrameEntry>& entries) {
  std::string text = "{\n  \"file-series-version\": \"1.0\",\n  \"files\": [";
  const char* separator = "";
  for (const FrameEntry& entry : entries) {
    text += fmt::format("{}\n    {}", separator, Json{{"name", entry.path}, {"time", entry.time}}.dump());
    separator = ",";
  }
  return text + "\n  ]\n}\n";
}

}  // namespace

std::vector<FrameEntry> read_frame_list(const std::string& path) {
  return is_pvd(path) ? read_pvd(path) : read_series(path);
}

FrameListFile::FrameListFile(const std::string& path, std::optional<std::int64_t> restart_step) : path_(path) {
  if (!restart_step || !fs::exists(path)) return;
  try {
    entries_ = read_frame_list(path);
  } catch (const Error&) {  // a run must not fail for its list; the damaged one is kept for inspection
    try {
      entries_ = is_pvd(path) ? pvd_entries(path, read_text(path), true) : whole_lines(read_text(path));
    } catch (const Error&) {  // nothing in it can be read
    }
    fs::rename(path, path + ".stale");
  }
  std::erase_if(entries_, [&](const FrameEntry& entry) { return entry.step < 0 || entry.step > *restart_step; });
  write();
}

void FrameListFile::add(const Clock& clock, const std::string& frame_path, const std::vector<std::string>& others) {
  entries_.push_back({clock.step, clock.time(), frame_path, others});
  write();
}

void FrameListFile::write() const { replace_file(path_, is_pvd(path_) ? pvd_text(entries_) : series_text(entries_)); }

}  // namespace trevi

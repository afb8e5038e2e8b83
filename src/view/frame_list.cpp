#include "view/frame_list.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <regex>

#include "io/files.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

namespace fs = std::filesystem;

constexpr const char* remedy =
    "; a run leaves frames where its scene has a table [output.vtu] or [output.vtkhdf], from its first step on";

std::string list_in(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(path + ": no such file or directory; check the path");
  if (!fs::is_directory(path, error)) {
    if (path.ends_with(".pvd") || path.ends_with(".hdf.series")) return path;
    throw InputError(path + ": not something to play; give a run's directory, its particles.pvd or .hdf.series");
  }
  for (const char* name : {"/particles.pvd", "/particles.hdf.series"}) {
    if (fs::exists(path + name, error)) return path + name;
  }
  throw InputError(path + ": holds no particles.pvd and no particles.hdf.series" + remedy);
}

std::int64_t step_of(const std::string& file, std::size_t place) {
  const std::string name = fs::path(file).filename().string();
  for (const char* suffix : {".pvtu", ".vtu", "_#.vtu", ".hdf"}) {
    if (const auto step = step_in_name(name, "particles_", suffix)) return *step;
  }
  return static_cast<std::int64_t>(place);
}

std::string attribute(const std::string& element, const std::string& name) {
  std::smatch found;
  return std::regex_search(element, found, std::regex("\\b" + name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

std::vector<FrameEntry> read_pvd(const std::string& path) {
  const std::string text = read_text(path);
  if (text.find("</VTKFile>") == std::string::npos)
    throw InputError(path + ": damaged or cut short (no </VTKFile>); use another copy, or the .hdf.series beside it");
  std::vector<FrameEntry> entries;
  static const std::regex data_set("<DataSet\\b[^>]*>");
  for (std::sregex_iterator it(text.begin(), text.end(), data_set), end; it != end; ++it) {
    const std::string time = attribute(it->str(), "timestep"), file = attribute(it->str(), "file");
    char* rest = nullptr;
    const double seconds = std::strtod(time.c_str(), &rest);
    if (file.empty() || time.empty() || *rest != '\0')
      throw InputError(path + ": damaged: " + it->str() + " has no time or no file; use another copy");
    entries.push_back({step_of(file, entries.size()), seconds, file});
  }
  return entries;
}

std::vector<FrameEntry> read_series(const std::string& path) {
  try {
    const auto json = nlohmann::json::parse(read_text(path));
    std::vector<FrameEntry> entries;
    for (const auto& file : json.at("files")) {
      const std::string name = file.at("name");
      entries.push_back({step_of(name, entries.size()), file.at("time").get<double>(), name});
    }
    return entries;
  } catch (const nlohmann::json::exception& error) {
    throw InputError(path + ": damaged or cut short (" + error.what() + "); use another copy");
  }
}

}  // namespace

FrameList::FrameList(const std::string& path) : path_(list_in(path)) {
  stamp_ = fs::last_write_time(path_);
  entries_ = read();
  if (entries_.empty()) throw InputError(path_ + ": lists no frames" + remedy);
}

std::string FrameList::directory() const {
  const std::string parent = fs::path(path_).parent_path().string();
  return parent.empty() ? "." : parent;
}

std::vector<FrameEntry> FrameList::read() const {
  std::vector<FrameEntry> entries = path_.ends_with(".pvd") ? read_pvd(path_) : read_series(path_);
  for (FrameEntry& entry : entries) {
    if (fs::path(entry.path).is_relative()) entry.path = directory() + "/" + entry.path;
  }
  std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return entries;
}

bool FrameList::refresh() {
  std::error_code error;
  const auto stamp = fs::last_write_time(path_, error);
  if (error || stamp == stamp_) return false;
  try {
    std::vector<FrameEntry> entries = read();
    stamp_ = stamp;
    if (entries.empty()) return false;
    entries_ = std::move(entries);
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace trevi

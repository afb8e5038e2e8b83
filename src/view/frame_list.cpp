#include "view/frame_list.hpp"

#include <algorithm>

#include "io/run_directory/files.hpp"
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
  for (const char* name : {vtu_list, vtkhdf_list}) {
    const std::string list = path + "/" + name;
    if (fs::exists(list, error)) return list;
  }
  throw InputError(path + ": holds no particles.pvd and no particles.hdf.series" + remedy);
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
  std::vector<FrameEntry> entries = read_frame_list(path_);
  for (std::size_t index = 0; index < entries.size(); ++index) {
    FrameEntry& entry = entries[index];
    if (entry.step < 0) entry.step = static_cast<std::int64_t>(index);
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

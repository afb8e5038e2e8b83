#include "io/pvd.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "io/files.hpp"

namespace trevi {

namespace {

constexpr const char* opening =
    "<?xml version=\"1.0\"?>\n"
    "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
    "  <Collection>\n";
constexpr const char* closing = "  </Collection>\n</VTKFile>\n";

std::optional<std::int64_t> step_of_frame(const std::string& frame_path) {
  return step_in_name(std::filesystem::path(frame_path).filename().string(), "particles_", ".pvtu");
}

/// The frame's path in a DataSet line; empty for other lines.
std::string frame_in_line(const std::string& line) {
  const std::string key = "file=\"";
  const std::size_t start = line.find(key);
  if (line.find("<DataSet") == std::string::npos || start == std::string::npos) return {};
  const std::size_t from = start + key.size();
  return line.substr(from, line.find('"', from) - from);
}

}  // namespace

PvdFile::PvdFile(const std::string& path, std::optional<std::int64_t> restart_step) : path_(path) {
  if (!restart_step || !std::filesystem::exists(path)) return;
  std::istringstream text(read_text(path));
  for (std::string line; std::getline(text, line);) {
    const auto step = step_of_frame(frame_in_line(line));
    if (step && *step <= *restart_step) entries_.push_back({*step, line});
  }
  write();
}

void PvdFile::add(const Clock& clock, const std::string& frame_path) {
  entries_.push_back({clock.step, fmt::format("    <DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>",
                                              clock.time(), frame_path)});
  write();
}

void PvdFile::write() const {
  std::string text = opening;
  for (const Entry& entry : entries_) text += entry.line + "\n";
  replace_file(path_, text + closing);
}

}  // namespace trevi

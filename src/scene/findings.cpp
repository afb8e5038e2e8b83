#include "scene/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "trevi/error.hpp"

namespace trevi {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

/// Whether the override "path=value" itself fully identifies a problem of `path`.
bool names(std::string_view assignment, std::string_view path) {
  std::string key;
  for (const char c : assignment.substr(0, assignment.find('='))) {
    if (c != ' ' && c != '\t') key += c;
  }
  return key == path;
}

constexpr std::string_view override_mark = "--set ";
constexpr auto sorted_last = std::numeric_limits<toml::source_index>::max();  // where overrides are sorted

toml::source_index line_of(const Place& place) { return std::max<toml::source_index>(1, place.where.begin.line); }

std::string told_of_override(const std::string& assignment, const std::string& message) {
  return fmt::format("--set {}: {}", printable(assignment, longest_message), message);
}

}  // namespace

std::string printable(std::string_view text, std::size_t longest) {
  std::string line;
  for (const char c : text.substr(0, longest)) line += static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
  if (text.size() > longest) {
    while (!line.empty() && (line.back() & 0xC0) == 0x80) line.pop_back();  // no half of a UTF-8 character
    if (!line.empty() && (line.back() & 0x80)) line.pop_back();
    line += "...";
  }
  return line;
}

std::string nearest_word(std::string_view word, std::span<const std::string> known) {
  std::string best;
  std::size_t least = 2 + word.size() / 4;
  for (const std::string& candidate : known) {
    const bool starts = word.size() >= 3 && candidate.size() >= 3 &&
                        (candidate.starts_with(word) || (word.size() < 40 && word.starts_with(candidate)));
    // Words of very different length need not be compared; this also bounds the work for a key of absurd length.
    if (word.size() > 40) continue;
    const std::size_t distance = starts ? 1 : edit_distance(word, candidate);
    if (distance < least && distance < std::max(word.size(), candidate.size())) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

bool Findings::is_override(const Place& place) const {
  return place.where.path && place.where.path->starts_with(override_mark) && *place.where.path != file_;
}

std::string Findings::told(const Place& place, const std::string& message) const {
  if (is_override(place)) {
    const std::string assignment = place.where.path->substr(override_mark.size());
    return told_of_override(assignment, names(assignment, place.path) ? message : place.label + ": " + message);
  }
  return fmt::format("{}:{}: {}: {}", file_, line_of(place), place.label, message);
}

void Findings::add(const Place& place, const std::string& message) {
  problems_.emplace_back(is_override(place) ? sorted_last : line_of(place), told(place, message));
}

void Findings::add_override(const std::string& assignment, const std::string& message) {
  problems_.emplace_back(sorted_last, told_of_override(assignment, message));
}

void Findings::describe(const std::string& line) {
  if (std::find(descriptions_.begin(), descriptions_.end(), line) == descriptions_.end()) descriptions_.push_back(line);
}

void Findings::throw_if_any() const {
  if (problems_.empty()) return;
  auto sorted = problems_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string all;
  for (const auto& problem : sorted) all += (all.empty() ? "" : "\n") + problem.second;
  throw InputError(all);
}

}  // namespace trevi

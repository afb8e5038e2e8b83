// The problems found in a scene: each with its place, all reported at once, in the order of their lines. Not
// collective.
#pragma once

#include <toml++/toml.h>

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace trevi {

/// Text for a message: a single line whatever it contains, truncated if it is long.
inline constexpr std::size_t usual_length = 60, longest_message = 300;
std::string printable(std::string_view text, std::size_t longest = usual_length);

/// The known word that was most likely meant; empty if none is similar.
std::string nearest_word(std::string_view word, std::span<const std::string> known);

struct Place {
  toml::source_region where;
  std::string path;   ///< "fluid.spacing", as --set names it
  std::string label;  ///< "[fluid] spacing", as messages name it
};

/// What was wrong with a scene, and what a scene may contain.
class Findings {
 public:
  explicit Findings(std::string file) : file_(std::move(file)) {}
  void add(const Place& place, const std::string& message);
  /// A problem in the form in which add() would report it.
  std::string told(const Place& place, const std::string& message) const;
  /// A problem of an override that has no place in the document.
  void add_override(const std::string& assignment, const std::string& message);
  void describe(const std::string& line);
  /// Throws InputError with one problem per line, in the order of the file, overrides last; returns if nothing was
  /// found.
  void throw_if_any() const;
  const std::vector<std::string>& descriptions() const { return descriptions_; }

 private:
  friend class Section;
  bool is_override(const Place& place) const;
  bool pairs_ = false;  ///< whether vectors may leave y out
  std::string file_;
  std::vector<std::pair<toml::source_index, std::string>> problems_;  ///< line for sorting, message
  std::vector<std::string> descriptions_;
};

}  // namespace trevi

#include "scene/scene_overrides.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <regex>

#include "trevi/error.hpp"

namespace trevi {
namespace {

// toml++ follows a dotted key by recursion, so a line with many thousand dots would exhaust the stack.
constexpr std::size_t longest_line = 4096;

bool is_plain_word(std::string_view text) {
  constexpr std::string_view marks = "_-./:~+@%";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](unsigned char c) {
    return std::isalnum(c) || marks.find(static_cast<char>(c)) != std::string_view::npos;
  });
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// "0.01" for ".01", "1.0e3" for "1.e3", and so on; empty for text that is not a number, or is valid as it is.
std::string number_meant(const std::string& text) {
  static const std::regex number("([+-]?)([0-9]*)\\.([0-9]*)([eE][+-]?[0-9]+)?");
  constexpr std::size_t longest_number = 40;  // the regex works by recursion
  std::smatch part;
  if (text.size() > longest_number || !std::regex_match(text, part, number)) return {};
  const std::string before = part[2], after = part[3];
  if (before.empty() == after.empty()) return {};
  return part[1].str() + (before.empty() ? "0" : before) + "." + (after.empty() ? "0" : after) + part[4].str();
}

/// TOML's message about a text that it cannot read; for .01 and 5., which are numbers elsewhere, what to write instead.
std::string toml_problem(std::string_view text, const toml::parse_error& error) {
  const toml::source_position at = error.source().begin;
  for (toml::source_index line = 1; line < at.line && text.find('\n') != std::string_view::npos; ++line)
    text.remove_prefix(text.find('\n') + 1);
  text = text.substr(0, text.find_first_of("\r\n"));
  const std::size_t column = std::min<std::size_t>(at.column, text.size());  // from 1, so that it is behind the point
  constexpr std::string_view of_numbers = "+-.0123456789eE";
  const std::size_t before = text.substr(0, column > 0 ? column - 1 : 0).find_last_not_of(of_numbers);
  const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
  const std::size_t end = std::min(text.find_first_not_of(of_numbers, begin), text.size());
  const std::string number = number_meant(std::string(text.substr(begin, end - begin)));
  if (!number.empty()) return fmt::format("TOML has digits on both sides of a point; write {}", number);
  return fmt::format("not valid TOML: {}", printable(error.description(), longest_message));
}

/// "a.0.b = 1" is itself a TOML document with a key named 0, which is how an element of a list is addressed.
std::optional<toml::table> parse_override(const std::string& assignment, Findings& findings) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || assignment.find_first_of("\r\n") != std::string::npos ||
      assignment.size() > longest_line) {
    findings.add_override(assignment, "not of the form table.key=value");
    return std::nullopt;
  }
  try {
    toml::table table = toml::parse(assignment, "--set " + assignment);
    if (!table.empty()) return table;
    findings.add_override(assignment, "not of the form table.key=value");
  } catch (const toml::parse_error& error) {
    const std::string_view value = trimmed(std::string_view(assignment).substr(equals + 1));
    // A shell removes the quotes of "chebyshev", so a plain word represents itself.
    if (is_plain_word(value) && number_meant(std::string(value)).empty()) {
      try {
        return toml::parse(assignment.substr(0, equals) + "=\"" + std::string(value) + '"', "--set " + assignment);
      } catch (const toml::parse_error&) {  // then the key is at fault, which the first message says
      }
    }
    findings.add_override(assignment, toml_problem(assignment, error));
  }
  return std::nullopt;
}

std::optional<std::size_t> list_index(std::string_view key) {
  std::size_t index = 0;
  const auto [end, problem] = std::from_chars(key.data(), key.data() + key.size(), index);
  return problem == std::errc() && end == key.data() + key.size() ? std::optional(index) : std::nullopt;
}

bool is_indexed(const toml::table& table) {
  return !table.empty() && std::all_of(table.begin(), table.end(),
                                       [](auto&& entry) { return list_index(entry.first.str()).has_value(); });
}

/// Applies one override to the document. Nodes are moved, which keeps their origin; copies would lose it.
class Overlay {
 public:
  Overlay(const std::string& assignment, Findings& findings) : assignment_(assignment), findings_(findings) {}

  void merge(toml::table& into, toml::table& from) {
    for (auto&& [key, value] : from) {
      toml::table* table = value.as_table();
      toml::node* present = into.get(key.str());
      if (table && is_indexed(*table) && (!present || present->is_array())) {
        if (!present) present = &into.insert(key, toml::array{}).first->second;
        merge_elements(*present->as_array(), *table, key.str());
      } else if (table && present && present->is_array_of_tables()) {
        findings_.add_override(assignment_, fmt::format("say which [[{0}]]: {0}.0.key=value", printable(key.str())));
      } else if (table && present && present->is_table()) {
        merge(*present->as_table(), *table);
      } else {
        into.insert_or_assign(key, std::move(value));
      }
    }
  }

 private:
  void merge_elements(toml::array& into, toml::table& from, std::string_view name) {
    for (auto&& [key, value] : from) {
      const std::size_t index = *list_index(key.str());
      if (index > into.size()) {
        findings_.add_override(assignment_,
                               fmt::format("no such element; the next new one is {}.{}", printable(name), into.size()));
      } else if (index == into.size()) {
        into.push_back(std::move(value));
      } else if (into[index].is_table() && value.is_table()) {
        merge(*into[index].as_table(), *value.as_table());
      } else {
        into.replace(into.cbegin() + static_cast<std::ptrdiff_t>(index), std::move(value));
      }
    }
  }

  const std::string& assignment_;
  Findings& findings_;
};

/// Line of the first line that is too long, or 0.
std::size_t overlong_line(std::string_view text) {
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    if (length > longest_line) return line;
    text.remove_prefix(std::min(length + 1, text.size()));
  }
  return 0;
}

}  // namespace

toml::table read_document(const std::string& path, const std::string& text, const std::vector<std::string>& overrides,
                          Findings& findings) {
  if (const std::size_t line = overlong_line(text)) {
    throw InputError(fmt::format("{}:{}: a line of more than {} characters; is it a scene?", path, line, longest_line));
  }
  toml::table document;
  try {
    document = toml::parse(text, std::string(path));
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: {}", path, error.source().begin.line, toml_problem(text, error)));
  }
  for (const std::string& assignment : overrides) {
    auto table = parse_override(assignment, findings);
    if (table) Overlay(assignment, findings).merge(document, *table);
  }
  return document;
}

}  // namespace trevi

#include "scene/scene_reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "trevi/error.hpp"

namespace trevi {
namespace {

std::string in_quotes(std::string_view text) { return '"' + printable(text) + '"'; }

std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) return in_quotes(text->get());
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* real = node.as_floating_point()) {
    const std::string digits = fmt::format("{}", real->get());
    // 4.0 given for a whole number must not be shown as 4.
    return digits.find_first_not_of("-0123456789") == std::string::npos ? digits + ".0" : digits;
  }
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  const auto* array = node.as_array();
  if (!array) return "a date or time";
  std::string all;
  for (const toml::node& element : *array) {
    if (all.size() > usual_length) break;
    all += (all.empty() ? "" : ", ") + shown(element);
  }
  return '[' + printable(all) + ']';
}

// 0 if it came from an override.
int line_in_file(const toml::source_region& where) {
  return where.path && where.path->starts_with("--set ") ? 0 : static_cast<int>(where.begin.line);
}

std::optional<Real> finite_number(const toml::node& node) {
  const auto value = node.is_number() ? node.value<Real>() : std::nullopt;
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace

bool Interval::contains(Real value) const {
  return (with_low ? value >= low : value > low) && (with_high ? value <= high : value < high);
}

std::string Interval::rule() const {
  if (std::isfinite(high)) {
    return fmt::format("must lie in {}{}, {}{}", with_low ? '[' : '(', low, high, with_high ? ']' : ')');
  }
  if (low == 0) return with_low ? "must not be negative" : "must be positive";
  return fmt::format("must be {} {}", with_low ? "at least" : "above", low);
}

Section::Section(const toml::table& root, Findings& findings)
    : Section(&root, Place{root.source(), "", ""}, findings) {}

Section::Section(const toml::table* table, Place place, Findings& findings)
    : table_(table), place_(std::move(place)), findings_(&findings) {}

const toml::table* Section::accept_table(const toml::node& node, const Place& place, const std::string& what) {
  if (!node.is_table())
    findings_->add(place,
                   fmt::format("must be {}, got {}; write {} on a line of its own", what, shown(node), place.label));
  return node.as_table();
}

Section Section::child(const std::string& name) {
  if (std::find(known_.begin(), known_.end(), name) == known_.end()) known_.push_back(name);
  const std::string path = place_.path.empty() ? name : place_.path + '.' + name;
  // TOML's own header of a table in a list has no number: [obstacle.motion].
  std::string label = place_.label;
  std::erase_if(label, [](char c) { return c == '[' || c == ']'; });
  Place place{place_.where, path, fmt::format("[{}{}{}]", label, label.empty() ? "" : ".", name)};
  const toml::node* node = table_ ? table_->get(name) : nullptr;
  const toml::table* table = nullptr;
  if (node) {
    place.where = node->source();
    table = accept_table(*node, place, "a table");
  }
  Section section(table, place, *findings_);
  section.malformed_ = node && !table;
  return section;
}

std::vector<Section> Section::children(const std::string& name) {
  known_.push_back(name);
  std::vector<Section> sections;
  const toml::node* node = table_ ? table_->get(name) : nullptr;
  if (!node) return sections;
  const std::string path = place_.path.empty() ? name : place_.path + '.' + name;
  std::string outer = place_.label;
  std::erase_if(outer, [](char c) { return c == '[' || c == ']'; });
  const std::string label = fmt::format("[[{}{}{}]]", outer, outer.empty() ? "" : ".", name);
  const toml::array* array = node->as_array();
  if (!array)
    fail(name.c_str(), fmt::format("must be a list of tables, got {}; write {} above each", shown(*node), label));
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    const Place place{(*array)[i].source(), fmt::format("{}.{}", path, i), label};
    const toml::table* table = accept_table((*array)[i], place, "a list of tables");
    if (!table) failed_.insert(name);
    if (table) sections.push_back(Section(table, place, *findings_));
  }
  return sections;
}

const toml::node* Section::find(const Key& key, const std::string& type) {
  known_.emplace_back(key.name);
  findings_->describe(
      fmt::format("{} {}: {}; {}{}", place_.label, key.name, type, key.meaning, key.required ? "; required" : ""));
  const toml::node* node = table_ ? table_->get(key.name) : nullptr;
  if (node || !key.required) return node;
  if (malformed_) {
    failed_.insert(key.name);
  } else {
    fail(key.name, fmt::format("missing; give {}", key.meaning));
  }
  return nullptr;
}

void Section::fail(const char* key, const std::string& message) {
  failed_.insert(key);
  findings_->add(place_of(key), message);
}

void Section::refuse(const Key& key, const std::string& what) {
  fail(key.name, fmt::format("{}, got {}; give {}", what, shown(*table_->get(key.name)), key.meaning));
}

bool Section::check(const char* key, bool holds, const std::string& message) {
  // The negation also catches a NaN that arithmetic on huge but finite values produced.
  if (fine(key) && !holds) fail(key, message);
  return fine(key);
}

bool Section::number(const Key& key, Real& target, const Interval& range) {
  const toml::node* node = find(key, "number");
  if (!node) return false;
  const auto value = finite_number(*node);
  if (!value || !range.contains(*value)) {
    refuse(key, !node->is_number() ? "must be a number" : value ? range.rule() : "must be finite");
    return false;
  }
  target = *value;
  return true;
}

bool Section::numbers(const Key& key, std::span<Real> target) {
  const toml::node* node = find(key, fmt::format("{} numbers", target.size()));
  if (!node) return false;
  const toml::array* array = node->as_array();
  std::vector<Real> values;
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    if (const auto value = finite_number((*array)[i])) values.push_back(*value);
  }
  if (!array || array->size() != target.size() || values.size() != target.size()) {
    refuse(key, fmt::format("must be a list of {} finite numbers", target.size()));
    return false;
  }
  std::copy(values.begin(), values.end(), target.begin());
  return true;
}

bool Section::numbers(const Key& key, Vec3& target) {
  const toml::array* given = present() ? table_->get_as<toml::array>(key.name) : nullptr;
  if (!findings_->pairs_ || given == nullptr || given->size() != 2) return numbers(key, {target.data(), 3});
  std::array<Real, 2> pair{};
  const bool good = numbers(key, pair);
  if (good) target = Vec3(pair[0], 0, pair[1]);
  return good;
}

bool Section::integer_between(const Key& key, std::int64_t& target, std::pair<std::int64_t, std::int64_t> bounds) {
  const toml::node* node = find(key, "integer");
  if (!node) return false;
  const auto* value = node->as_integer();
  if (!value || value->get() < bounds.first || value->get() > bounds.second) {
    refuse(key, !value                        ? "must be a whole number without a decimal point"
                : value->get() < bounds.first ? fmt::format("must be at least {}", bounds.first)
                                              : fmt::format("must be at most {}", bounds.second));
    return false;
  }
  target = value->get();
  return true;
}

bool Section::direction(const Key& key, Vec3& target) {
  Vec3 given;
  if (!numbers(key, given)) return false;
  const Vec3 unit = given.stableNormalized();  // zero, too, if the length exceeds the range of numbers
  const bool points = check(key.name, unit.squaredNorm() > 0.5, "must not be zero; give a direction of any length");
  if (points) target = unit;
  return points;
}

bool Section::flag(const Key& key, bool& target) {
  const toml::node* node = find(key, "true or false");
  if (!node) return false;
  const auto* value = node->as_boolean();
  if (!value) {
    refuse(key, "must be true or false, without quotes");
    return false;
  }
  target = value->get();
  return true;
}

bool Section::text(const Key& key, std::string& target) {
  const toml::node* node = find(key, "text");
  if (!node) return false;
  const auto* value = node->as_string();
  // A path with a NUL in it would silently name another file.
  if (!value || value->get().empty() || value->get().find('\0') != std::string::npos) {
    refuse(key, "must be text in quotes, not empty");
    return false;
  }
  target = value->get();
  return true;
}

bool Section::texts(const Key& key, std::vector<std::string>& target) {
  const toml::node* node = find(key, "list of texts");
  if (!node) return false;
  const toml::array* array = node->as_array();
  std::vector<std::string> values;
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    if (const auto* value = (*array)[i].as_string()) values.push_back(value->get());
  }
  if (!array || values.size() != array->size()) {
    refuse(key, "must be a list of texts in quotes");
    return false;
  }
  target = values;
  return true;
}

int Section::pick(const Key& key, std::span<const std::string> options) {
  const std::string words = fmt::format("\"{}\"", fmt::join(options, "\" or \""));
  const toml::node* node = find(key, words);
  if (!node) return -1;
  const auto* value = node->as_string();
  const auto found = value ? std::find(options.begin(), options.end(), value->get()) : options.end();
  if (found != options.end()) return static_cast<int>(found - options.begin());
  const std::string meant = value ? nearest_word(value->get(), options) : "";
  const std::string hint = meant.empty() ? "" : fmt::format("; did you mean \"{}\"?", meant);
  fail(key.name, fmt::format("must be {}, got {}{}", words, shown(*node), hint));
  return -1;
}

bool Section::choice(const Key& key, std::string& target, std::span<const std::string> options) {
  const int chosen = pick(key, options);
  if (chosen >= 0) target = options[static_cast<std::size_t>(chosen)];
  return chosen >= 0;
}

Place Section::place_of(const std::string& key) const {
  const toml::node* node = table_ ? table_->get(key) : nullptr;
  const std::string space = place_.label.empty() ? "" : " ", dot = place_.path.empty() ? "" : ".";
  return {node ? node->source() : place_.where, place_.path + dot + key, place_.label + space + printable(key)};
}

int Section::line() const { return line_in_file(place_.where); }

int Section::line_of(const char* key) const { return line_in_file(place_of(key).where); }

void Section::reject_unknown() {
  if (!table_) return;
  for (auto&& [key, node] : *table_) {
    const std::string name(key.str());
    if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
    const bool is_table = node.is_table() || node.is_array_of_tables();
    Place place = place_of(name);
    if (is_table) place.label = fmt::format("[{}]", printable(place.path));
    const std::string meant = nearest_word(name, known_);
    findings_->add(place, fmt::format("unknown {}; {}", is_table ? "table" : "key",
                                      meant.empty() ? fmt::format("known here: {}", fmt::join(known_, ", "))
                                                    : fmt::format("did you mean {}?", meant)));
  }
}

}  // namespace trevi

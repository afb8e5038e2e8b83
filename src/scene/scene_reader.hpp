// Reading a TOML table into plain members: types, ranges, missing and unknown keys. A Section never throws for invalid
// input: it hands each problem to Findings, leaves the target unchanged and continues, so that one pass finds all
// problems. Findings also keeps the keys that were asked for, which is the reference. Nothing here knows what a scene
// is. Not collective; the same document gives the same findings on all ranks.
#pragma once

#include <toml++/toml.h>

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/findings.hpp"
#include "trevi/types.hpp"

namespace trevi {

struct Key {
  const char* name;
  const char* meaning;  ///< with its unit; completes the sentence "give ..."
  bool required = false;
};

/// Finite numbers from low to high, with the ends included or not.
struct Interval {
  Real low = -std::numeric_limits<Real>::infinity(), high = std::numeric_limits<Real>::infinity();
  bool with_low = true, with_high = true;
  bool contains(Real value) const;
  std::string rule() const;  ///< "must be positive"
};
inline Interval above(Real low) { return {.low = low, .with_low = false}; }
inline Interval at_least(Real low) { return {.low = low}; }

/// What in a scene is known to be valid before the tables that depend on it are read.
struct KnownGood {
  bool box, spacing;
};

class Section {
 public:
  Section(const toml::table& root, Findings& findings);

  /// The table `name` of this one; absent: a section without keys. Array: one section for each [[name]].
  Section child(const std::string& name);
  std::vector<Section> children(const std::string& name);

  /// These return whether the key was given and valid; only then is the target written.
  bool number(const Key& key, Real& target, const Interval& range = {});
  bool numbers(const Key& key, std::span<Real> target);
  /// [x, y, z], or, in a two-dimensional scene, [x, z] with y = 0.
  bool numbers(const Key& key, Vec3& target);
  /// Any length except zero; the target is normalized to length 1.
  bool direction(const Key& key, Vec3& target);
  bool flag(const Key& key, bool& target);
  bool text(const Key& key, std::string& target);
  bool texts(const Key& key, std::vector<std::string>& target);
  template <std::integral T>
  bool integer(const Key& key, T& target, std::int64_t least);
  template <class E>
  bool choice(const Key& key, E& target, const std::vector<std::pair<const char*, E>>& options);
  bool choice(const Key& key, std::string& target, std::span<const std::string> options);

  /// The value of a key that may have several types, and the way to refuse it.
  const toml::node* find(const Key& key, const std::string& type);
  void refuse(const Key& key, const std::string& what);

  /// A rule between keys: reported once, and only if the key was valid so far.
  bool check(const char* key, bool holds, const std::string& message);
  /// Such a message, for problems that only the run finds.
  std::string told(const char* key, const std::string& message) const {
    return findings_->told(place_of(key), message);
  }

  bool present() const { return table_ != nullptr; }
  bool given(const char* key) const { return table_ && table_->contains(key); }
  bool fine(const char* key) const { return !failed_.contains(key); }
  /// From now on vectors of the document may be [x, z].
  void allow_pairs() { findings_->pairs_ = true; }
  /// The line in the scene file; 0 if the table came from an override.
  int line() const;
  /// The same for a key.
  int line_of(const char* key) const;
  /// Reports the keys that were not asked for; call last.
  void reject_unknown();

 private:
  Section(const toml::table* table, Place place, Findings& findings);
  const toml::table* accept_table(const toml::node& node, const Place& place, const std::string& what);
  void fail(const char* key, const std::string& message);
  bool integer_between(const Key& key, std::int64_t& target, std::pair<std::int64_t, std::int64_t> bounds);
  int pick(const Key& key, std::span<const std::string> options);
  Place place_of(const std::string& key) const;

  const toml::table* table_;
  Place place_;
  Findings* findings_;
  bool malformed_ = false;  ///< something else is in the table's place, so nothing is missing from it
  std::vector<std::string> known_;
  std::set<std::string, std::less<>> failed_;
};

template <std::integral T>
bool Section::integer(const Key& key, T& target, std::int64_t least) {
  std::int64_t value = 0;
  constexpr auto most = std::cmp_less(std::numeric_limits<T>::max(), std::numeric_limits<std::int64_t>::max())
                            ? static_cast<std::int64_t>(std::numeric_limits<T>::max())
                            : std::numeric_limits<std::int64_t>::max();
  if (!integer_between(key, value, {least, most})) return false;
  target = static_cast<T>(value);
  return true;
}

template <class E>
bool Section::choice(const Key& key, E& target, const std::vector<std::pair<const char*, E>>& options) {
  std::vector<std::string> words;
  for (const auto& option : options) words.emplace_back(option.first);
  const int chosen = pick(key, words);
  if (chosen < 0) return false;
  target = options[static_cast<std::size_t>(chosen)].second;
  return true;
}

}  // namespace trevi

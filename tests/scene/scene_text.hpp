// A small good scene for the tests of the scene reader, with one line changed or more appended.
// Its path is "in/s.toml", so that messages begin with that.
#pragma once

#include <string>
#include <vector>

#include "trevi/error.hpp"
#include "trevi/scene.hpp"

namespace trevi::test {

inline const std::vector<std::string> good_lines = {
    "[domain]",           // 1
    "min = [0, 0, 0]",    // 2
    "max = [2, 1, 1]",    // 3
    "[fluid]",            // 4
    "spacing = 0.1",      // 5
    "[[particles]]",      // 6
    "min = [0, 0, 0]",    // 7
    "max = [1, 1, 0.5]",  // 8
    "[time]",             // 9
    "dt = 0.01",          // 10
    "end = 1",            // 11
};
inline constexpr int appended = 12;  ///< in place of a line number: after the last line, so at line 12

inline std::string scene_with(int line, const std::string& replacement) {
  std::string text;
  for (int i = 1; i < appended; ++i)
    text += (i == line ? replacement : good_lines[static_cast<std::size_t>(i) - 1]) + '\n';
  return line == appended ? text + replacement + '\n' : text;
}

inline std::string scene_plus(const std::string& more = "") { return scene_with(appended, more); }

inline Scene parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_scene("in/s.toml", text, overrides);
}

inline std::string problems(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace trevi::test

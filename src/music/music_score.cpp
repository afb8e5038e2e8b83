// Text scores: note names and the line format.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "music/music.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

/// A list with more problems than this tells nothing new.
constexpr int max_problems = 10;

std::optional<Real> number_of(std::string_view word) {
  Real value = 0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (problem != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// The words of a line up to a comment. A # within a word is a sharp.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view blanks = " \t\r\v\f";
  for (std::size_t at = 0; (at = line.find_first_not_of(blanks, at)) != std::string_view::npos;) {
    if (line[at] == '#') break;
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::string shown(std::string_view word) {
  std::string text(word.substr(0, 40));
  for (char& c : text) c = c >= ' ' && c <= '~' ? c : '?';
  return '"' + text + '"';
}

/// The note of a line, or the reason why it has none.
struct Line {
  Tone note;
  std::string problem;
};

Line read_line(const std::vector<std::string_view>& words) {
  if (words.size() != 3) {
    return {{},
            "expected time, pitch and length, got " + std::to_string(words.size()) +
                " words; write for example 1.5 C4 0.5"};
  }
  const std::optional<Real> time = number_of(words[0]), length = number_of(words[2]);
  std::optional<Real> pitch = number_of(words[1]);
  if (!pitch) pitch = note_number(words[1]);
  if (!time || *time < 0) return {{}, "time must be a number of seconds from 0 on, got " + shown(words[0])};
  if (!pitch || !(*pitch >= 0 && *pitch <= 127)) {
    return {{},
            "pitch must be a note name such as C4, F#5 or Bb3, or a MIDI number from 0 to 127, got " + shown(words[1])};
  }
  if (!length || !(*time + *length > *time))
    return {{}, "length must be a positive number of seconds, got " + shown(words[2])};
  return {{*time, *time + *length, *pitch}, {}};
}

}  // namespace

std::optional<Real> note_number(std::string_view name) {
  constexpr std::string_view letters = "C D EF G A B";  // the index of a letter is its semitone
  if (name.empty() || name[0] == ' ') return std::nullopt;
  const char letter = static_cast<char>(name[0] >= 'a' && name[0] <= 'g' ? name[0] - 'a' + 'A' : name[0]);
  const std::size_t semitone = letters.find(letter);
  if (semitone == std::string_view::npos) return std::nullopt;
  name.remove_prefix(1);
  int shift = 0;
  if (!name.empty() && (name[0] == '#' || name[0] == 'b')) {
    shift = name[0] == '#' ? 1 : -1;
    name.remove_prefix(1);
  }
  int octave = 0;
  const auto [end, problem] = std::from_chars(name.data(), name.data() + name.size(), octave);
  if (problem != std::errc() || end != name.data() + name.size() || octave < -1 || octave > 9) return std::nullopt;
  return 12 * (octave + 1) + static_cast<int>(semitone) + shift;
}

Melody read_score(const std::string& name, const std::string& text) {
  std::vector<Tone> notes;
  std::string problems;
  int count = 0, number = 0;
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // the byte order mark of some editors
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::vector<std::string_view> words = words_of(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    if (words.empty()) continue;
    const Line line = read_line(words);
    if (line.problem.empty()) {
      notes.push_back(line.note);
    } else if (++count <= max_problems) {
      problems += (problems.empty() ? "" : "\n") + name + ":" + std::to_string(number) + ": " + line.problem;
    }
  }
  if (count > max_problems) problems += "\n" + name + ": " + std::to_string(count - max_problems) + " more bad lines";
  if (!problems.empty()) throw InputError(problems);
  if (notes.empty()) {
    throw InputError(name + ":" + std::to_string(std::max(number, 1)) +
                     ": no note in the whole score; write lines such as 0.0 C4 0.5 (time, pitch, length)");
  }
  return melody_of_notes(std::move(notes));
}

}  // namespace trevi

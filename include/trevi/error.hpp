// Errors that a user of Trevi may encounter, each with the exit code of the program: 2 for bad input, 3 for a failed
// run. Input errors are found by all ranks alike, before anything is written. A run error may occur on a single rank.
// It records whether all ranks threw it (Reach), because only then may the program still communicate. Bugs of Trevi
// itself are caught by asserts and are not errors in this sense.
#pragma once

#include <stdexcept>
#include <string>

namespace trevi {

enum class ExitCode : int { done = 0, bad_input = 2, run_failed = 3, stopped = 4 };

/// Who threw an error: this rank, or all of them at the same point of the program.
enum class Reach { one_rank, all_ranks };

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, Reach reach, const std::string& message)
      : std::runtime_error(message), code_(code), reach_(reach) {}
  ExitCode code() const { return code_; }
  Reach reach() const { return reach_; }

 private:
  ExitCode code_;
  Reach reach_;
};

/// Bad input or usage. The message is for the user and names file, line, key and remedy where they are known.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::bad_input, Reach::all_ranks, message) {}
};

/// The run failed (blow-up, disk, a library). The message names rank, step and particle where they are known.
class RunError : public Error {
 public:
  explicit RunError(const std::string& message, Reach reach = Reach::one_rank)
      : Error(ExitCode::run_failed, reach, message) {}
};

/// The run has become unstable. Thrown by all ranks alike; the solver still holds its particles for inspection.
class BlowUp : public RunError {
 public:
  explicit BlowUp(const std::string& message) : RunError(message, Reach::all_ranks) {}
};

/// Throws RunError with the location of the call unless `condition` holds. Clang before 16 lacks std::source_location,
/// but has the built-in functions on which it rests.
inline void require(bool condition, const std::string& message, const char* file = __builtin_FILE(),
                    int line = __builtin_LINE()) {
  if (!condition) throw RunError(message + " [" + file + ":" + std::to_string(line) + "]");
}

}  // namespace trevi

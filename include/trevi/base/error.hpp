// Errors that a user of Trevi can meet, each with the exit code of the program (contract: 2 bad input, 3 the run
// failed). Input errors are found by all ranks alike, before anything is written; run errors may strike one rank alone.
// Internal bugs are asserts, not errors.
#pragma once

#include <source_location>
#include <stdexcept>
#include <string>

namespace trevi {

enum class ExitCode : int { done = 0, bad_input = 2, run_failed = 3, stopped = 4 };

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// Bad input or usage: the message is for the user and names file, line, key and remedy where they are known.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : Error(ExitCode::bad_input, message) {}
};

/// The run failed (blow-up, disk, a library): the message names rank, step and particle where they are known.
class RunError : public Error {
 public:
  explicit RunError(const std::string& message) : Error(ExitCode::run_failed, message) {}
};

/// Throws RunError with the calling place unless `condition` holds.
inline void require(bool condition, const std::string& message,
                    std::source_location where = std::source_location::current()) {
  if (!condition) throw RunError(message + " [" + where.file_name() + ":" + std::to_string(where.line()) + "]");
}

}  // namespace trevi

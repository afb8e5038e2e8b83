// A program started by this one. Rank-local, not collective.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace trevi {

struct ChildOptions {
  bool quiet = false;        ///< its output is discarded
  bool own_session = false;  ///< it outlives us: neither Ctrl-C in our terminal nor the terminal's end reaches it
};

class Child {
 public:
  /// `words`: the program, looked up in PATH, and its arguments. RunError if it cannot be started.
  explicit Child(const std::vector<std::string>& words, const ChildOptions& options = {});

  /// Its exit code once it has ended (128 + signal if it was killed). Never waits.
  std::optional<int> exit_code();
  /// Sends SIGTERM, and waits for the end; for programs that obey at once.
  void terminate();

 private:
  pid_t id_ = -1;
  std::optional<int> code_;
};

/// The first of the programs that is in PATH.
std::optional<std::string> find_program(const std::vector<std::string>& names);

}  // namespace trevi

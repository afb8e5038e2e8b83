// A program started beside this one. Rank-local, not collective.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace trevi {

struct ChildOptions {
  bool quiet = false;        ///< its output goes nowhere
  bool own_session = false;  ///< it outlives us: no Ctrl-C of our terminal, no end of it, reaches it
};

class Child {
 public:
  /// `words`: the program, looked up in PATH, and its arguments. RunError when it cannot be started.
  explicit Child(const std::vector<std::string>& words, const ChildOptions& options = {});

  /// Its exit code once it has ended (128 + signal when it was killed). Never waits.
  std::optional<int> exit_code();
  /// SIGTERM, and waits for the end; for programs that obey at once.
  void terminate();

 private:
  pid_t id_ = -1;
  std::optional<int> code_;
};

/// The first of the programs that PATH knows.
std::optional<std::string> find_program(const std::vector<std::string>& names);

}  // namespace trevi

// Shows the progress of a run to the user: a bar redrawn in place on a terminal, a line every few seconds in a log.
// Invariant: a bar never takes more than one line of the terminal, and the last output always ends with a newline. Rank
// 0 prints, to stderr; without communication, so the cost is one clock reading per step. Under mpirun the ranks' stderr
// is a pipe: `automatic` then prints lines, and `bar` has to be asked for.
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

enum class ProgressMode { automatic, bar, lines, none };

struct ProgressOptions {
  ProgressMode mode = ProgressMode::automatic;
  std::int64_t first_step = 0, last_step = 0;  ///< of this run: a restart begins at its checkpoint's step
  std::FILE* sink = stderr;
  int width = 0;               ///< columns; 0: ask the terminal
  double line_interval = 5.0;  ///< s
  double bar_interval = 0.1;   ///< s
};

class Progress : public Observer {
 public:
  Progress(MPI_Comm comm, ProgressOptions options);
  ~Progress() override;

  bool due(const Clock&) const override { return true; }
  void observe(const Frame& frame) override;
  void finish(const Frame& frame) override;

 private:
  using Instant = std::chrono::steady_clock::time_point;
  void measure(std::int64_t step, Instant now);
  void print(const Clock& clock);
  std::string status(const Clock& clock) const;
  std::string bar(const Clock& clock) const;
  double fraction(const Clock& clock) const;
  int columns() const;

  ProgressOptions options_;
  ProgressMode mode_ = ProgressMode::none;  ///< none on all ranks but 0
  Instant last_print_;
  std::int64_t last_print_step_;
  double seconds_per_step_ = -1;  ///< smoothed; negative: not known yet
  bool line_open_ = false;        ///< a bar has been drawn without its newline
};

}  // namespace trevi

#include "io/run_directory/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace trevi {

namespace {

double seconds_between(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

std::string duration_text(double seconds) {
  if (seconds < 0) return "--:--";
  const auto s = static_cast<std::int64_t>(std::llround(seconds));
  if (s < 3600) return fmt::format("{}:{:02}", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

}  // namespace

Progress::Progress(MPI_Comm comm, ProgressOptions options)
    : options_(options), last_print_(std::chrono::steady_clock::now()), last_print_step_(options.first_step) {
  if (rank_of(comm) != 0) return;
  const bool terminal = ::isatty(::fileno(options_.sink)) == 1;
  mode_ = options_.mode;
  if (mode_ == ProgressMode::automatic) mode_ = terminal ? ProgressMode::bar : ProgressMode::lines;
}

Progress::~Progress() {
  if (line_open_) std::fputs("\n", options_.sink);
}

void Progress::observe(const Frame& frame) {
  if (mode_ == ProgressMode::none) return;
  const Instant now = std::chrono::steady_clock::now();
  const double interval = mode_ == ProgressMode::bar ? options_.bar_interval : options_.line_interval;
  if (seconds_between(last_print_, now) < interval) return;
  measure(frame.clock.step, now);
  print(frame.clock);
}

void Progress::finish(const Frame& frame) {
  if (mode_ == ProgressMode::none) return;
  const bool told = seconds_per_step_ >= 0 && last_print_step_ == frame.clock.step;
  if (mode_ == ProgressMode::lines && told) return;
  measure(frame.clock.step, std::chrono::steady_clock::now());
  print(frame.clock);
  if (line_open_) std::fputs("\n", options_.sink);
  std::fflush(options_.sink);
  line_open_ = false;
}

void Progress::measure(std::int64_t step, Instant now) {
  const std::int64_t steps = step - last_print_step_;
  if (steps > 0) {
    const double latest = seconds_between(last_print_, now) / static_cast<double>(steps);
    // Smoothed, so that a slow frame does not make the remaining time jump.
    seconds_per_step_ = seconds_per_step_ < 0 ? latest : 0.7 * seconds_per_step_ + 0.3 * latest;
    last_print_step_ = step;
  }
  last_print_ = now;
}

void Progress::print(const Clock& clock) {
  if (mode_ == ProgressMode::bar) {
    std::fputs(("\r" + bar(clock) + "\x1b[K").c_str(), options_.sink);
    line_open_ = true;
  } else {
    std::fputs((status(clock) + "\n").c_str(), options_.sink);
  }
  std::fflush(options_.sink);
}

double Progress::fraction(const Clock& clock) const {
  if (options_.last_step <= 0) return 1;
  return std::clamp(static_cast<double>(clock.step) / static_cast<double>(options_.last_step), 0.0, 1.0);
}

std::string Progress::status(const Clock& clock) const {
  const double left = static_cast<double>(std::max<std::int64_t>(0, options_.last_step - clock.step));
  const double eta = seconds_per_step_ < 0 ? -1 : left * seconds_per_step_;
  const std::string pace =
      seconds_per_step_ < 0 ? "-- ms/step" : fmt::format("{:.1f} ms/step", 1e3 * seconds_per_step_);
  return fmt::format("{:5.1f}%  step {}/{}  t {:.3f} s  {}  ETA {}", 100 * fraction(clock), clock.step,
                     options_.last_step, clock.time(), pace, duration_text(eta));
}

std::string Progress::bar(const Clock& clock) const {
  // One column stays free: a full line would make some terminals wrap.
  const int room = std::max(1, columns() - 1);
  std::string text = status(clock);
  const int cells = std::min(40, room - static_cast<int>(text.size()) - 4);
  if (cells >= 5) {
    const auto full = static_cast<std::size_t>(fraction(clock) * cells);
    text = "[" + std::string(full, '#') + std::string(static_cast<std::size_t>(cells) - full, '.') + "] " + text;
  }
  return text.substr(0, static_cast<std::size_t>(room));
}

int Progress::columns() const {
  if (options_.width > 0) return options_.width;
  winsize size{};
  const bool known = ::ioctl(::fileno(options_.sink), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

}  // namespace trevi

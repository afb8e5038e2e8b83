#include "trevi/requests.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cstdio>

namespace trevi {

namespace {

constexpr double seconds_between_looks = 1;  // a look may cost a server of a network file system a millisecond

// A signal handler has no argument to carry state in, so this must be a global.
volatile std::sig_atomic_t checkpoint_signals = 0, stop_signals = 0, terminate_signals = 0;

extern "C" void count_signal(int signal) {
  if (signal == SIGUSR1) checkpoint_signals = checkpoint_signals + 1;
  if (signal == SIGUSR2) stop_signals = stop_signals + 1;
  if (signal == SIGTERM || signal == SIGINT || signal == SIGHUP) terminate_signals = terminate_signals + 1;
}

constexpr std::array<int, 5> caught = {SIGUSR1, SIGUSR2, SIGTERM, SIGINT, SIGHUP};

}  // namespace

std::optional<std::string> stop_reason(const RequestCounts& agreed) {
  if (count_of(agreed, Request::stop_signal) > 0) return "SIGUSR2";
  if (count_of(agreed, Request::terminate_signal) > 0) return "SIGTERM, SIGINT or SIGHUP";
  if (count_of(agreed, Request::stop_file) > 0) return "the stop file";
  if (count_of(agreed, Request::wall_limit) > 0) return "the wall limit";
  if (count_of(agreed, Request::viewer) > 0) return "the viewer";
  return std::nullopt;
}

RequestWatch::RequestWatch(MPI_Comm comm, RequestOptions options)
    : options_(std::move(options)),
      watches_(rank_of(comm) == 0),
      began_(MPI_Wtime()),
      last_poll_(began_),
      last_look_(began_ - seconds_between_looks) {
  struct sigaction action = {};
  action.sa_handler = count_signal;
  action.sa_flags = SA_RESTART;  // a signal must not make a write fail
  for (const int signal : caught) {
    struct sigaction& old = old_.emplace_back();
    sigaction(signal, &action, &old);
    if (signal == SIGHUP && old.sa_handler == SIG_IGN) sigaction(signal, &old, nullptr);  // nohup
  }
}

RequestWatch::~RequestWatch() {
  for (std::size_t k = 0; k < caught.size(); ++k) sigaction(caught[k], &old_[k], nullptr);
}

RequestCounts RequestWatch::poll() {
  if (watches_) {
    const double now = MPI_Wtime();
    out_of_time_ = out_of_time_ || out_of_time(now);
    stop_file_found_ = stop_file_found_ || file_found(now);
  }
  return {checkpoint_signals, stop_signals, terminate_signals, stop_file_found_ ? 1 : 0, out_of_time_ ? 1 : 0, 0};
}

bool RequestWatch::out_of_time(double now) {
  const double next = now + (now - last_poll_);
  last_poll_ = now;
  return options_.wall_limit && next - began_ >= *options_.wall_limit;
}

bool RequestWatch::file_found(double now) {
  if (options_.stop_file.empty() || now - last_look_ < seconds_between_looks) return false;
  last_look_ = now;
  struct stat status = {};
  return ::stat(options_.stop_file.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

void RequestWatch::remove_stop_file() const {
  if (watches_ && stop_file_found_) std::remove(options_.stop_file.c_str());
}

}  // namespace trevi

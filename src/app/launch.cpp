#include "app/launch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "base/simd.hpp"
#include "base/threads.hpp"
#include "parallel/collective.hpp"
#include "parallel/reductions.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// From the environment; none if it is not set. It may hold a list, "4,2", whose first number is that of loops.
std::optional<int> threads_of_environment() {
  const char* text = std::getenv("OMP_NUM_THREADS");
  const std::string_view all = text == nullptr ? "" : text;
  if (all.find_first_not_of(' ') == std::string_view::npos) return std::nullopt;
  const std::optional<int> threads = whole_threads(all.substr(0, all.find(',')));
  if (threads) return threads;
  throw InputError(fmt::format("OMP_NUM_THREADS={}: must be a whole number from 1 to {}; unset it, or give --threads",
                               all.substr(0, 60), max_threads));
}

std::string counted(int number, const char* unit) {
  return fmt::format("{} {}{}", number, unit, number == 1 ? "" : "s");
}

}  // namespace

std::optional<int> whole_threads(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return std::nullopt;
  text = text.substr(begin, text.find_last_not_of(' ') + 1 - begin);
  int number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number >= 1 && number <= max_threads ? std::optional(number) : std::nullopt;
}

Launch use_threads(const Session& session, std::optional<int> wanted, const Scene& scene) {
  if (!wanted) wanted = scene.threads;
  if (!wanted) {
    std::optional<int> from_environment;
    all_or_none(session.comm(), [&] { from_environment = threads_of_environment(); });
    const int fair = session.fair_threads();  // on all ranks, because their environments may differ
    wanted = from_environment.value_or(fair);
  }
  all_or_none(session.comm(), [&] {
    if (can_start_threads(*wanted)) return;
    throw InputError(
        fmt::format("{} cannot be started here; give fewer by --threads, or raise the limits of memory and "
                    "processes (ulimit -v, ulimit -u)",
                    counted(*wanted, "thread")));
  });
  Session::use_threads(*wanted);
  return {session.size(), static_cast<int>(min_over_ranks(session.comm(), *wanted)),
          static_cast<int>(max_over_ranks(session.comm(), *wanted))};
}

std::string launch_text(const Launch& launch, const Scene& scene) {
  const std::string threads = launch.threads_min == launch.threads_max
                                  ? counted(launch.threads_max, "thread")
                                  : fmt::format("{} to {} threads", launch.threads_min, launch.threads_max);
  return fmt::format("{} x {}, {}, {} precision", counted(launch.ranks, "rank"), threads, instruction_set_name(),
                     scene.density.precision == Precision::single ? "single" : "double");
}

std::string with_commas(std::int64_t number) {
  std::string text = std::to_string(number);
  for (std::ptrdiff_t k = std::ssize(text) - 3; k > 0; k -= 3) text.insert(static_cast<std::size_t>(k), 1, ',');
  return text;
}

}  // namespace trevi

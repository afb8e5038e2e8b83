#include "base/memory.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>

#include "trevi/error.hpp"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace trevi {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The number after a word at the start of a line: "MemAvailable:  123 kB".
double number_behind(const std::string& file, const std::string& word, double otherwise) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(word)) return std::strtod(line.c_str() + word.size(), nullptr);
  }
  return otherwise;
}

/// "max", or a missing file, means no limit.
double number_in(const std::string& file, double otherwise) {
  double number = 0;
  std::ifstream in(file);
  return in >> number ? number : otherwise;
}

/// Pages of this process: of its whole address space, and those in memory.
std::array<double, 2> pages() {
  std::array<double, 2> all = {0, 0};
  std::ifstream in("/proc/self/statm");
  in >> all[0] >> all[1];
  return all;
}

double free_of_own_limit() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - pages()[0] * static_cast<double>(sysconf(_SC_PAGESIZE)));
}

}  // namespace

double free_in_group(const std::string& folder, std::string path) {
  double least = unlimited;
  for (bool more = true; more;) {
    const std::string group = folder + path;
    const double limit = number_in(group + "/memory.max", unlimited);
    const double files = number_behind(group + "/memory.stat", "inactive_file ", 0);
    const double used = number_in(group + "/memory.current", 0);
    least = std::min(least, std::max(0.0, limit - std::max(0.0, used - files)));
    more = !path.empty();
    path.resize(more ? std::min(path.rfind('/'), path.size()) : 0);
  }
  return least;
}

double free_memory() {
  double least = std::min(1024 * number_behind("/proc/meminfo", "MemAvailable:", unlimited), free_of_own_limit());
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.starts_with("0::/")) least = std::min(least, free_in_group("/sys/fs/cgroup", line.substr(3)));
  }
  return least;
}

std::string bytes_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

void require_memory(double bytes, const std::string& what, const std::string& remedy) {
  constexpr double small = 1e8;  // not worth a look into /proc
  if (bytes < small) return;
  const double room = free_memory();
  if (bytes <= room) return;
  throw InputError(
      fmt::format("{} need {}, and {} of memory are free here; {}", what, bytes_text(bytes), bytes_text(room), remedy));
}

void give_freed_memory_back() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 65536);  // this and the next are glibc's defaults
  mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  // The heap holds small arrays only. With glibc's 128 kB it shrank and grew 20 times per step.
  mallopt(M_TRIM_THRESHOLD, 4 * 1024 * 1024);
#endif
}

std::string text_of(const std::exception& error) {
  const bool no_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  const bool absurd = dynamic_cast<const std::length_error*>(&error) != nullptr;
  if (!no_memory && !absurd) return error.what();
  const double held = pages()[1] * static_cast<double>(sysconf(_SC_PAGESIZE));
  return fmt::format(
      "out of memory{}: this process holds {}, and {} are free here; use more machines or a coarser "
      "fluid.spacing (--dry-run tells what a run needs)",
      absurd ? " (more was asked for than there can be)" : "", bytes_text(held), bytes_text(free_memory()));
}

}  // namespace trevi

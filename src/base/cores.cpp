#include "base/cores.hpp"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>

#include "base/threads.hpp"

namespace trevi {

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();
constexpr std::size_t max_processors = 1 << 16;

// Processors that this thread may run on; none if the kernel does not report them.
std::vector<int> affinity() {
  std::vector<int> processors;
  for (std::size_t room = 1024; room <= max_processors; room *= 2) {
    cpu_set_t* mask = CPU_ALLOC(room);
    const std::size_t bytes = CPU_ALLOC_SIZE(room);
    const bool told = mask != nullptr && sched_getaffinity(0, bytes, mask) == 0;
    for (std::size_t p = 0; told && p < room; ++p) {
      if (CPU_ISSET_S(p, bytes, mask)) processors.push_back(static_cast<int>(p));
    }
    CPU_FREE(mask);
    if (told) break;
  }
  return processors;
}

// cpu.max holds microseconds of processor time and of the period in which they may be used; or "max" and the period.
double limit_of(const std::string& file) {
  double quota = 0, period = 0;
  std::ifstream in(file);
  return in >> quota >> period && quota > 0 && period > 0 ? quota / period : no_limit;
}

}  // namespace

std::vector<int> usable_processors() { return affinity(); }

std::string list_text(std::span<const int> numbers) {
  std::string text;
  for (std::size_t k = 0; k < numbers.size();) {
    std::size_t end = k + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    if (k > 0) text += ',';
    text += std::to_string(numbers[k]);
    if (end > k + 1) text += '-' + std::to_string(numbers[end - 1]);
    k = end;
  }
  return text;
}

int memory_domains_of(std::span<const int> processors, const std::string& folder) {
  int domains = 0;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const auto holds = [&](int p) { return std::filesystem::exists(entry.path() / ("cpu" + std::to_string(p))); };
    if (std::any_of(processors.begin(), processors.end(), holds)) ++domains;
  }
  return std::max(1, domains);
}

std::vector<int> usable_cores() {
  std::vector<int> processors = placed_processors();
  if (processors.empty()) processors = affinity();
  return cores_of(processors, "/sys/devices/system/cpu");
}

double allowed_processors() {
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.starts_with("0::")) return group_limit("/sys/fs/cgroup", line.substr(3));
  }
  return no_limit;
}

int threads_for_cores(std::span<const int> users_of_cores, double allowed, int processes) {
  double fraction = 0;
  for (const int users : users_of_cores) fraction += 1.0 / users;
  fraction = std::min({fraction, allowed / processes, static_cast<double>(max_threads)});
  return std::max(1, static_cast<int>(fraction + 1e-6));  // ten tenths are one core
}

std::vector<int> cores_of(std::span<const int> processors, const std::string& folder) {
  std::vector<int> cores;
  for (const int processor : processors) {
    std::ifstream siblings(folder + "/cpu" + std::to_string(processor) + "/topology/thread_siblings_list");
    int lowest = processor;
    cores.push_back(siblings >> lowest ? lowest : processor);
  }
  std::sort(cores.begin(), cores.end());
  cores.erase(std::unique(cores.begin(), cores.end()), cores.end());
  return cores;
}

double group_limit(const std::string& folder, std::string path) {
  double least = limit_of(folder + "/cpu.max");
  for (; path.size() > 1; path.erase(path.rfind('/'))) {
    least = std::min(least, limit_of(folder + path + "/cpu.max"));
  }
  return least;
}

}  // namespace trevi

#include "base/energy.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <system_error>

namespace trevi {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double power_limit = 1000;  // W, for what one counter covers

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The files contain microjoules.
double joules_of(const std::filesystem::path& file) {
  double number = 0;
  std::ifstream in(file);
  return in >> number ? 1e-6 * number : unknown;
}

}  // namespace

// Each processor has a folder intel-rapl:N, also one by AMD; it includes those of its parts, intel-rapl:N:M.
EnergyMeter::EnergyMeter(const std::string& folder) : begin_(seconds_now()) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("intel-rapl:") || name.find(':') != name.rfind(':')) continue;
    const std::filesystem::path file = entry.path() / "energy_uj";
    counters_.push_back({file.string(), joules_of(entry.path() / "max_energy_range_uj"), joules_of(file)});
  }
}

double EnergyMeter::joules() const {
  const double passed = seconds_now() - begin_;
  double sum = counters_.empty() ? unknown : 0;
  for (const Counter& counter : counters_) {
    const double more = joules_of(counter.file) - counter.first;
    sum += passed * power_limit < counter.range ? more + (more < 0 ? counter.range : 0) : unknown;
  }
  return sum;
}

}  // namespace trevi

// Energy of the processors of this machine, as reported by Linux (RAPL, /sys/class/powercap): it covers everything that
// runs there. Not collective.
#pragma once

#include <string>
#include <vector>

namespace trevi {

class EnergyMeter {
 public:
  /// Starts the measurement. `folder`: /sys/class/powercap, or one like it.
  explicit EnergyMeter(const std::string& folder);

  /// Joules since the start; nan if the machine does not report it, or not to this user, or if so much time has passed
  /// that a counter, which wraps around at its range, may have done so twice.
  double joules() const;

 private:
  struct Counter {
    std::string file;
    double range, first;  // J
  };
  std::vector<Counter> counters_;
  double begin_ = 0;  // s
};

}  // namespace trevi

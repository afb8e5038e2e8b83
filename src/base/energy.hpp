// Energy of the processors of this machine, as Linux tells it (RAPL, /sys/class/powercap): of all that runs there.
// Not collective.
#pragma once

#include <string>
#include <vector>

namespace trevi {

class EnergyMeter {
 public:
  /// Begins now. `folder`: /sys/class/powercap, or one like it.
  explicit EnergyMeter(const std::string& folder);

  /// Joules since the beginning; nan where the machine does not tell, or has not to this user, or where so much time
  /// has passed that a counter, which begins anew at its range, may have done so twice.
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

// The benchmarks' report on the terminal: a table per particle count with a row per kernel, precision and instruction
// set and a column per list length, "measured (memory roofline)" in ns per pair. --benchmark_out=FILE writes the same,
// and more, as JSON.
#pragma once

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace trevi::bench {

/// Benchmarks are named group/row@column/iterations:n, groups one after the other.
class Table : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }

  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      const std::string name = run.benchmark_name();
      const std::size_t slash = name.find('/'), at = name.find('@'), end = name.find("/iterations");
      if (name.substr(0, slash) != group_) print();
      group_ = name.substr(0, slash);
      const std::string row = name.substr(slash + 1, at - slash - 1), column = name.substr(at + 1, end - at - 1);
      for (auto& [list, entry] : {std::pair{&rows_, row}, {&columns_, column}}) {
        if (std::find(list->begin(), list->end(), entry) == list->end()) list->push_back(entry);
      }
      cells_[{row, column}] = fmt::format("{:.2f} ({:.2f})", static_cast<double>(run.counters.at("ns_per_pair")),
                                          static_cast<double>(run.counters.at("memory_roofline_ns")));
    }
  }

  void Finalize() override { print(); }

 private:
  void print() {
    if (rows_.empty()) return;
    fmt::print("\n{:<32}", group_ + " particles, ns per pair");
    for (const std::string& column : columns_) fmt::print("{:>15}", column);
    for (const std::string& row : rows_) {
      fmt::print("\n{:<32}", row);
      for (const std::string& column : columns_) fmt::print("{:>15}", cells_[{row, column}]);
    }
    fmt::print("\n");
    std::fflush(stdout);
    rows_.clear();
    columns_.clear();
    cells_.clear();
  }

  std::string group_;
  std::vector<std::string> rows_, columns_;
  std::map<std::pair<std::string, std::string>, std::string> cells_;
};

}  // namespace trevi::bench

// Which cores there are, what a control group allows, and what a process gets of cores that it shares with others.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "app/launch.hpp"
#include "base/cores.hpp"
#include "base/energy.hpp"
#include "base/threads.hpp"
#include "trevi/error.hpp"

namespace trevi {
namespace {

using Mask = std::set<int>;

/// A folder of files as Linux shows them.
class Files : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "coresXXXXXX";
    folder = mkdtemp(name.data());
  }
  void TearDown() override { std::filesystem::remove_all(folder); }
  void write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(folder + path).parent_path());
    std::ofstream(folder + path) << text;
  }
  void siblings(int processor, const std::string& list) const {
    write("/cpu" + std::to_string(processor) + "/topology/thread_siblings_list", list);
  }
  std::string folder;
};

using Cores = Files;
using Groups = Files;
using Energy = Files;

TEST_F(Cores, ProcessorsOfACoreAreOne) {
  for (const int p : {0, 1, 2, 3}) siblings(p, std::to_string(p % 2) + "," + std::to_string(p % 2 + 2) + "\n");
  EXPECT_EQ(cores_of(std::vector{0, 1, 2, 3}, folder), (std::vector{0, 1}));
  EXPECT_EQ(cores_of(std::vector{3, 1}, folder), std::vector{1});
  EXPECT_EQ(cores_of(std::vector{2, 3}, folder), (std::vector{0, 1}));
  EXPECT_EQ(cores_of(std::vector<int>(), folder), std::vector<int>());
}

TEST_F(Cores, RangesOfSiblingsAreRead) {
  for (const int p : {4, 5, 6, 7}) siblings(p, p < 6 ? "4-5\n" : "6-7\n");
  EXPECT_EQ(cores_of(std::vector{4, 5, 6, 7}, folder), (std::vector{4, 6}));
}

TEST_F(Cores, AProcessorOfWhichNothingIsKnownIsACore) {
  siblings(0, "0,1\n");
  siblings(2, "?");
  EXPECT_EQ(cores_of(std::vector{0, 1, 2, 7}, folder), (std::vector{0, 1, 2, 7}));
}

TEST_F(Cores, ProcessorsAreListedAsLinuxDoes) {
  EXPECT_EQ(list_text(std::vector{0, 1, 2, 3, 8, 10, 11}), "0-3,8,10-11");
  EXPECT_EQ(list_text(std::vector<int>()), "");
}

TEST_F(Cores, MemoryDomainsAreThoseOfTheProcessors) {
  EXPECT_EQ(memory_domains_of(std::vector{0}, folder + "/nowhere"), 1);
  for (const int p : {0, 1, 2, 3}) write("/node" + std::to_string(p / 2) + "/cpu" + std::to_string(p), "");
  EXPECT_EQ(memory_domains_of(std::vector{2, 3}, folder), 1);
  EXPECT_EQ(memory_domains_of(std::vector{1, 2}, folder), 2);
}

TEST_F(Energy, CountersOfProcessorsAreAddedAndBeginAnewAtTheirRange) {
  EXPECT_TRUE(std::isnan(EnergyMeter(folder).joules()));
  const auto counter = [&](const std::string& name, const std::string& microjoules) {
    write("/" + name + "/energy_uj", microjoules);
    write("/" + name + "/max_energy_range_uj", "262143328850");
  };
  counter("intel-rapl:0", "1000000");
  counter("intel-rapl:0:0", "1000000");  // a part of the first
  counter("intel-rapl:1", "262142328850");
  const EnergyMeter meter(folder);
  counter("intel-rapl:0", "6000000");
  counter("intel-rapl:0:0", "3000000");
  counter("intel-rapl:1", "1000000");
  EXPECT_NEAR(meter.joules(), 5 + 2, 1e-6);
  std::filesystem::remove(folder + "/intel-rapl:1/energy_uj");
  EXPECT_TRUE(std::isnan(meter.joules()));
}

TEST_F(Groups, TheTightestOfTheGroupsAroundAProcessCounts) {
  write("/cpu.max", "max 100000\n");
  write("/job/cpu.max", "400000 100000\n");
  write("/job/step/cpu.max", "max 100000\n");
  write("/narrow/cpu.max", "150000 100000\n");
  EXPECT_EQ(group_limit(folder, "/job/step"), 4);
  EXPECT_EQ(group_limit(folder, "/narrow"), 1.5);
  EXPECT_EQ(group_limit(folder, "/"), INFINITY);
  EXPECT_EQ(group_limit(folder, "/gone/group"), INFINITY);
  EXPECT_EQ(group_limit(folder, ""), INFINITY);
}

TEST_F(Groups, TheLimitOfAContainerStandsInItsRoot) {
  write("/cpu.max", "200000 100000\n");
  EXPECT_EQ(group_limit(folder, "/"), 2);
  EXPECT_EQ(group_limit(folder, "/inner"), 2);
}

/// Threads of each process of a machine by their masks.
std::vector<int> shares(const std::vector<Mask>& masks, double allowed = INFINITY) {
  std::vector<int> threads;
  for (const Mask& mask : masks) {
    std::vector<int> users;
    for (const int core : mask) {
      users.push_back(static_cast<int>(
          std::count_if(masks.begin(), masks.end(), [&](const Mask& other) { return other.contains(core); })));
    }
    threads.push_back(threads_for_cores(users, allowed, static_cast<int>(masks.size())));
  }
  return threads;
}

TEST(Share, ProcessesWithCoresOfTheirOwnHaveThemAll) {
  EXPECT_EQ(shares({{0, 1, 2, 3}}), std::vector{4});
  EXPECT_EQ(shares({{0, 1}, {2, 3}}), (std::vector{2, 2}));
  EXPECT_EQ(shares({{0}, {1, 2, 3}}), (std::vector{1, 3}));
}

TEST(Share, OverlappingProcessesShare) {
  EXPECT_EQ(shares({{0, 1}, {0, 1}}), (std::vector{1, 1}));
  EXPECT_EQ(shares({{0, 1, 2, 3}, {0, 1, 2, 3}}), (std::vector{2, 2}));
  EXPECT_EQ(shares({{0, 1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2, 3}}), (std::vector{1, 1, 1}));
  EXPECT_EQ(shares({{0, 1, 2, 3}, {2, 3}}), (std::vector{3, 1}));
}

TEST(Share, NobodyHasLessThanOneThread) {
  EXPECT_EQ(shares({{0, 1}, {0, 1}, {0, 1}}), (std::vector{1, 1, 1}));
  EXPECT_EQ(shares({{0}, {0}, {0}, {0}, {0}}), (std::vector{1, 1, 1, 1, 1}));
  EXPECT_EQ(shares({{}}), std::vector{1});
}

TEST(Share, ManyPartsOfACoreAreACore) {
  for (int processes = 1; processes < 200; ++processes) {
    EXPECT_EQ(threads_for_cores(std::vector<int>(static_cast<std::size_t>(3 * processes), processes), INFINITY, 1), 3);
  }
}

TEST(Share, AllTogetherHaveNoMoreThreadsThanCores) {
  for (int cores = 1; cores <= 12; ++cores) {
    for (int processes = 1; processes <= cores; ++processes) {
      Mask all;
      for (int c = 0; c < cores; ++c) all.insert(c);
      const std::vector<int> threads = shares(std::vector<Mask>(static_cast<std::size_t>(processes), all));
      EXPECT_EQ(threads, std::vector<int>(static_cast<std::size_t>(processes), cores / processes));
    }
  }
}

TEST(Share, WhatTheControlGroupAllowsIsShared) {
  EXPECT_EQ(shares({{0, 1, 2, 3}}, 2), std::vector{2});
  EXPECT_EQ(shares({{0, 1, 2, 3}}, 2.9), std::vector{2});
  EXPECT_EQ(shares({{0, 1, 2, 3}}, 0.5), std::vector{1});
  EXPECT_EQ(shares({{0, 1, 2, 3}, {4, 5, 6, 7}}, 4), (std::vector{2, 2}));
  EXPECT_EQ(shares({{0, 1}, {2, 3}}, 16), (std::vector{2, 2}));
}

TEST(Share, ThisProcessHasACore) {
  EXPECT_FALSE(usable_cores().empty());
  EXPECT_GT(allowed_processors(), 0);
}

TEST(ThreadNumbers, AreWholeAndNotAbsurd) {
  EXPECT_EQ(whole_threads("1"), 1);
  EXPECT_EQ(whole_threads(" 1024 "), 1024);
  for (const char* text : {"", " ", "0", "-1", "1025", "99999999999999999999", "2.0", "2e0", "two", "4 2", "0x2"})
    EXPECT_EQ(whole_threads(text), std::nullopt) << text;
}

TEST(ThreadNumbers, OfALibraryAreCheckedToo) {
  const int before = Session::threads();
  Session::use_threads(3);
  EXPECT_EQ(Session::threads(), 3);
  EXPECT_EQ(thread_count(), 3);
  EXPECT_THROW(Session::use_threads(0), InputError);
  EXPECT_THROW(Session::use_threads(1025), InputError);
  EXPECT_EQ(Session::threads(), 3);
  Session::use_threads(before);
}

TEST(Numbers, AreReadInThreesOfDigits) {
  EXPECT_EQ(with_commas(0), "0");
  EXPECT_EQ(with_commas(999), "999");
  EXPECT_EQ(with_commas(96000), "96,000");
  EXPECT_EQ(with_commas(1234567890123), "1,234,567,890,123");
}

}  // namespace
}  // namespace trevi

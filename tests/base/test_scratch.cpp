// Memory that stages share (base/scratch.hpp).
#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "base/scratch.hpp"

namespace trevi::test {
namespace {

TEST(Scratch, StagesLieInTheSameMemory) {
  Scratch scratch;
  for (int step = 0; step < 3; ++step) {
    scratch.join();
    Borrowed<double> kept = scratch.borrow<double>(1000);
    kept.fill(step);
    for (int stage = 0; stage < 4; ++stage) {
      Borrowed<std::int32_t> own = scratch.borrow<std::int32_t>(5000);
      own.fill(stage);
      EXPECT_THAT(std::vector<std::int32_t>(own.begin(), own.end()), testing::Each(stage));
    }
    EXPECT_THAT(std::vector<double>(kept.begin(), kept.end()), testing::Each(step));
  }
  EXPECT_EQ(scratch.borrowed(), 0U);
  EXPECT_LT(scratch.bytes(), std::size_t{1000 * 8 + 5000 * 4} * 11 / 10);
}

TEST(Scratch, GapsAreFilledAndNothingOverlaps) {
  Scratch scratch;
  for (int step = 0; step < 2; ++step) {
    scratch.join();
    std::array<Borrowed<int>, 5> all;
    for (std::size_t k = 0; k < all.size(); ++k) (all[k] = scratch.borrow<int>(100 + k)).fill(static_cast<int>(k));
    const std::size_t before = scratch.borrowed(), bytes = scratch.bytes();
    all[1].give_back();
    EXPECT_TRUE(all[1].empty());
    (all[1] = scratch.borrow<int>(101)).fill(1);
    EXPECT_EQ(scratch.borrowed(), before);
    EXPECT_EQ(scratch.bytes(), bytes);
    for (std::size_t k = 0; k < all.size(); ++k)
      EXPECT_THAT(std::vector<int>(all[k].begin(), all[k].end()), testing::Each(static_cast<int>(k)));
  }
}

// A small array leaves the large gap for a large one, once the memory is in one piece.
TEST(Scratch, TheSmallestGapIsTaken) {
  Scratch scratch;
  for (int step = 0; step < 2; ++step) {
    scratch.join();
    Borrowed<int> large = scratch.borrow<int>(4000), between = scratch.borrow<int>(100),
                  small = scratch.borrow<int>(500), last = scratch.borrow<int>(100);
    const int *const of_large = large.data(), *const of_small = small.data();
    large.give_back();
    small.give_back();
    small = scratch.borrow<int>(400);
    large = scratch.borrow<int>(3900);
    if (step == 0) continue;
    EXPECT_EQ(small.data(), of_small);
    EXPECT_EQ(large.data(), of_large);
  }
}

// Runs of memory that touch are one, so arrays are given back from the ends and from the middle of them.
TEST(Scratch, ArraysMayBeGivenBackInAnyOrder) {
  Scratch scratch;
  std::mt19937 random(1);
  std::vector<Borrowed<int>> all(40);
  for (int round = 0; round < 2000; ++round) {
    const std::size_t k = random() % all.size();
    if (all[k].empty()) {
      (all[k] = scratch.borrow<int>(1 + random() % 100)).fill(static_cast<int>(k));
    } else {
      EXPECT_THAT(std::vector<int>(all[k].begin(), all[k].end()), testing::Each(static_cast<int>(k)));
      all[k].give_back();
    }
    if (round % 500 == 499) {
      for (Borrowed<int>& one : all) one.give_back();
      EXPECT_EQ(scratch.borrowed(), 0U);
      scratch.join();
    }
  }
}

// An array that moves stays where it is, and what it is assigned to gives its own back.
// What is left keeps its values, and its end is free for others.
TEST(Scratch, TheEndOfAnArrayMayBeGivenBack) {
  Scratch scratch;
  Borrowed<int> first = scratch.borrow<int>(1000);
  std::iota(first.begin(), first.end(), 0);
  EXPECT_EQ(scratch.borrowed(), 4096U);  // in units of 128 bytes
  first.shrink(100);
  EXPECT_EQ(first.size(), 100U);
  EXPECT_EQ(scratch.borrowed(), 512U);
  const Borrowed<int> second = scratch.borrow<int>(800);
  EXPECT_GE(second.data(), first.end());
  EXPECT_LT(second.data(), first.data() + 1000);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(first[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(scratch.bytes(), 4096U);
}

TEST(Scratch, MovedArraysAreGivenBackOnce) {
  Scratch scratch;
  Borrowed<int> a = scratch.borrow<int>(10), b = scratch.borrow<int>(20);
  b[19] = 7;
  const int* const place = b.data();
  a = std::move(b);
  EXPECT_EQ(a.data(), place);
  EXPECT_EQ(a.size(), 20U);
  EXPECT_EQ(a[19], 7);
  EXPECT_EQ(scratch.borrowed(), 128U);
  a.give_back();
  a.give_back();
  EXPECT_EQ(scratch.borrowed(), 0U);
}

// So that a stage which reads what it has not written fails a test (tests/CMakeLists.txt).
TEST(Scratch, BorrowedMemoryIsNotANumber) {
  if (std::getenv("TREVI_SPOIL_SCRATCH") == nullptr) GTEST_SKIP() << "only with TREVI_SPOIL_SCRATCH=1, as in ctest";
  Scratch scratch;
  for (int step = 0; step < 2; ++step) {
    Borrowed<double> array = scratch.borrow<double>(100);
    EXPECT_THAT(std::vector<double>(array.begin(), array.end()), testing::Each(testing::IsNan()));
    array.fill(step);
  }
}

TEST(Scratch, NothingIsBorrowedOfEmptyRanks) {
  Scratch scratch;
  const Borrowed<double> none = scratch.borrow<double>(0);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.begin(), none.end());
}

TEST(Scratch, BriefArraysLieInLentMemoryAndOthersDoNot) {
  Scratch scratch;
  std::vector<double> owner(1000, 1.0);
  const auto is_lent = [&](const Borrowed<double>& array) {
    return array.data() >= owner.data() && array.end() <= owner.data() + owner.size();
  };
  {
    const Loan loan(scratch, std::as_writable_bytes(std::span(owner)));
    const Borrowed<double> longer = scratch.borrow<double>(100), brief = scratch.borrow_briefly<double>(100),
                           large = scratch.borrow_briefly<double>(1001);
    EXPECT_FALSE(is_lent(longer));
    EXPECT_TRUE(is_lent(brief));
    EXPECT_FALSE(is_lent(large));
  }
  EXPECT_FALSE(is_lent(scratch.borrow_briefly<double>(100)));
}

TEST(Scratch, ThreadsBorrowAtATime) {
  const int before = thread_count();
  use_threads(4);
  Scratch scratch;
  std::vector<Borrowed<int>> all(200);
  for_each_part(200, [&](LocalId k) { (all[static_cast<std::size_t>(k)] = scratch.borrow<int>(50))[0] = k; });
  for (std::size_t k = 0; k < all.size(); ++k) EXPECT_EQ(all[k][0], static_cast<int>(k));
  all.clear();
  EXPECT_EQ(scratch.borrowed(), 0U);
  use_threads(before);
}

}  // namespace
}  // namespace trevi::test

// Loops that threads share: whatever the number of threads, each part is done once, what comes out is what a plain loop
// gives, and the first exception by the number of its part gets through.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <latch>
#include <limits>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/simd.hpp"
#include "base/threads.hpp"

namespace trevi {
namespace {

constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real infinity = std::numeric_limits<Real>::infinity();

class Threads : public testing::Test {
 protected:
  static constexpr int most = 7;

  ~Threads() override { use_threads(before_); }

  /// check() with each number of threads.
  template <class Check>
  void with_each_count(const Check& check) {
    for (int threads = 1; threads <= most; ++threads) {
      SCOPED_TRACE(std::to_string(threads) + " threads");
      use_threads(threads);
      EXPECT_EQ(thread_count(), threads);
      check();
    }
  }

 private:
  int before_ = thread_count();
};

/// How often each of some things was done. Atomic, so that a second time is counted and not lost.
struct Tally {
  explicit Tally(LocalId size) : times(static_cast<std::size_t>(size)) {}
  void note(LocalId k) { times.at(static_cast<std::size_t>(k)).fetch_add(1, std::memory_order_relaxed); }
  /// The first thing not done as often as it should be, -1 where there is none: [begin, end) once, others never.
  LocalId first_wrong(Range once) const {
    for (LocalId k = 0; k < static_cast<LocalId>(times.size()); ++k) {
      if (times[static_cast<std::size_t>(k)] != (k >= once.begin && k < once.end ? 1 : 0)) return k;
    }
    return -1;
  }
  LocalId first_wrong() const { return first_wrong({0, static_cast<LocalId>(times.size())}); }
  std::vector<std::atomic<int>> times;
};

TEST_F(Threads, EachPartIsDoneOnce) {
  with_each_count([] {
    for (const LocalId parts : {0, 1, 2, 3, 5, 6, 7, 8, 100, 9973}) {
      Tally done(parts);
      for_each_part(parts, [&](LocalId k) { done.note(k); });
      EXPECT_EQ(done.first_wrong(), -1) << parts << " parts";
    }
  });
}

TEST_F(Threads, SlowPartsAreDoneOnceToo) {
  with_each_count([] {
    constexpr LocalId parts = 41;
    Tally done(parts);
    std::vector<Real> sums(parts);
    for_each_part(parts, [&](LocalId k) {  // the first thread has by far the most to do, so that the others help it
      done.note(k);
      for (int i = 0; i < (k < parts / 7 ? 100000 : 10); ++i) sums[static_cast<std::size_t>(k)] += std::sqrt(i);
    });
    EXPECT_EQ(done.first_wrong(), -1);
  });
}

// Parts that wait for each other end only if each has a thread of its own.
TEST_F(Threads, WorkAtTheSameTime) {
  with_each_count([] {
    std::latch all_here(thread_count());
    std::vector<int> numbers(static_cast<std::size_t>(thread_count()), -1);
    for_each_part(thread_count(), [&](LocalId k) {
      all_here.arrive_and_wait();
      numbers[static_cast<std::size_t>(k)] = thread_number();
    });
    const std::set<int> different(numbers.begin(), numbers.end());
    EXPECT_EQ(different.size(), numbers.size());
    EXPECT_GE(*different.begin(), 0);
    EXPECT_LT(*different.rbegin(), thread_count());
    EXPECT_EQ(thread_number(), 0);
  });
}

TEST_F(Threads, FlushDenormals) {
  flush_denormals();  // as a Session does for the first thread
  with_each_count([] {
    std::vector<Real> halves(100, 1);
    const volatile Real least = std::numeric_limits<Real>::min();
    for_each_part(100, [&](LocalId k) { halves[static_cast<std::size_t>(k)] = least / 2; });
    EXPECT_EQ(halves, std::vector<Real>(100, 0));
  });
}

TEST_F(Threads, LeaveTheDenormalsOfTheHostAsTheyAre) {
  const volatile Real least = std::numeric_limits<Real>::min();
  const Denormals counted(false);
  const auto halves_in_threads = [&] {
    std::vector<Real> halves(static_cast<std::size_t>(thread_count()), 1);
#pragma omp parallel num_threads(thread_count())
    halves[static_cast<std::size_t>(thread_number())] = least / 2;
    return halves;
  };
  with_each_count([&] {
    // Threads that began while a test above had them flushed on the first one go on so.
    const std::vector<Real> before = halves_in_threads();
    for_each_part(100, [](LocalId) {});
    EXPECT_EQ(halves_in_threads(), before);
    EXPECT_GT(before[0], 0);
    {
      const Denormals zero;
      EXPECT_EQ(least / 2, 0);
      const Denormals again(false);
      EXPECT_GT(least / 2, 0);
    }
    EXPECT_GT(least / 2, 0);
  });
}

TEST_F(Threads, PartsOfARangeFollowEachOther) {
  with_each_count([] {
    for (const Range range : {Range{0, 0}, {5, 5}, {0, 1}, {0, 12}, {3, 16}, {100, 5000}}) {
      for (const LocalId size : {1, 2, 3, 12, 13, 2048, 100000}) {
        SCOPED_TRACE(std::to_string(range.begin) + " to " + std::to_string(range.end) + " by " + std::to_string(size));
        Tally done(range.end);
        std::atomic<int> odd = 0;
        for_each_part(range, size, [&](Range part) {
          const bool last = part.end == range.end;
          odd += (part.begin - range.begin) % size != 0 || part.size() <= 0 || part.size() > size ||
                 (part.size() != size && !last);
          for (LocalId i = part.begin; i < part.end; ++i) done.note(i);
        });
        EXPECT_EQ(odd, 0);
        EXPECT_EQ(done.first_wrong(range), -1);
      }
    }
  });
}

TEST_F(Threads, EachIndexIsDoneOnce) {
  with_each_count([] {
    for (const Range range : {Range{0, 0}, {7, 7}, {7, 8}, {0, 2048}, {1, 2050}, {11, 20000}}) {
      Tally done(range.end);
      for_each_index(range, [&](std::size_t i) { done.note(static_cast<LocalId>(i)); });
      EXPECT_EQ(done.first_wrong(range), -1) << range.begin << " to " << range.end;
    }
  });
}

// What is written without any care before a loop is seen in it, and what is written in it behind it.
TEST_F(Threads, LoopsFollowEachOther) {
  with_each_count([] {
    constexpr LocalId parts = 64;
    std::vector<int> values(parts, 0), next(parts, 0);
    for (int round = 0; round < 50; ++round) {
      for_each_part(parts, [&](LocalId k) {  // each reads what another part wrote in the loop before
        next[static_cast<std::size_t>(k)] = values[static_cast<std::size_t>((k + 29) % parts)] + 1;
      });
      std::swap(values, next);
    }
    EXPECT_EQ(values, std::vector<int>(parts, 50));
  });
}

/// The message of what a loop of `parts` throws when those of `bad` do, "" for nothing; parts are noted in `done`.
std::string thrown(LocalId parts, const std::set<LocalId>& bad, Tally& done) {
  try {
    for_each_part(parts, [&](LocalId k) {
      done.note(k);
      if (bad.contains(k)) throw std::runtime_error(std::to_string(k));
    });
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST_F(Threads, TheFirstExceptionIsThrown) {
  with_each_count([] {
    constexpr LocalId parts = 200;
    std::set<LocalId> every_third;
    for (LocalId k = 100; k < parts; k += 3) every_third.insert(k);
    for (const std::set<LocalId>& bad : {std::set<LocalId>{0}, {199}, {0, 199}, {57, 58, 140}, every_third}) {
      Tally done(parts), again(parts);
      const LocalId first = *bad.begin();
      EXPECT_EQ(thrown(parts, bad, done), std::to_string(first));
      for (LocalId k = 0; k < parts; ++k) {  // those behind the first may be left out
        const int times = done.times[static_cast<std::size_t>(k)];
        EXPECT_TRUE(times == 1 || (times == 0 && k > first)) << "part " << k << " done " << times << " times";
      }
      EXPECT_EQ(thrown(parts, {}, again), "") << "the next loop knows nothing of it";
      EXPECT_EQ(again.first_wrong(), -1);
    }
  });
}

TEST_F(Threads, AnExceptionOfEachThreadAtOnce) {
  with_each_count([] {
    std::latch all_here(thread_count());
    std::string message;
    try {
      for_each_part(thread_count(), [&](LocalId k) {
        if (thread_count() > 1) all_here.arrive_and_wait();
        throw std::runtime_error(std::to_string(k));
      });
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    EXPECT_EQ(message, "0");
  });
}

/// Numbers of both signs; every `every`th is not a number.
std::vector<Real> some_numbers(LocalId size, LocalId every) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<Real> number(-10, 10);
  std::vector<Real> values(static_cast<std::size_t>(size));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = i % static_cast<std::size_t>(every) == 0 ? nan : number(random);
  return values;
}

Real plainly_largest(const std::vector<Real>& values, Range range, Real least) {
  Real most = least;
  for (LocalId i = range.begin; i < range.end; ++i) {
    if (values[static_cast<std::size_t>(i)] > most) most = values[static_cast<std::size_t>(i)];
  }
  return most;
}

TEST_F(Threads, LargestIsThatOfAPlainLoop) {
  with_each_count([] {
    for (const LocalId every : {1, 2, 2048, 1 << 30}) {  // 1: none of them is a number
      std::vector<Real> values = some_numbers(20000, every);
      for (const Range range : {Range{0, 0}, {5, 5}, {0, 1}, {0, 2048}, {2047, 4097}, {1, 20000}, {0, 20000}}) {
        for (const Real least : {-infinity, -11.0, 0.0, 11.0}) {
          const auto value = [&](std::size_t i) { return values[i]; };
          EXPECT_EQ(largest(range, least, value), plainly_largest(values, range, least))
              << range.begin << " to " << range.end << ", at least " << least << ", NaN every " << every;
        }
      }
      values[13000] = infinity;
      EXPECT_EQ(largest({0, 20000}, 0, [&](std::size_t i) { return values[i]; }), infinity);
    }
  });
}

TEST_F(Threads, FirstIndexIsThatOfAPlainLoop) {
  with_each_count([] {
    constexpr LocalId size = 20000;
    for (const std::set<LocalId>& places :
         {std::set<LocalId>{}, {0}, {size - 1}, {2047, 2048}, {900, 7000, 7001, 19000}}) {
      for (const Range range : {Range{0, 0}, {9, 9}, {0, size}, {1, size}, {901, 7001}, {0, 2048}, {2048, 2049}}) {
        Tally asked(size);
        const LocalId found = first_index(range, [&](std::size_t i) {
          asked.note(static_cast<LocalId>(i));
          return places.contains(static_cast<LocalId>(i));
        });
        const auto next = places.lower_bound(range.begin);
        EXPECT_EQ(found, next != places.end() && *next < range.end ? *next : range.end);
        EXPECT_EQ(asked.first_wrong(range), -1) << "it is called for every i";
      }
    }
  });
}

TEST_F(Threads, EachHasAnObjectOfItsOwn) {
  with_each_count([] {
    PerThread<std::int64_t> sums;
    std::set<std::int64_t*> objects;
    sums.for_each([&](std::int64_t& sum) {
      EXPECT_EQ(sum, 0);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(&sum) % 128, 0U);
      objects.insert(&sum);
    });
    EXPECT_EQ(objects.size(), static_cast<std::size_t>(thread_count()));
    std::atomic<int> strange = 0;
    for_each_part(10000, [&](LocalId k) {
      strange += !objects.contains(&sums.mine());
      sums.mine() += k;
    });
    EXPECT_EQ(strange, 0);
    std::int64_t total = 0;
    sums.for_each([&](std::int64_t sum) { total += sum; });
    EXPECT_EQ(total, std::int64_t{10000} * 9999 / 2);
  });
}

}  // namespace
}  // namespace trevi

// What is told of memory: limits of control groups, refusals, and errors of allocations.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <new>
#include <vector>

#include "base/memory.hpp"
#include "trevi/error.hpp"

namespace trevi {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

TEST(Memory, TheTightestGroupCounts) {
  const fs::path top = fs::path(testing::TempDir()) / "memory_groups";
  fs::create_directories(top / "job/step");
  write(top / "job/memory.max", "1000000\n");
  write(top / "job/memory.current", "700000\n");
  write(top / "job/memory.stat", "anon 400000\ninactive_file 300000\n");
  write(top / "job/step/memory.max", "max\n");
  EXPECT_EQ(free_in_group(top, "/job/step"), 600000);
  EXPECT_EQ(free_in_group(top, "/job"), 600000);
  EXPECT_TRUE(std::isinf(free_in_group(top, "/")));
  write(top / "job/memory.current", "2000000\n");
  EXPECT_EQ(free_in_group(top, "/job/step"), 0);
  fs::remove_all(top);
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// Bytes that are taken from the system for an array alone, while it lives.
std::size_t taken_for(std::size_t bytes) {
  const std::size_t before = mallinfo2().hblkhd;
  const std::vector<char> array(bytes);
  [[maybe_unused]] static const char* volatile seen = nullptr;  // so that the array is made
  seen = array.data();
  return mallinfo2().hblkhd - before;
}

TEST(Memory, LargeArraysAreTakenFromTheSystemAlone) {
  constexpr std::size_t large = 1 << 22;
  mallopt(M_MMAP_MAX, 0);  // as libsuperlu_dist does
  EXPECT_EQ(taken_for(large), 0);
  give_freed_memory_back();
  EXPECT_GE(taken_for(4 * large), 4 * large);  // one of the same size would find its place in the heap
}
#endif

TEST(Memory, WhatIsNotThereIsRefused) {
  EXPECT_GT(free_memory(), 1e6);
  EXPECT_NO_THROW(require_memory(1, "a byte", ""));
  try {
    require_memory(1e18, "x.h5: 9 rows", "use fewer");
    FAIL();
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("x.h5: 9 rows need 1000000000.0 GB, and "), std::string::npos) << text;
    EXPECT_NE(text.find("are free here; use fewer"), std::string::npos) << text;
  }
}

TEST(Memory, NoBareErrors) {
  std::string absurd;
  try {
    std::vector<double>().reserve(std::size_t{1} << 62);
  } catch (const std::exception& error) {
    absurd = text_of(error);
  }
  for (const std::string& text : {text_of(std::bad_alloc()), absurd}) {
    EXPECT_NE(text.find("out of memory"), std::string::npos) << text;
    EXPECT_NE(text.find("this process holds"), std::string::npos) << text;
    EXPECT_EQ(text.find("std::"), std::string::npos) << text;
  }
  EXPECT_EQ(text_of(std::runtime_error("a reason")), "a reason");
}

}  // namespace
}  // namespace trevi

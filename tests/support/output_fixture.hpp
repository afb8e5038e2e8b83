// What the tests of the output layer share: one seeded cloud, its part on each rank, a fresh folder per test.
// With more than one rank the last one holds no particles.
// Collective: the fixture's SetUp and TearDown.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "base/threads.hpp"
#include "trevi/error.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace fs = std::filesystem;

namespace trevi {

inline const MPI_Comm world = MPI_COMM_WORLD;

inline void barrier() { MPI_Barrier(world); }

/// All ranks' particles, in a random order with ids that are not dense, most of them past 32 bits; or `stride` apart,
/// for more than 20,000.
inline Particles whole_cloud(int count, GlobalId stride = 0) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<Real> number(-1, 1);
  Particles all;
  all.has_hue = true;
  all.resize(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < all.id.size(); ++k) {
    const auto i = static_cast<GlobalId>(k);
    all.id[k] = stride > 0 ? i * stride : i * i * i * 1000003;
    all.position[k] = Vec3(number(random), number(random), number(random));
    all.velocity[k] = 10 * Vec3(number(random), number(random), number(random));
    all.hue[k] = static_cast<float>(k) / static_cast<float>(count);
  }
  return all;
}

inline std::vector<std::size_t> shuffled(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t k = 0; k < count; ++k) order[k] = k;
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  return order;
}

inline Particles part_of(const Particles& all, int rank, int size) {
  const std::size_t holders = static_cast<std::size_t>(std::max(1, size - 1));
  Particles part;
  part.has_hue = all.has_hue;
  for (const std::size_t k : shuffled(all.id.size())) {
    if (static_cast<std::size_t>(rank) != (k * k) % holders) continue;
    part.id.push_back(all.id[k]);
    part.position.push_back(all.position[k]);
    part.velocity.push_back(all.velocity[k]);
    if (all.has_hue) part.hue.push_back(all.hue[k]);
  }
  part.predicted = part.position;
  return part;
}

inline Particles my_part(const Particles& all) { return part_of(all, rank_of(world), size_of(world)); }

inline Frame frame_of(const Clock& clock, const Particles& particles, std::span<const Real> density = {}) {
  return {clock, particles, density, nullptr, {}};
}

inline std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// write() on 1, 2 and 4 threads, and what each left at the path.
template <class Write>
std::vector<std::string> on_threads(const std::string& path, const Write& write) {
  const int before = thread_count();
  std::vector<std::string> texts;
  for (const int threads : {1, 2, 4}) {
    use_threads(threads);
    write();
    barrier();
    texts.push_back(text_of(path));
    barrier();
  }
  use_threads(before);
  return texts;
}

/// What an InputError said, or how it failed to come.
template <class Work>
inline std::string input_error_of(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("another error: ") + error.what();
  }
  return "no error";
}

inline void expect_mentions(const std::string& text, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " is not in: " << text;
}

class Output : public testing::Test {
 protected:
  void SetUp() override {
    int process = static_cast<int>(::getpid());
    MPI_Bcast(&process, 1, MPI_INT, 0, world);
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = (fs::temp_directory_path() / ("trevi_" + std::to_string(process) + "_" + name)).string();
    if (rank_of(world) == 0) fs::create_directories(folder_);
    barrier();
  }
  void TearDown() override {
    barrier();
    if (rank_of(world) == 0) fs::remove_all(folder_);
    barrier();
  }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  const std::string& folder() const { return folder_; }

 private:
  std::string folder_;
};

}  // namespace trevi

// Nanoseconds per pair of every pair loop, of the neighbour search and of a rebuild (sort, encode, search), against
// list length and particle count.
//   bench_pairs [--instruction_sets=best|all|AVX2,...] [--large] [options of Google Benchmark]
// The figure is the fastest pass in CPU time: others may use the machine. Beside it stands the memory roofline: the
// bytes that must cross from memory if nothing but the list's neighbourhood stays in cache (records once per particle),
// over the triad bandwidth measured at the start. Below about 10,000 particles the list itself fits in cache and the
// bound does not apply. --large adds ten million particles (about 5 GB).
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <ctime>
#include <functional>
#include <iterator>
#include <limits>
#include <string_view>

#include "base/simd.hpp"
#include "table.hpp"
#include "trevi/session.hpp"
#include "water.hpp"

namespace trevi::bench {
namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double seconds_of(Work&& work) {
  const double start = cpu_seconds();
  work();
  benchmark::ClobberMemory();
  return cpu_seconds() - start;
}

// Bytes per second of a = b + s c with arrays beyond any cache, counted as STREAM does (24 bytes an element).
double triad_bandwidth() {
  constexpr std::size_t n = std::size_t{1} << 24;
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  double fastest = std::numeric_limits<double>::max();
  for (int repetition = 0; repetition < 10; ++repetition) {
    const double seconds = seconds_of([&] {
      for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 3.0 * c[i];
    });
    fastest = std::min(fastest, seconds);
  }
  return 24.0 * static_cast<double>(n) / fastest;
}

/// A loop to be timed, and the bytes per particle it moves beside its four bytes per pair.
template <class T>
struct Loop {
  std::string name;
  double bytes_per_particle;
  std::function<void(Water<T>&)> pass;
};

// Sums go to an array as long as the cloud. Each particle: where its row starts, its record, its sums.
template <class T>
constexpr double bytes_of_sums = 8 + sizeof(Packed<T>) + sizeof(Vec4<T>);

// Of the constraint with densities of this kernel and the gradient that goes with them.
template <class T>
std::vector<Loop<T>> constraint_benchmarks(const Kernel& kernel, std::vector<Vec4<T>>& out, std::vector<T>& squares) {
  constexpr double sums = bytes_of_sums<T>;
  const Kernels kernels{kernel, all_kernels()[kernel.gradient_index]};
  const auto loops = [kernels] { return constraint_loops<T>(kernels); };  // of the instruction set at the time
  return {
      {fmt::format("density_{}", kernel.name), sums + sizeof(T),
       [&, loops](Water<T>& w) { loops().density(w.pairs(), w.all(), out.data(), squares.data()); }},
      {fmt::format("delta_{}", kernel.name), sums,
       [&, loops](Water<T>& w) { loops().delta(w.pairs(), w.all(), out.data()); }},
      {fmt::format("tensile_delta_{}", kernel.name), sums,
       [&, loops](Water<T>& w) {
         loops().tensile_delta(w.pairs(), w.all(), Tensile{0.001, 4, 0.2}, out.data());
       }},
  };
}

template <class T>
std::vector<Loop<T>> filter_benchmarks(std::vector<Vec4<T>>& out) {
  constexpr double sums = bytes_of_sums<T>, velocities = sums + sizeof(Vec4<T>);
  return {
      {"curl", velocities,
       [&](Water<T>& w) { filter_loops<T>().curl(w.pairs(), w.all(), w.velocity.data(), out.data()); }},
      {"gradient", sums, [&](Water<T>& w) { filter_loops<T>().gradient(w.pairs(), w.all(), out.data()); }},
      {"smoothing", velocities,
       [&](Water<T>& w) { filter_loops<T>().smoothing(w.pairs(), w.all(), w.velocity.data(), out.data()); }},
  };
}

// The search writes the list and reads the records; a rebuild also reads and writes id and three vectors, and finds the
// cell of each particle.
template <class T>
std::vector<Loop<T>> search_benchmarks(NeighbourList& list) {
  constexpr double search = 8 + sizeof(Packed<T>);
  constexpr double state = sizeof(GlobalId) + 3 * sizeof(Vec3);
  return {
      {"search", search, [&](Water<T>& w) { list.rebuild(w.near.order(), w.near.records()); }},
      {"rebuild", search + 2 * state + 2 * sizeof(Vec3) + sizeof(Packed<T>), [](Water<T>& w) { w.rebuild(); }},
  };
}

/// What all benchmarks share.
template <class T>
struct Bench {
  Waters& waters;
  double bandwidth;
  std::vector<Vec4<T>> out;
  std::vector<T> squares;
  NeighbourList list;

  void run(benchmark::State& state, const Loop<T>& loop, const Case& size, std::int64_t set) {
    const std::int64_t all = supported_instruction_sets();
    restrict_instruction_sets(set);
    Water<T>& water = waters.of<T>(size);
    const auto particles = static_cast<std::size_t>(water.all().size());
    out.resize(particles);
    squares.resize(particles);
    loop.pass(water);  // memory grows, caches warm up
    double fastest = std::numeric_limits<double>::max();
    for (auto _ : state) fastest = std::min(fastest, seconds_of([&] { loop.pass(water); }));
    restrict_instruction_sets(all);
    const auto pairs = static_cast<double>(water.near.list().pairs());
    const double bytes_per_pair = 4 + loop.bytes_per_particle * static_cast<double>(particles) / pairs;
    state.counters["ns_per_pair"] = 1e9 * fastest / pairs;
    state.counters["memory_roofline_ns"] = 1e9 * bytes_per_pair / bandwidth;
    state.counters["pairs_per_particle"] = pairs / static_cast<double>(particles);
    state.counters["ms"] = 1e3 * fastest;
  }
};

struct Plan {
  std::vector<std::int64_t> sets;
  std::vector<LocalId> particles = {10'000, 100'000, 1'000'000};
  std::vector<Real> radii = {1.5, 2, 2.5, 3};
};

// Enough passes for an undisturbed one among them, about a hundred million pairs in all.
benchmark::IterationCount repetitions(const Case& size) {
  const double pairs = 4.0 * size.particles * size.h * size.h * size.h;
  return std::clamp<benchmark::IterationCount>(static_cast<benchmark::IterationCount>(1e8 / pairs), 5, 200);
}

template <class T>
void register_case(Bench<T>& bench, const Plan& plan, const Case& size) {
  std::vector<Loop<T>> loops;
  const auto append = [&](std::vector<Loop<T>> more) {
    std::move(more.begin(), more.end(), std::back_inserter(loops));
  };
  for (const Kernel& kernel : all_kernels()) append(constraint_benchmarks<T>(kernel, bench.out, bench.squares));
  append(filter_benchmarks<T>(bench.out));
  append(search_benchmarks<T>(bench.list));
  const std::string precision = sizeof(T) == 4 ? "single" : "double";
  for (const Loop<T>& loop : loops) {
    for (const std::int64_t set : plan.sets) {
      restrict_instruction_sets(set);
      const std::string name = fmt::format("{:.0e}/{}/{}/{}@h/s={}", 1.0 * size.particles, loop.name, precision,
                                           instruction_set_name(), size.h);
      const auto run = [&bench, loop, size, set](benchmark::State& state) { bench.run(state, loop, size, set); };
      benchmark::RegisterBenchmark(name.c_str(), run)->Iterations(repetitions(size));
    }
  }
}

// Reads and removes our own options.
Plan plan_from(int& argc, char** argv) {
  const std::int64_t all = supported_instruction_sets();
  std::string wanted = "best";
  Plan plan;
  int kept = 1;
  for (int k = 1; k < argc; ++k) {
    const std::string_view word = argv[k];
    constexpr std::string_view option = "--instruction_sets=";
    if (word.starts_with(option)) {
      wanted = word.substr(option.size());
    } else if (word == "--large") {
      plan.particles.push_back(10'000'000);
    } else {
      argv[kept++] = argv[k];
    }
  }
  argc = kept;
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {  // the lowest bit, which is the highest set, first
    restrict_instruction_sets(rest & -rest);
    const std::string name = fmt::format(",{},", instruction_set_name());
    if (wanted == "all" || (wanted == "best" && rest == all) ||
        fmt::format(",{},", wanted).find(name) != std::string::npos)
      plan.sets.push_back(rest & -rest);
  }
  restrict_instruction_sets(all);
  return plan;
}

}  // namespace
}  // namespace trevi::bench

int main(int argc, char** argv) {
  using namespace trevi::bench;
  const trevi::Session session(argc, argv);
  const Plan plan = plan_from(argc, argv);
  benchmark::Initialize(&argc, argv);
  if (plan.sets.empty() || benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  Waters waters;
  const double bandwidth = triad_bandwidth();
  Bench<float> single{waters, bandwidth, {}, {}, {}};
  Bench<double> twice{waters, bandwidth, {}, {}, {}};
  for (const trevi::LocalId n : plan.particles) {
    for (const trevi::Real h : plan.radii) {
      register_case(single, plan, {n, h});
      register_case(twice, plan, {n, h});
    }
  }
  fmt::print("triad bandwidth {:.1f} GB/s; in brackets the memory roofline\n", 1e-9 * bandwidth);
  Table table;
  benchmark::RunSpecifiedBenchmarks(&table);
  return 0;
}

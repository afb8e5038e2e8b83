// Scenes with inlets and drains, and what tests of them share.
#pragma once

#include <fmt/format.h>
#include <cmath>
#include <numeric>
#include <set>
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"

namespace trevi::test {
inline constexpr Real spacing = 0.1;

// A shaft without water, wide enough for a jet.
inline const std::string shaft = tank_text({.max = "1.6, 0.9, 3.0", .dt = "0.0166666667", .end = "2"});

inline const std::string jet = R"(
[[inlet]]
center = [0.8, 0.45, 2.9]
direction = [0, 0, -1]
radius = 0.2
)";

inline const std::string bottom = "[[drain]]\ntype = \"plane\"\ncenter = [0, 0, 0.3]\naxis = [0, 0, -1]\n";

// A pool that an inlet stirs from below, a jet from above, and a drain at one side.
inline const std::string fountain =
    tank_with_gravity(
        {.max = "1.6, 0.8, 1.6", .water = {{"0, 0, 0", "1.6, 0.8, 0.5"}}, .dt = "0.0166666667", .end = "2"}) +
    R"([[inlet]]
type = "rectangle"
center = [0.4, 0.4, 0.15]
direction = [0.3, 0, 1]
size = [0.3, 0.3]
speed = 2.5
jitter = 0.5
recycle = true
[[inlet]]
center = [1.0, 0.4, 1.4]
direction = [1, 0.2, -0.5]
radius = 0.15
flow = 0.1
start = 0.1
stop = 0.45
[[drain]]
type = "cylinder"
center = [1.3, 0.4, 0.2]
radius = 0.25
height = 0.4
[output.series]
every_steps = 1
)";

inline std::unique_ptr<Solver> solver_of(MPI_Comm comm, const Scene& scene,
                                         std::vector<std::unique_ptr<Observer>> see = {}) {
  SolverExtras extras;
  extras.observers = std::move(see);
  return make_solver(comm, scene, initial_particles(comm, scene), std::move(extras));
}

inline GlobalId total(const Solver& solver) {
  GlobalId sum = solver.particles().size();
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_INT64_T, MPI_SUM, world);
  return sum;
}

inline void run(Solver& solver, Real seconds) {
  solver.start();
  const auto steps = std::llround(seconds / solver.clock().dt);
  for (std::int64_t k = 0; k < steps; ++k) solver.step();
}

}  // namespace trevi::test

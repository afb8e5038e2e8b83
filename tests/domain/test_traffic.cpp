// What the halos send in a step is what the formula of postprocess/results/scaling.md says, to the byte. The water is
// a lattice at rest, so that the planes keep their particles.
#include <gtest/gtest.h>

#include "parallel/reductions.hpp"
#include "solver/first_slabs.hpp"
#include "solver/halo_traffic.hpp"
#include "support/cloud.hpp"
#include "support/output_fixture.hpp"
#include "support/tank.hpp"

namespace trevi::test {
namespace {

// Cells of the box and of the water, and those that the coarse grid looks at: two above the water, rounded up to a
// multiple of four, and a ring.
constexpr int rows = 2, columns = 8, water_columns = 5, coarse_columns = (water_columns + 2 + 3) / 4 * 4;
constexpr std::int64_t coarse_cells_per_plane = (rows + 2) * (coarse_columns + 2);
// Fields of several numbers of a cell have no ring, and columns four at a time, with the one above the water.
constexpr std::int64_t field_cells_per_plane = rows * ((water_columns + 1 + 3) / 4 * 4);
constexpr std::int64_t particles_per_plane = 8 * rows * water_columns;  // two layers of the lattice in each direction

const std::string still_scene = tank_with_gravity({.min = "0.0, 0.0, 0.0",
                                                   .max = "3.4, 0.4, 1.6",
                                                   .water = {{"0.0, 0.0, 0.0", "3.4, 0.4, 1.0"}},
                                                   .dt = "0.0166666667",
                                                   .end = "1.0"});

/// What finds the pressure: pairs alone, or the projection, without gravity or with it.
enum class Grid { none, floating, upright };

/// Bytes over all ranks in a substep. `record`: bytes of a packed record; `velocity_exchanges`: of the filters.
std::int64_t formula(int ranks, std::int64_t record, int iterations, Grid grid, bool filters = false) {
  const bool projected = grid != Grid::none;
  const std::int64_t messages = 2 * (ranks - 1);  // of one exchange: both ways through every cut
  const std::int64_t counts = 4 * rows * columns;
  // Places once with the list and in every sweep, and those of the filtered shifts; lambda in every sweep but the
  // projection, which asks for no densities, and what is in flight. The filters: velocities twice, and |omega|.
  const std::int64_t places_sent = 1 + iterations + (projected ? 1 : 0) + (filters ? 2 : 0);
  const std::int64_t scalars_sent = iterations + (filters ? 1 : 0);
  // For each cell of the fields both ways: the volume in three planes and the moments of its particles; their fit; the
  // moments of the shifts and their fit. Under gravity the flow that the filter of noise leaves, and its fit.
  constexpr int places = 10, flow = 12, fit = 13, volumes = 3, moments = places + flow + 1;
  const int noise = grid == Grid::upright ? flow + fit : 0;
  const std::int64_t field_cell = 8 * (volumes + moments + fit + noise + moments + fit);
  // For each cell that has a single one both ways: the fill; the pivot; phi in each of four sweeps a cycle. One way:
  // what holds phi at 0, and the residual of each cycle. Coarser levels are small enough to be gathered.
  const int cycles = 3, both_ways = 1 + 1 + 4 * cycles, one_way = 1 + cycles;
  const std::int64_t cell = 8 * both_ways + 4 * one_way;
  const std::int64_t heights = 4 * (rows + 2);  // of the water
  return messages * (counts + (3 * places_sent + scalars_sent) * particles_per_plane * record / 4 +
                     (projected ? heights + coarse_cells_per_plane * cell + field_cells_per_plane * field_cell : 0));
}

/// The same where `parts` ranks share each slab of a box with twice the rows, under gravity.
std::int64_t formula_of_parts(int ranks, int parts, std::int64_t record, int iterations) {
  constexpr int planes = 17, all_rows = 2 * rows, cycles = 3;
  const std::int64_t slabs = ranks / parts;
  // Rows of a plane that are sent to the slabs beside, to the ranks of the same slab, and across corners.
  const std::int64_t to_slabs = 2 * (slabs - 1) * all_rows, in_slabs = 2 * (parts - 1) * planes;
  const std::int64_t across = 4 * (slabs - 1) * (parts - 1);
  const std::int64_t beside_rows = in_slabs + across, around = to_slabs + beside_rows;
  const std::int64_t upper = to_slabs / 2 + in_slabs / 2 + across / 4;
  const std::int64_t particles = 8 * water_columns, cells = coarse_columns + 2, fours = (coarse_columns + 3) / 4 * 4;
  const std::int64_t records = (3 * (2 + iterations) + iterations) * particles * record / 4;
  constexpr int places = 10, flow = 12, fit = 13, volumes = 3, moments = places + flow + 1;
  const std::int64_t fields = 8 * (volumes + 2 * moments + 3 * fit + flow);
  // The fill of ghost planes; beside rows volumes, wetness, heights of the surface, masses, links across, the last phi.
  const std::int64_t once = to_slabs * 8 * cells + beside_rows * (72 * coarse_columns + cells + 4 * 8 * cells);
  // The pivot, the first phi and that of each sweep; what holds phi at 0, links, and residuals.
  const std::int64_t multigrid = 8 * cells * ((2 + 4 * cycles) * around + (4 + cycles) * upper);
  return around * (4 * columns + records + 4 + fours * fields) + once + multigrid;
}

class TrafficOf : public Output {
 protected:
  /// As counted, after it was found to be what halo_traffic() tells before a run.
  std::int64_t bytes_per_step(const std::vector<std::string>& overrides, int parts = 1) const {
    const Scene scene = scene_with(still_scene, overrides);
    BuildOptions options;
    options.directory = path("out");
    options.progress = ProgressMode::none;
    const std::unique_ptr<Solver> solver = build_solver(world, scene, std::move(options));
    solver->start();
    const Solver::Counters before = solver->counters();
    constexpr int steps = 12;  // with a look at the balance among them
    for (int k = 0; k < steps; ++k) solver->step();
    const Solver::Counters after = solver->counters();
    const std::int64_t sent = sum_over_ranks(world, after.halo_bytes - before.halo_bytes);
    const std::int64_t messages = sum_over_ranks(world, after.halo_messages - before.halo_messages);
    EXPECT_EQ(sent % steps, 0);
    const auto particles = static_cast<Real>(sum_over_ranks(world, solver->particles().size()));
    const RestingWater water = resting_water(scene, cell_grid(scene, scene.domain), particles);
    const Traffic told = halo_traffic(water, all_ranks(water, size_of(world) / parts, parts));
    EXPECT_EQ(told.bytes, static_cast<Real>(sent) / steps);
    EXPECT_EQ(told.messages, static_cast<Real>(messages) / steps);
    return sent / steps;
  }
};

TEST_F(TrafficOf, IsAsTheFormulaSays) {
  const int ranks = size_of(world);
  EXPECT_EQ(bytes_per_step({"density.precision='single'"}), formula(ranks, 16, 3, Grid::upright));
  EXPECT_EQ(bytes_per_step({"density.precision='double'", "density.iterations=7"}),
            formula(ranks, 32, 7, Grid::upright));
  EXPECT_EQ(bytes_per_step({"density.precision='single'", "density.method='jacobi'"}),
            formula(ranks, 16, 4, Grid::none));
  EXPECT_EQ(bytes_per_step({"density.precision='single'", "vorticity.epsilon=0.002", "viscosity.c=0.001"}),
            formula(ranks, 16, 3, Grid::upright, true));
}

TEST_F(TrafficOf, OfSlabsThatAreSharedIsAsTheFormulaSays) {
  const int ranks = size_of(world), parts = 2;
  const std::string shape = "domain.ranks=[" + std::to_string(ranks / parts) + ", " + std::to_string(parts) + "]";
  const std::vector<std::string> wide = {"domain.max=[3.4, 0.8, 1.6]", "particles.0.max=[3.4, 0.8, 1.0]",
                                         "density.precision='single'", shape};
  EXPECT_EQ(bytes_per_step(wide, parts), formula_of_parts(ranks, parts, 16, 3));
}

// A level beside the finest one is too large for all ranks to have.
TEST_F(TrafficOf, LevelsOfAWideBox) {
  const int ranks = size_of(world);
  const std::vector<std::string> wide = {"domain.max=[13.6, 12.8, 1.6]", "particles.0.max=[13.6, 12.8, 0.4]"};
  bytes_per_step(wide);
  std::vector<std::string> shared = wide;
  shared.push_back("domain.ranks=[" + std::to_string(ranks / 2) + ", 2]");
  bytes_per_step(shared, 2);
}

TEST_F(TrafficOf, NoiseIsThatOfGravityAlone) {
  const int ranks = size_of(world);
  EXPECT_EQ(bytes_per_step({"density.precision='single'", "gravity.acceleration=[0, 0, 0]"}),
            formula(ranks, 16, 3, Grid::floating));
}

}  // namespace
}  // namespace trevi::test

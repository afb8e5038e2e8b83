// The particles of inlets in walls, row by row, each row with its own speed.
#include <algorithm>
#include <cmath>

#include "base/threads.hpp"
#include "parallel/waiting.hpp"
#include "solver/inflow_outflow.hpp"

namespace trevi {

namespace {

constexpr Real max_owed_spacings = 2;  // spacings, for each row

}  // namespace

// For each row, the places whose water has moved by a spacing since the last layer, the farthest first.
std::vector<InflowOutflow::Due> InflowOutflow::due_places(std::size_t k, std::vector<RowDue>& rows) {
  const InletLattice& lattice = parts_.inlets[k]->lattice();
  const GlobalId columns = lattice.places() / lattice.rows();
  const Real spacing = parts_.spacing;
  std::vector<Due> due;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    Real& travelled = state_.rows[static_cast<std::size_t>(flows_->first_row(k)) + row];
    const Real layers = std::floor(travelled / spacing);
    travelled -= layers * spacing;
    rows[row] = {due.size(), static_cast<GlobalId>(layers)};
    for (Real n = layers - 1; n >= 0; --n) {
      for (GlobalId column = 0; column < columns; ++column)
        due.push_back({static_cast<GlobalId>(row) * columns + column, travelled + n * spacing});
    }
  }
  return due;
}

// Determines which of these hold no water on any rank.
std::vector<char> InflowOutflow::free_places(std::size_t k, const std::vector<Due>& due,
                                             const std::vector<RowDue>& rows, const Particles& particles) const {
  const InletLattice& lattice = parts_.inlets[k]->lattice();
  const GlobalId columns = lattice.places() / lattice.rows();
  const Real least = parts_.spacing / 2;
  std::vector<char> is_free(due.size(), 1);
  PerThread<std::vector<std::size_t>> found;
  for_each_part({0, particles.size()}, 2048, [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) {
      const Vec3& p = particles.position[static_cast<std::size_t>(i)];
      const InletLattice::Seen at = lattice.seen(p);
      if (at.ahead < -parts_.spacing) continue;
      for (const GlobalId place : lattice.around(at)) {
        const auto row = static_cast<std::size_t>(std::max<GlobalId>(place, 0) / columns);
        if (place < 0 || row >= rows.size()) continue;
        for (GlobalId n = 0; n < rows[row].layers; ++n) {
          const std::size_t one = rows[row].first + static_cast<std::size_t>(n * columns + place % columns);
          if ((p - lattice.position(place, due[one].ahead)).squaredNorm() < least * least) found.mine().push_back(one);
        }
      }
    }
  });
  found.for_each([&](const auto& ones) {
    for (const std::size_t one : ones) is_free[one] = 0;
  });
  all_reduce(comm_, is_free.data(), static_cast<int>(is_free.size()), MPI_BYTE, MPI_BAND);
  return is_free;
}

void InflowOutflow::run_rows(std::size_t k, Water& water, StepState& change) {
  const Inlet& inlet = *parts_.inlets[k];
  const std::vector<Real>& speeds = flows_->speeds(k);
  const GlobalId columns = inlet.lattice().places() / inlet.lattice().rows();
  FlowState::Stream& stream = state_.streams[k];
  std::vector<RowDue> rows(speeds.size());
  const std::vector<Due> due = due_places(k, rows);
  std::vector<Real> blocked(speeds.size(), 0);
  if (!due.empty()) {
    const std::vector<char> is_free = free_places(k, due, rows, water.particles);
    for (std::size_t n = 0; n < due.size(); ++n) {
      const auto row = static_cast<std::size_t>(due[n].place / columns);
      const Vec3 position = inlet.lattice().position(due[n].place, due[n].ahead);
      const bool solid = covers(inlet.lattice().position(due[n].place, 0), position);
      (solid ? stream.covered : is_free[n] != 0 ? stream.made : blocked[row]) += 1;
      if (solid || is_free[n] == 0) continue;
      if (water.slabs.owner(water.grid, position) == rank_of(comm_))
        add(water, position, inlet.velocity(speeds[row], state_.next_id, water.info));
      count(change, state_.next_id++, 1);
      ++state_.inflow;
    }
  }
  stream.speed = 0;
  for (std::size_t row = 0; row < speeds.size(); ++row) {
    Real& travelled = state_.rows[static_cast<std::size_t>(flows_->first_row(k)) + row];
    const Real owed = travelled + parts_.spacing * blocked[row] / static_cast<Real>(columns);
    travelled = std::min(owed, max_owed_spacings * parts_.spacing);
    stream.blocked += (owed - travelled) / parts_.spacing * static_cast<Real>(columns);
    travelled += speeds[row] * water.info.dt;
    stream.speed += speeds[row] / static_cast<Real>(speeds.size());
  }
}

}  // namespace trevi

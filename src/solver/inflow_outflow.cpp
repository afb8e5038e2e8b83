#include "solver/inflow_outflow.hpp"

#include <algorithm>
#include <cmath>

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "particles/remove.hpp"

namespace trevi {

namespace {

// A forcing lives in its solver's list, an inlet in the InflowOutflow, too.
class Nozzle : public Forcing {
 public:
  explicit Nozzle(std::shared_ptr<Inlet> inlet) : inlet_(std::move(inlet)) {}
  void prepare(const StepInfo& step) override { inlet_->prepare(step); }
  void apply(Particles& particles, const StepInfo& info) override { inlet_->apply(particles, info); }
  Real fastest(const TimeSpan& times) const override { return inlet_->fastest(times); }
  std::optional<FountainState> state(Real time) const override { return inlet_->state(time); }

 private:
  std::shared_ptr<Inlet> inlet_;
};

constexpr Real max_owed = 2;  // layers that an inlet still has to make, at most; the rest is forgotten

// Those in a region, in ascending order.
std::vector<LocalId> drained(const std::vector<DrainSettings>& regions, const std::vector<Vec3>& positions) {
  constexpr LocalId part_size = 8192;
  const Range all{0, static_cast<LocalId>(positions.size())};
  std::vector<std::vector<LocalId>> parts(static_cast<std::size_t>((all.size() + part_size - 1) / part_size));
  for_each_part(all, part_size, [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) {
      const Vec3& p = positions[static_cast<std::size_t>(i)];
      const auto takes = [&](const DrainSettings& region) { return drains(region, p); };
      if (std::any_of(regions.begin(), regions.end(), takes))
        parts[static_cast<std::size_t>(part.begin / part_size)].push_back(i);
    }
  });
  std::vector<LocalId> found;
  for (const auto& part : parts) found.insert(found.end(), part.begin(), part.end());
  return found;
}

void count(StepState& change, GlobalId id, std::uint64_t sign) {
  const auto n = static_cast<std::uint64_t>(id);
  change.particles += sign;
  change.ids += sign * n;
  change.squares += sign * n * n;
}

}  // namespace

InflowOutflow::InflowOutflow(Parts parts, std::optional<FlowState> state)
    : parts_(std::move(parts)),
      state_(state.value_or(FlowState{})),
      recycles_(std::any_of(parts_.inlets.begin(), parts_.inlets.end(), [](const auto& i) { return i->recycles(); })) {
  state_.streams.resize(parts_.inlets.size());
}

std::vector<std::unique_ptr<Forcing>> InflowOutflow::forcings() const {
  std::vector<std::unique_ptr<Forcing>> nozzles;
  for (const auto& inlet : parts_.inlets) nozzles.push_back(std::make_unique<Nozzle>(inlet));
  return nozzles;
}

void InflowOutflow::begin(MPI_Comm comm, const Particles& particles) {
  comm_ = comm;
  if (!consensus_) consensus_.emplace(comm);
  GlobalId next = state_.next_id;
  for (const GlobalId id : particles.id) next = std::max(next, id + 1);
  MPI_Allreduce(&next, &state_.next_id, 1, MPI_INT64_T, MPI_MAX, comm);
}

StepState InflowOutflow::exchange(Particles& particles, const StepInfo& info, const CellGrid& grid,
                                  const Slabs& slabs) {
  const ScopedEvent timed(event_);
  StepState change;
  if (!parts_.drains.empty()) drain(particles, change);
  Water water{particles, info, grid, slabs};
  for (std::size_t k = 0; k < parts_.inlets.size(); ++k) run(k, water, change);
  return change;
}

void InflowOutflow::drain(Particles& particles, StepState& change) {
  const std::vector<LocalId> gone = drained(parts_.drains, particles.position);
  StepState mine;
  for (const LocalId i : gone) count(mine, particles.id[static_cast<std::size_t>(i)], 1);
  remove_particles(particles, gone);
  const StepState all = consensus_->count(mine);
  const auto taken = static_cast<GlobalId>(all.particles);
  state_.outflow += taken;
  if (recycles_) state_.waiting += taken;
  change.particles -= all.particles;
  change.ids -= all.ids;
  change.squares -= all.squares;
}

// A layer is due when the water has come a spacing since the last one. It is made at the start of the next substep, as
// far ahead of the opening as it has come by then: no amount and no distance depends on how time is cut.
void InflowOutflow::run(std::size_t k, Water& water, StepState& change) {
  const Inlet& inlet = *parts_.inlets[k];
  FlowState::Stream& stream = state_.streams[k];
  const auto due = static_cast<GlobalId>(std::floor(stream.travelled / parts_.spacing));
  const GlobalId within_box = std::llround((parts_.box.max - parts_.box.min).norm() / parts_.spacing) + 1;
  stream.travelled -= static_cast<Real>(due) * parts_.spacing;
  const GlobalId layers = std::min(due, within_box);
  const Real first = stream.travelled + static_cast<Real>(layers - 1) * parts_.spacing;
  if (layers > 0) {
    const std::optional<GlobalId> made = make({inlet, stream.speed, first, layers}, water, change);
    if (!made) {
      stream.travelled = parts_.spacing;  // the next layer waits in the opening
      return;
    }
    // What was in the way is made up for by layers that come sooner: deep water gives way only when it is pressed.
    const Real all = static_cast<Real>(layers * inlet.lattice().open_places());
    const Real owed = parts_.spacing * static_cast<Real>(layers) * (1 - static_cast<Real>(*made) / all);
    stream.travelled = std::min(stream.travelled + owed, max_owed * parts_.spacing);
  }
  stream.speed = inlet.speed(water.info);
  stream.travelled += inlet.path_length(water.info);
}

// Places are numbered layer by layer, the farthest layer first.
std::vector<char> InflowOutflow::open_places(const Layers& layers, const Particles& particles) const {
  const InletLattice& lattice = layers.inlet.lattice();
  const Real spacing = parts_.spacing;
  const Real least = spacing / 2;
  PerThread<std::vector<GlobalId>> taken;
  constexpr LocalId part_size = 2048;
  for_each_part({0, particles.size()}, part_size, [&](Range part) {
    for (LocalId i = part.begin; i < part.end; ++i) {
      const Vec3& p = particles.position[static_cast<std::size_t>(i)];
      const InletLattice::Seen at = lattice.seen(p);
      const Real below = std::floor((layers.first - at.ahead) / spacing);
      for (const Real layer : {below, below + 1}) {
        if (layer < 0 || layer >= static_cast<Real>(layers.count)) continue;
        for (const GlobalId place : lattice.around(at)) {
          if (place < 0) continue;
          const Vec3 there = lattice.position(place, layers.first - layer * spacing);
          if ((p - there).squaredNorm() < least * least)
            taken.mine().push_back(static_cast<GlobalId>(layer) * lattice.places() + place);
        }
      }
    }
  });
  std::vector<char> open(static_cast<std::size_t>(layers.count * lattice.places()), 1);
  for (std::size_t n = 0; n < open.size(); ++n) {
    const GlobalId layer = static_cast<GlobalId>(n) / lattice.places(),
                   place = static_cast<GlobalId>(n) % lattice.places();
    open[n] = lattice.is_open(place) && parts_.box.contains(lattice.position(place, layers.ahead(layer, spacing)));
  }
  taken.for_each([&](const auto& places) {
    for (const GlobalId place : places) open[static_cast<std::size_t>(place)] = 0;
  });
  MPI_Allreduce(MPI_IN_PLACE, open.data(), static_cast<int>(open.size()), MPI_BYTE, MPI_BAND, comm_);
  return open;
}

// How many were made; nothing where there was not enough water for all of them.
std::optional<GlobalId> InflowOutflow::make(const Layers& layers, Water& water, StepState& change) {
  const InletLattice& lattice = layers.inlet.lattice();
  const std::vector<char> open = open_places(layers, water.particles);
  GlobalId made = 0;
  for (GlobalId layer = 0; layer < layers.count; ++layer) {
    const auto begin = open.begin() + layer * lattice.places(), end = begin + lattice.places();
    const GlobalId wanted = std::count(begin, end, 1);
    if (layers.inlet.recycles()) {
      if (wanted > state_.waiting) return std::nullopt;
      state_.waiting -= wanted;
    }
    state_.inflow += wanted;
    made += wanted;
    for (auto place = begin; place != end; ++place) {
      if (*place == 0) continue;
      const Vec3 position = lattice.position(place - begin, layers.ahead(layer, parts_.spacing));
      if (water.slabs.owner(water.grid.plane_of(position)) == rank_of(comm_))
        add(water, position, layers.inlet.velocity(layers.speed, state_.next_id, water.info));
      count(change, state_.next_id++, 1);
    }
  }
  return made;
}

void InflowOutflow::add(Water& water, const Vec3& position, const Vec3& velocity) const {
  Particles& particles = water.particles;
  const std::size_t n = particles.id.size();
  particles.for_each_field([&](auto& field) { resize_tightly(field, n + 1); });
  particles.id[n] = state_.next_id;
  particles.position[n] = particles.predicted[n] = position;
  particles.velocity[n] = velocity;
  const Real x = (position.x() - parts_.box.min.x()) / (parts_.box.max.x() - parts_.box.min.x());
  if (particles.has_hue) particles.hue[n] = static_cast<float>(x);
}

}  // namespace trevi

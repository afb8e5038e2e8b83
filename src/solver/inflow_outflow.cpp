#include "solver/inflow_outflow.hpp"

#include <algorithm>
#include <cmath>

#include "base/growth.hpp"
#include "base/threads.hpp"
#include "parallel/waiting.hpp"
#include "particles/remove.hpp"

namespace trevi {

namespace {

// A forcing belongs to the list of its solver; an inlet belongs to the InflowOutflow as well.
class Nozzle : public Forcing {
 public:
  explicit Nozzle(std::shared_ptr<Inlet> inlet) : inlet_(std::move(inlet)) {}
  void prepare(const StepInfo& step) override { inlet_->prepare(step); }
  void apply(Particles& particles, const StepInfo& info) override { inlet_->apply(particles, info); }
  Real holds_for(GlobalId id, const Vec3& p, const StepInfo& info) const override {
    return inlet_->holds_for(id, p, info);
  }
  Real fastest(const TimeSpan& times) const override { return inlet_->fastest(times); }
  std::optional<FountainState> state(Real time) const override { return inlet_->state(time); }

 private:
  std::shared_ptr<Inlet> inlet_;
};

// Of an inlet in a wall: water at most a spacing ahead of it has the speed of its row and falls like all water.
class WallNozzle : public Forcing {
 public:
  WallNozzle(std::shared_ptr<Inlet> inlet, std::shared_ptr<WallFlows> flows, std::size_t k, const Vec3& gravity,
             const FlowState::Stream& stream)
      : inlet_(std::move(inlet)), flows_(std::move(flows)), k_(k), gravity_(gravity), stream_(stream) {}
  void apply(Particles& particles, const StepInfo& info) override {
    const std::vector<Real>& speeds = flows_->speeds(k_);
    for_each_index({0, particles.size()}, [&](std::size_t i) {
      const Vec3& p = particles.position[i];
      if (!inlet_->lattice().in_nozzle(p)) return;
      const auto row = static_cast<std::size_t>(std::floor(inlet_->lattice().seen(p).row + 0.5));
      if (row >= speeds.size() || speeds[row] == 0) return;
      particles.velocity[i] = inlet_->velocity(speeds[row], particles.id[i], info) + info.dt * gravity_;
    });
  }
  Real fastest(const TimeSpan&) const override { return largest(); }
  std::optional<FountainState> state(Real) const override { return FountainState{NAN, stream_.speed}; }

 private:
  Real largest() const {
    const std::vector<Real>& speeds = flows_->speeds(k_);
    return *std::max_element(speeds.begin(), speeds.end());
  }

  std::shared_ptr<Inlet> inlet_;
  std::shared_ptr<WallFlows> flows_;
  std::size_t k_;
  Vec3 gravity_;
  const FlowState::Stream& stream_;  // of an InflowOutflow that lives as long
};

constexpr Real max_owed = 2;  // layers that an inlet still has to make, at most; the rest is dropped

// The particles in one of the regions, in ascending order.
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

}  // namespace

void count(StepState& change, GlobalId id, std::uint64_t sign) {
  const auto n = static_cast<std::uint64_t>(id);
  change.particles += sign;
  change.ids += sign * n;
  change.squares += sign * n * n;
}

InflowOutflow::InflowOutflow(Parts parts, std::optional<FlowState> state)
    : parts_(std::move(parts)),
      flows_(parts_.flows),
      state_(state.value_or(FlowState{})),
      recycles_(std::any_of(parts_.inlets.begin(), parts_.inlets.end(), [](const auto& i) { return i->recycles(); })) {
  state_.streams.resize(parts_.inlets.size());
  std::vector<Openings::Drain> regions;
  for (const DrainSettings& drain : parts_.drains)
    regions.push_back({[drain](const Vec3& p) { return drains(drain, p); }, bounds_of(drain)});
  if (flows_) flows_->resize(state_);
  openings_ = std::make_unique<Openings>(std::move(regions));
}

std::vector<std::unique_ptr<Forcing>> InflowOutflow::forcings() const {
  std::vector<std::unique_ptr<Forcing>> nozzles;
  for (std::size_t k = 0; k < parts_.inlets.size(); ++k) {
    if (flows_ && flows_->first_row(k) >= 0) {
      nozzles.push_back(std::make_unique<WallNozzle>(parts_.inlets[k], flows_, k, parts_.gravity, state_.streams[k]));
    } else {
      nozzles.push_back(std::make_unique<Nozzle>(parts_.inlets[k]));
    }
  }
  return nozzles;
}

void InflowOutflow::begin(MPI_Comm comm, const Boundary& boundary, const Particles& particles) {
  comm_ = comm;
  boundary_ = &boundary;
  for (const auto& inlet : parts_.inlets) {
    inlet->place_in(parts_.gravity, [this](const Vec3& from, const Vec3& place) { return covers(from, place); });
  }
  if (!consensus_) consensus_.emplace(comm);
  GlobalId next = state_.next_id;
  for (const GlobalId id : particles.id) next = std::max(next, id + 1);
  MPI_Allreduce(&next, &state_.next_id, 1, MPI_INT64_T, MPI_MAX, comm);
}

StepState InflowOutflow::exchange(Particles& particles, const StepInfo& info, const CellGrid& grid,
                                  const Slabs& slabs) {
  const ScopedEvent timed(event_);
  StepState change;
  if (flows_) flows_->measure(comm_, particles, info, state_);
  if (!parts_.drains.empty() || flows_) drain(particles, info.dt, change);
  sources_.clear();
  Water water{particles, info, grid, slabs};
  for (std::size_t k = 0; k < parts_.inlets.size(); ++k) {
    if (flows_ && flows_->first_row(k) >= 0) {
      run_rows(k, water, change);
    } else {
      run(k, water, change);
    }
  }
  if (flows_) openings_->set_walls(flows_->walls(info.dt));
  openings_->set_sources(sources_, parts_.spacing);
  return change;
}

void InflowOutflow::drain(Particles& particles, Real dt, StepState& change) {
  std::vector<LocalId> gone = drained(parts_.drains, particles.position);
  if (flows_) {
    const std::vector<LocalId> through = flows_->leaving(comm_, particles, dt, state_);
    std::vector<LocalId> all;
    std::set_union(gone.begin(), gone.end(), through.begin(), through.end(), std::back_inserter(all));
    gone.swap(all);
  }
  StepState mine;
  for (const LocalId i : gone) count(mine, particles.id[static_cast<std::size_t>(i)], 1);
  remove_particles(particles, gone);
  const StepState all = consensus_->count(mine);
  const auto gone_everywhere = static_cast<GlobalId>(all.particles);
  state_.outflow += gone_everywhere;
  if (recycles_) state_.waiting += gone_everywhere;
  change.particles -= all.particles;
  change.ids -= all.ids;
  change.squares -= all.squares;
}

// A layer is due when the water has moved by a spacing since the last one. It is made at the start of the next substep,
// as far ahead of the opening as the water has moved by then: neither amounts nor distances depend on how time is
// divided.
void InflowOutflow::run(std::size_t k, Water& water, StepState& change) {
  const Inlet& inlet = *parts_.inlets[k];
  FlowState::Stream& stream = state_.streams[k];
  const auto due = static_cast<GlobalId>(std::floor(stream.travelled / parts_.spacing));
  const GlobalId within_box = std::llround((parts_.box.max - parts_.box.min).norm() / parts_.spacing) + 1;
  const Real came = stream.travelled;
  stream.travelled -= static_cast<Real>(due) * parts_.spacing;
  const GlobalId layers = std::min(due, within_box);
  const Real first = stream.travelled + static_cast<Real>(layers - 1) * parts_.spacing;
  if (layers > 0) {
    const Made made = make({inlet, stream.speed, first, layers}, water, change);
    const auto in_layer = static_cast<Real>(inlet.lattice().open_places());
    stream.made += static_cast<Real>(made.particles);
    stream.covered += static_cast<Real>(made.covered) + static_cast<Real>(due - layers) * in_layer;
    if (made.dry) {
      const auto done = static_cast<Real>(made.particles + made.covered + made.blocked);
      stream.blocked += static_cast<Real>(made.blocked);
      stream.dry += std::max<Real>(0, (came / parts_.spacing - 1) * in_layer - done);
      stream.travelled = parts_.spacing;  // the next layer waits in the opening
      return;
    }
    // Blocked places are made up for by layers that come sooner: deep water gives way only under pressure.
    const Real owed = stream.travelled + parts_.spacing * static_cast<Real>(made.blocked) / in_layer;
    stream.travelled = std::min(owed, max_owed * parts_.spacing);
    stream.blocked += (owed - stream.travelled) / parts_.spacing * in_layer;
  }
  stream.speed = inlet.speed(water.info);
  const Real path = inlet.path_length(water.info);
  stream.travelled += path;
  add_sources(inlet, path);
}

// Where the water of a layer comes out. The water in its way has to make room from now on, not all at once when the
// layer is made.
void InflowOutflow::add_sources(const Inlet& inlet, Real path) {
  const InletLattice& lattice = inlet.lattice();
  for (GlobalId place = 0; path > 0 && place < lattice.places(); ++place) {
    const Vec3 from = lattice.position(place, 0);
    if (lattice.is_open(place) && !covers(from, lattice.position(place, parts_.spacing)))
      sources_.push_back({from, lattice.direction(), path * parts_.spacing * parts_.spacing});
  }
}

std::vector<char> InflowOutflow::places(const Layers& layers, const Particles& particles) const {
  const InletLattice& lattice = layers.inlet.lattice();
  const Real spacing = parts_.spacing;
  const Real least = spacing / 2;
  PerThread<std::vector<GlobalId>> found;
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
            found.mine().push_back(static_cast<GlobalId>(layer) * lattice.places() + place);
        }
      }
    }
  });
  std::vector<char> places(static_cast<std::size_t>(layers.count * lattice.places()), open);
  for (std::size_t n = 0; n < places.size(); ++n) {
    const GlobalId layer = static_cast<GlobalId>(n) / lattice.places(),
                   place = static_cast<GlobalId>(n) % lattice.places();
    if (!lattice.is_open(place)) {
      places[n] = taken;
    } else if (covers(lattice.position(place, 0), lattice.position(place, layers.ahead(layer, spacing)))) {
      places[n] = covered;
    }
  }
  found.for_each([&](const auto& water) {
    for (const GlobalId place : water) places[static_cast<std::size_t>(place)] &= covered;
  });
  all_reduce(comm_, places.data(), static_cast<int>(places.size()), MPI_BYTE, MPI_BAND);
  return places;
}

bool InflowOutflow::covers(const Vec3& from, const Vec3& place) const {
  const Obstacles* obstacles = boundary_->obstacles();
  return !parts_.box.contains(place) || (obstacles != nullptr && obstacles->covers(from, place));
}

InflowOutflow::Made InflowOutflow::make(const Layers& layers, Water& water, StepState& change) {
  const InletLattice& lattice = layers.inlet.lattice();
  const std::vector<char> all = places(layers, water.particles);
  Made made;
  for (GlobalId layer = 0; layer < layers.count; ++layer) {
    const auto begin = all.begin() + layer * lattice.places(), end = begin + lattice.places();
    const GlobalId wanted = std::count(begin, end, open), hidden = std::count(begin, end, covered);
    made.dry = layers.inlet.recycles() && wanted > state_.waiting;
    if (made.dry) return made;
    if (layers.inlet.recycles()) state_.waiting -= wanted;
    state_.inflow += wanted;
    made.particles += wanted;
    made.covered += hidden;
    made.blocked += lattice.open_places() - hidden - wanted;
    // It left the nozzle this long ago.
    const Real ahead = layers.ahead(layer, parts_.spacing);
    const Real flown = layers.speed > 0 ? std::max<Real>(0, ahead - parts_.spacing) / layers.speed : 0;
    const Vec3 fallen = parts_.gravity * flown;
    for (auto place = begin; place != end; ++place) {
      if (*place != open) continue;
      const Vec3 straight = lattice.position(place - begin, ahead), lower = straight + flown / 2 * fallen;
      const Vec3& position = covers(straight, lower) ? straight : lower;
      if (water.slabs.owner(water.grid, position) == rank_of(comm_))
        add(water, position, layers.inlet.velocity(layers.speed, state_.next_id, water.info) + fallen);
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

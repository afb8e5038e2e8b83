#include "solver/make_flow.hpp"

#include <fmt/format.h>

#include "fluid/forcings/fountain.hpp"
#include "music/music.hpp"

namespace trevi {

namespace {

// A fountain or an inlet, by its index in its list.
struct Place {
  const char* list;
  std::size_t index;
};

std::unique_ptr<Pump> make_pump(MPI_Comm comm, const PumpSettings& settings, const Place& place,
                                std::shared_ptr<LiveSound>& live) {
  if (!settings.music) return std::make_unique<ConstantPump>(settings.speed);
  try {
    return make_music_pump(comm, *settings.music, live);
  } catch (const InputError& error) {
    throw MusicError(place.list, place.index, error.what());
  }
}

}  // namespace

MusicError::MusicError(const char* list, std::size_t index, const std::string& why)
    : InputError(fmt::format("settings of the solver: {}s[{}].music: {}", list, index, why)),
      list_(list),
      index_(index),
      why_(why) {}

FlowParts make_flow(MPI_Comm comm, const Settings& settings, std::optional<FlowState> state) {
  FlowParts flow;
  std::shared_ptr<LiveSound> live;
  int stream = 0;  // of random numbers
  for (std::size_t k = 0; k < settings.fountains.size(); ++k) {
    const FountainSettings& fountain = settings.fountains[k];
    flow.fountains.push_back(std::make_unique<Fountain>(fountain, make_pump(comm, fountain, {"fountain", k}, live),
                                                        settings.domain.min.z(), settings.seed, stream++));
  }
  if (settings.inlets.empty() && settings.drains.empty()) return flow;
  const Real spacing = settings.fluid.spacing;
  InflowOutflow::Parts parts{{}, {}, settings.domain, spacing, settings.gravity.value_or(Vec3::Zero())};
  for (const DrainSettings& drain : settings.drains) {
    if (!drain.is_in_wall()) parts.drains.push_back(drain);
  }
  auto flows = std::make_shared<WallFlows>(settings);
  if (flows->any()) parts.flows = std::move(flows);
  for (std::size_t k = 0; k < settings.inlets.size(); ++k) {
    const InletSettings& inlet = settings.inlets[k];
    parts.inlets.push_back(
        std::make_shared<Inlet>(inlet, make_pump(comm, inlet, {"inlet", k}, live), spacing, settings.seed, stream++));
  }
  flow.inlets_and_drains = std::make_shared<InflowOutflow>(std::move(parts), std::move(state));
  return flow;
}

}  // namespace trevi

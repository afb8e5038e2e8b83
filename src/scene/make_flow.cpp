#include "scene/make_flow.hpp"

#include "fluid/forcings/fountain.hpp"
#include "scene/scene_place.hpp"

namespace trevi {

namespace {

// Pumps that follow standard input share it.
std::unique_ptr<Pump> make_pump(MPI_Comm comm, const Scene& scene, const PumpSettings& settings, const char* key,
                                std::shared_ptr<LiveSound>& live) {
  if (!settings.music) return std::make_unique<ConstantPump>(settings.speed);
  return told_at(scene, settings.line, key, [&] { return make_music_pump(comm, *settings.music, live); });
}

}  // namespace

std::vector<std::unique_ptr<Forcing>> make_fountains(MPI_Comm comm, const Scene& scene,
                                                     std::shared_ptr<LiveSound>& live) {
  std::vector<std::unique_ptr<Forcing>> forcings;
  int index = 0;
  for (const FountainSettings& fountain : scene.fountains) {
    forcings.push_back(std::make_unique<Fountain>(fountain,
                                                  make_pump(comm, scene, fountain, "[[fountain]] music", live),
                                                  scene.domain.min.z(), scene.seed, index++));
  }
  return forcings;
}

std::shared_ptr<InflowOutflow> make_flow(MPI_Comm comm, const Scene& scene, std::optional<FlowState> state,
                                         std::shared_ptr<LiveSound>& live) {
  if (scene.inlets.empty() && scene.drains.empty()) return nullptr;
  InflowOutflow::Parts parts{{}, scene.drains, scene.domain, scene.fluid.spacing,
                             scene.gravity.value_or(Vec3::Zero())};
  auto index = static_cast<int>(scene.fountains.size());
  for (const InletSettings& inlet : scene.inlets) {
    parts.inlets.push_back(std::make_shared<Inlet>(inlet, make_pump(comm, scene, inlet, "[[inlet]] music", live),
                                                   scene.fluid.spacing, scene.seed, index++));
  }
  return std::make_shared<InflowOutflow>(std::move(parts), std::move(state));
}

std::vector<std::unique_ptr<Forcing>> make_fountains(MPI_Comm comm, const Scene& scene) {
  std::shared_ptr<LiveSound> live;
  return make_fountains(comm, scene, live);
}

std::shared_ptr<InflowOutflow> make_flow(MPI_Comm comm, const Scene& scene) {
  std::shared_ptr<LiveSound> live;
  return make_flow(comm, scene, std::nullopt, live);
}

}  // namespace trevi

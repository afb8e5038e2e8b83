#include "scene/scene_flow.hpp"

#include "scene/scene_changes.hpp"
#include "scene/scene_place.hpp"
#include "solver/make_solver.hpp"

namespace trevi {

FlowParts make_scene_flow(MPI_Comm comm, const Scene& scene, std::optional<FlowState> state) {
  try {
    return make_flow(comm, scene, std::move(state));
  } catch (const MusicError& error) {
    throw InputError(SceneTable(error.list(), error.index()).place_in(scene, "music") + error.why());
  }
}

std::unique_ptr<Solver> make_solver(MPI_Comm comm, const Scene& scene, Particles particles, SolverExtras extras) {
  FlowParts flow = make_scene_flow(comm, scene, std::move(extras.flow));
  const CheckpointInfo info = scene.output.directory.empty() ? CheckpointInfo{} : checkpoint_info(comm, scene);
  return make_solver_with(comm, scene, std::move(particles), std::move(extras), std::move(flow), info);
}

}  // namespace trevi

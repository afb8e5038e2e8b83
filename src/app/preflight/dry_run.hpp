// Reports what a run would need, without touching a file: particles, memory, slabs, halo, time step, run time, planned
// output against the free disk space. Collective.
#pragma once

#include <string>

#include "app/launch.hpp"
#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

void print_dry_run(const Session& session, const Scene& scene, const Launch& launch, const std::string& directory);

}  // namespace trevi

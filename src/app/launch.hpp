// How a run is distributed over its machines: ranks and their threads. Collective unless stated otherwise.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct Launch {
  int ranks = 1;
  int threads_min = 1, threads_max = 1;  ///< of a rank; they differ if ranks have different cores
};

/// The number of threads that a text specifies, if it does and the number is valid. Not collective.
std::optional<int> whole_threads(std::string_view text);

/// Gives this rank its threads: `wanted` (from the command line), else those of the scene, else those of
/// OMP_NUM_THREADS, else as many as there are cores for it (Session::fair_threads). InputError on all ranks alike for
/// an invalid OMP_NUM_THREADS.
Launch use_threads(const Session& session, std::optional<int> wanted, const Scene& scene);

/// "2 ranks x 4 threads, AVX-512, single precision". Not collective.
std::string launch_text(const Launch& launch, const Scene& scene);

/// "96,000". Not collective.
std::string with_commas(std::int64_t number);

}  // namespace trevi

// Makes the fountains, inlets and drains of the settings with their music, for a solver that may continue a previous
// one. Collective.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fluid/forcings/fountain.hpp"
#include "solver/inflow_outflow.hpp"
#include "trevi/error.hpp"
#include "trevi/settings.hpp"

namespace trevi {

/// Pumps and drains that have been made but not started.
struct FlowParts {
  std::vector<std::unique_ptr<Fountain>> fountains;  ///< in the order of the settings
  std::shared_ptr<InflowOutflow> inlets_and_drains;  ///< null without any
};

/// Music that cannot be used. A program is told the member of its settings; a caller with a scene can name the line.
class MusicError : public InputError {
 public:
  /// `list`: as a scene names it, "fountain" or "inlet".
  MusicError(const char* list, std::size_t index, const std::string& why);
  const char* list() const { return list_; }
  std::size_t index() const { return index_; }
  const std::string& why() const { return why_; }

 private:
  const char* list_;
  std::size_t index_;
  std::string why_;
};

/// Pumps that follow standard input share it. `settings` are those of checked_and_resolved(), or those of a scene.
/// Throws MusicError on all ranks alike.
FlowParts make_flow(MPI_Comm comm, const Settings& settings, std::optional<FlowState> state = std::nullopt);

}  // namespace trevi

// Checkpoints: DIR/checkpoint_<step>.h5 holds all that a restart needs, with rows sorted by id, and is the same on any
// rank count. It contains /particles/ id and the saved fields of fields.hpp (position, velocity, perhaps hue),
// /checksums/ of the same names (one for each 1024 rows), /scene (text), /music, /obstacle_files, /flow and /streams
// (of inlets and drains), /bodies (a row of numbers each), /first_cell (for periodic boxes, if it is not 0), and at the
// root format, step, time, dt, substeps, seed, program_version, scene_overrides, fountain_note, fountain_speed. Random
// numbers and fountains are functions of (seed, id, step), so these are their state. A checkpoint is written under a
// temporary name, synced and renamed; only then are older ones removed, down to `keep`. Collective: all but the struct
// definitions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/hdf5/particle_file.hpp"
#include "parallel/log.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

/// What identifies the run, besides its particles and clock.
struct CheckpointInfo {
  std::string scene_text, program_version;
  std::int64_t seed = 1;
  std::int64_t scene_overrides = 0;  ///< number of lines "# --set table.key=value" at the end of the text
  /// Checksums of the file of each fountain and inlet, and of the mesh and motion files of each obstacle in turn; 0
  /// without a file. Empty: not known.
  std::vector<std::int64_t> music{}, obstacle_files{};
};

/// RunError on all ranks alike; an existing file of that name is then still the old one.
void write_checkpoint(MPI_Comm comm, const std::string& path, const CheckpointInfo& info, const Frame& frame);

struct CheckpointState {
  ParticleRows rows;
  std::int64_t step = 0;
  Real dt = 0, time = 0;
  int substeps = 1;
  CheckpointInfo info;
  std::optional<FlowState> flow;  ///< with inlets or drains only
  std::array<LocalId, 3> first_cell{};
  ForceSums force_sums;
  Real supplied_energy = 0;          ///< J
  std::vector<Real> paddle_offsets;  ///< m, of absorbing paddles
  std::vector<BodyState> bodies;
};

/// InputError on all ranks alike if the file is missing, foreign or larger than the memory; DamagedFile if it is
/// truncated, damaged or incomplete.
CheckpointState read_checkpoint(MPI_Comm comm, const std::string& path);

/// The checkpoints of a folder, that of the highest step first, for --restart latest. InputError if there is none.
std::vector<std::string> newest_checkpoints(MPI_Comm comm, const std::string& directory);

/// A scene without [output.checkpoint] gets a checkpoint only when somebody asks the run to stop or to save.
enum class CheckpointTimes { scheduled, asked_for };

struct CheckpointOptions {
  std::string directory;
  Schedule schedule;  ///< step 0 and the end of the run are always written, too
  int keep = 2;       ///< number of newest checkpoints that are kept; at least 1
  CheckpointInfo info;
  std::optional<std::int64_t> restart_step;  ///< checkpoints past it are renamed *.stale
  CheckpointTimes when = CheckpointTimes::scheduled;
};

class CheckpointWriter : public Observer {
 public:
  CheckpointWriter(MPI_Comm comm, CheckpointOptions options);

  bool due(const Clock& clock) const override;
  void observe(const Frame& frame) override { write(frame); }
  /// Writes the last state, unless it is already on disk or contains a number that is not finite: a blown-up state must
  /// not become the latest checkpoint.
  void finish(const Frame& frame) override;

  void save(const Frame& frame) override;

 private:
  void write(const Frame& frame);
  std::string path_of(std::int64_t step) const;
  void remove_old() const;

  MPI_Comm comm_;
  CheckpointOptions options_;
  Event event_{"Checkpoints"};
  std::int64_t last_step_ = -1;  ///< of the newest checkpoint in the folder that belongs to this run
};

}  // namespace trevi

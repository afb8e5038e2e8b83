// What the writers of frames for ParaView (vtu.hpp, vtkhdf.hpp) share: when a frame is due, which fields it has, the
// list of frames, and what a restart does with later ones. Invariant: the list names only complete frames; a step is
// written once. Collective: the constructor and observe().
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/frames/fields.hpp"
#include "io/frames/frame_list_file.hpp"
#include "io/frames/frame_selection.hpp"
#include "io/frames/obstacle_frames.hpp"
#include "io/run_directory/files.hpp"
#include "parallel/log.hpp"
#include "trevi/observer.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct FrameOptions {
  std::string directory;
  Schedule schedule;
  std::vector<std::string> fields;  ///< names of output_fields
  ColourScale colour;
  std::optional<std::int64_t> restart_step;  ///< entries past it are removed from the list, their files renamed *.stale
  std::shared_ptr<const ObstacleSurfaces> obstacles;  ///< null if the scene has none
  std::optional<FrameSelection> selection{};          ///< none: all particles
  /// Points in single precision; and the cells, which only say that each particle is a vertex, in the smallest form
  /// that VTK's reader accepts (vtkhdf.hpp).
  bool single_points = false, short_cells = false;
};

/// One row for each of these points; in double precision the points themselves.
Rows point_rows(const std::vector<Vec3>& points, bool single);
inline RowFormat point_format(bool single) { return {single ? Scalar::float32 : Scalar::float64, 3}; }

/// Names of a format's files, relative to the output directory, and of the event that times them.
struct FrameFiles {
  std::string event;
  std::string list;
  std::string folder;              ///< of the frames, with a slash at its end, or empty
  std::vector<SteppedName> kinds;  ///< of a frame, and of its pieces
};

class FrameWriter : public Observer {
 public:
  bool due(const Clock& clock) const override { return clock.step > last_step_ && options_.schedule.due(clock); }
  bool wants_density() const override;
  void observe(const Frame& frame) override;

 protected:
  FrameWriter(MPI_Comm comm, FrameOptions options, FrameFiles files);

  /// Writes a complete frame of this name, including the folder; RunError on all ranks alike.
  virtual void write(const Frame& frame, const std::string& path) = 0;

  MPI_Comm comm() const { return comm_; }
  const FrameOptions& options() const { return options_; }
  const std::vector<const OutputField*>& fields() const { return fields_; }
  Rows rows_of(const OutputField& field, const Frame& frame) const;

 private:
  void open();
  void write_selected(const Frame& frame, const std::string& path);

  MPI_Comm comm_;
  FrameOptions options_;
  FrameFiles files_;
  Event event_;
  std::vector<const OutputField*> fields_;
  std::optional<FrameListFile> list_;        ///< rank 0 only, like the next
  std::optional<ObstacleFrames> obstacles_;  ///< if the scene has any
  std::int64_t last_step_ = -1;              ///< of the last frame listed
};

}  // namespace trevi

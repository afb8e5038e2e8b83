// What the fountains of a scene will do, shown before a long run: the curves of the pumps alone, without simulation. A
// .csv file: time,note_0,speed_0,... with a row for the start and for each step, numbers as in series.csv. Collective.
#pragma once

#include <cstdint>
#include <string>

#include "trevi/scene.hpp"
#include "trevi/session.hpp"

namespace trevi {

struct PreviewOptions {
  std::string file;
  std::int64_t last_step = 0;
};

/// InputError for a scene without fountains, and for an existing file that is not a preview.
void write_preview(const Session& session, const Scene& scene, const PreviewOptions& options);

}  // namespace trevi

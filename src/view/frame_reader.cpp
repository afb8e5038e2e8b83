#include "view/frame_reader.hpp"

#include <filesystem>

#include "io/frames/colour.hpp"
#include "io/frames/visible.hpp"
#include "io/run_directory/files.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

// The colours of the run; otherwise a rainbow over ids, which grow with the position in an initial lattice, or over x.
Rgb rainbow_of(const RawFrame& raw, const ViewedScene& scene, std::size_t i) {
  if (!raw.rgb.empty()) return raw.rgb[i];
  const auto count = static_cast<Real>(raw.position.size());
  if (!raw.id.empty()) return rainbow(static_cast<Real>(raw.id[i]) / count);
  return rainbow((raw.position[i].x() - scene.min.x()) / (scene.max.x() - scene.min.x()));
}

ViewedParticle particle_of(const RawFrame& raw, const ViewedScene& scene, std::size_t i) {
  const Eigen::Vector3f p = raw.position[i].cast<float>();
  ViewedParticle particle{p.x(), p.y(), p.z(), NAN};
  if (!raw.speed.empty()) particle.speed = raw.speed[i];
  if (!raw.density.empty()) particle.density = raw.density[i];
  const Rgb rgb = rainbow_of(raw, scene, i);
  std::copy(rgb.begin(), rgb.end(), particle.rgb);
  return particle;
}

}  // namespace

RawFrame read_raw(const std::string& path) {
  RawFrame raw = path.ends_with(".hdf") ? read_hdf_frame(path) : read_vtu_frame(path);
  const std::size_t count = raw.position.size();
  for (const std::size_t size : {raw.speed.size(), raw.density.size(), raw.id.size(), raw.rgb.size()}) {
    if (size != 0 && size != count) throw InputError(path + ": its fields have different lengths; use another copy");
  }
  return raw;
}

// Files beside the frame, regardless of what the list of frames can name.
std::vector<std::shared_ptr<const TriangleMesh>> FrameReader::solids_of(const FrameEntry& entry) const {
  const std::filesystem::path folder = std::filesystem::path(entry.path).parent_path();
  const std::string still = (folder / still_obstacles).string(),
                    moving = (folder / name_of_step(obstacle_frames, entry.step)).string();
  std::vector<std::shared_ptr<const TriangleMesh>> solids;
  if (!still_ && std::filesystem::exists(still)) still_ = std::make_shared<TriangleMesh>(read_vtp_surface(still));
  if (still_) solids.push_back(still_);
  if (std::filesystem::exists(moving)) solids.push_back(std::make_shared<TriangleMesh>(read_vtp_surface(moving)));
  return solids;
}

ViewedFrame FrameReader::read(const FrameEntry& entry) const {
  const RawFrame raw = read_raw(entry.path);
  VisibleCells cells({scene_.min, scene_.max}, 2 * scene_.spacing);
  if (!all_) {
    for (const Vec3& p : raw.position) cells.mark(p);
  }
  cells.find_hidden();
  std::int64_t visible = 0;
  for (const Vec3& p : raw.position) visible += cells.hidden(p) ? 0 : 1;
  ViewedFrame frame;
  frame.step = entry.step;
  frame.time = entry.time;
  frame.solids = solids_of(entry);
  frame.particles = static_cast<std::int64_t>(raw.position.size());
  frame.level = all_ ? 0 : thinning_level(visible, budget_);
  frame.shown.reserve(static_cast<std::size_t>(visible));
  std::size_t i = 0;
  for (const std::int64_t count : raw.rank_counts) {
    const std::size_t first = frame.shown.size();
    for (const std::size_t end = i + static_cast<std::size_t>(count); i < end; ++i) {
      const auto id = raw.id.empty() ? static_cast<GlobalId>(i) : raw.id[i];
      if (!cells.hidden(raw.position[i]) && drawn_at(id, frame.level))
        frame.shown.push_back(particle_of(raw, scene_, i));
    }
    frame.rank_counts.push_back(static_cast<std::int64_t>(frame.shown.size() - first));
  }
  return frame;
}

}  // namespace trevi

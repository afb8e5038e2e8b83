#include "io/frames/frame_selection.hpp"

#include <numeric>

#include "base/threads.hpp"
#include "io/frames/visible.hpp"

namespace trevi {

namespace {

template <class T>
std::vector<T> rows_at(const std::vector<LocalId>& places, const T* from) {
  std::vector<T> rows(places.size());
  for_each_index({0, static_cast<LocalId>(rows.size())},
                 [to = rows.data(), from, places = places.data()](std::size_t k) { to[k] = from[places[k]]; });
  return rows;
}

}  // namespace

bool FrameSelection::in_box(const Vec3& p) const {
  for (int a = 0; a < 3; ++a) {
    const bool below = p[a] < options_.box->min[a] && options_.box->min[a] > options_.domain.min[a];
    const bool above = p[a] >= options_.box->max[a] && options_.box->max[a] < options_.domain.max[a];
    if (below || above) return false;
  }
  return true;
}

std::vector<LocalId> FrameSelection::near_surface(MPI_Comm comm, const std::vector<Vec3>& positions) const {
  std::vector<LocalId> places(positions.size());
  std::iota(places.begin(), places.end(), 0);
  if (!options_.surface) return places;
  VisibleCells cells(options_.domain, *options_.surface);
  for (const Vec3& p : positions) cells.mark(p);
  const auto marks = cells.marks();
  MPI_Allreduce(MPI_IN_PLACE, marks.data(), static_cast<int>(marks.size()), MPI_UINT8_T, MPI_BOR, comm);
  cells.find_hidden();
  std::erase_if(places, [&](LocalId i) { return cells.hidden(positions[static_cast<std::size_t>(i)]); });
  return places;
}

SelectedFrame FrameSelection::select(MPI_Comm comm, const Frame& frame) const {
  const Particles& all = frame.particles;
  std::vector<LocalId> places = near_surface(comm, all.position);
  std::erase_if(places, [&](LocalId i) {
    const auto k = static_cast<std::size_t>(i);
    return !drawn_at(all.id[k], options_.thinning) || (options_.box && !in_box(all.position[k]));
  });
  SelectedFrame selected;
  selected.particles.id = rows_at(places, all.id.data());
  selected.particles.position = rows_at(places, all.position.data());
  selected.particles.velocity = rows_at(places, all.velocity.data());
  selected.particles.has_hue = all.has_hue;
  if (all.has_hue) selected.particles.hue = rows_at(places, all.hue.data());
  if (!frame.density.empty()) selected.density = rows_at(places, frame.density.data());
  return selected;
}

}  // namespace trevi

// The loops of cut cells (cut_cells.hpp).
#pragma once

namespace trevi {

template <class Visit>
void CutCells::move_faces(const Visit& visit) {
  const std::vector<PartOfFace>& parts = parts_.of_faces();
  for (std::size_t n = 0; n < parts.size();) {
    const auto [at, a] = std::pair(parts[n].at, parts[n].a);
    Real sum = 0;
    for (; n < parts.size() && parts[n].at == at && parts[n].a == a; ++n) sum += displacement(parts[n]);
    float& moved = moved_[at][a];
    const auto now = static_cast<float>(sum);
    const Real change = static_cast<Real>(now) - static_cast<Real>(moved);
    moved = now;
    if (change != 0) visit(a, at, change);
  }
}

template <class Use>
void CutCells::for_each_solid(const std::array<LocalId, 3>& cell, std::size_t at, const Use& use) const {
  const std::span<const PartOfCell> parts = parts_of_cell(at);
  if (parts.empty()) {
    const Real volume = floats(at) ? 1 - open(at) - excess_[nearest(at)].volume * area(at) : cells_[at].solid;
    use(nearest(at), volume, middle_of_solid(cell, at));
  }
  for (const PartOfCell& part : parts) {
    const Excess& excess = excess_[part.solid];
    const Real less = excess.volume == 0 ? 0 : excess.volume * area_of(part.solid, at);
    use(part.solid, part.volume - less, middle_in(cell, part.middle) - excess.middle);
  }
}

template <class Use>
void CutCells::for_each_closed(const std::array<LocalId, 3>& cell, std::size_t at, const Use& use) const {
  for (std::size_t a = 0; a < 3; ++a) {
    for (const bool upper : {false, true}) {
      const Real between = a == 2 ? in_gap(at, upper) : 0;
      const std::size_t face_at = upper ? at + step_[a] : at;
      const Real beside = closed(a, at, upper);
      if (!(beside > 0)) continue;
      std::array<LocalId, 3> of_face = cell;
      of_face[a] += upper ? 1 : 0;
      Vec3 off = Vec3::Zero();  // of the centroid of what is beside the gap
      if (between > 0) off = between / beside * off_other_end(cell, at, upper);
      const std::span<const PartOfFace> parts = parts_of_face(a, face_at);
      for (const PartOfFace& part : parts) use(part.solid, a, upper, part.share * beside, part.middle + off);
      if (!parts.empty() || floats(at)) continue;
      use(nearest(at), a, upper, beside, middle_of_closed(a, of_face, face_at) + off);
    }
  }
}

// Calls visit(k, r, columns) for the ranges that find_ranges_near() has found.
template <class Visit>
void CutCells::for_each_range_near(const Visit& visit) const {
  for_each_part(static_cast<LocalId>(near_.size()), [&](LocalId n) {
    const RangeNear& one = near_[static_cast<std::size_t>(n)];
    visit(one.k, one.r, one.columns);
  });
}

// The same with the solids that matter to each range: visit(k, r, candidates, columns).
template <class Visit>
void CutCells::for_each_row_near(const Visit& visit) {
  for_each_part(static_cast<LocalId>(near_.size()), [&](LocalId n) {
    const RangeNear& one = near_[static_cast<std::size_t>(n)];
    Candidates& own = candidates_.mine();
    own.of_row = one.bodies;
    own.clear = one.clear;
    visit(one.k, one.r, own, one.columns);
  });
}

}  // namespace trevi

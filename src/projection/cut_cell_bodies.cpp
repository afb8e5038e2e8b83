// The part of solids in the cells: the effect of the pressure of a cell on the solid in it, and the volume and centroid
// of a freely moving body, which the samples of a round surface would otherwise not reproduce exactly.
#include <algorithm>
#include <cmath>

#include "parallel/reductions.hpp"
#include "projection/cut_cells.hpp"

namespace trevi {

Real CutCells::area(std::size_t at) const {
  Real sum = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const Real rise = face(a, at + step_[a]) - face(a, at);
    sum += rise * rise;
  }
  return std::sqrt(sum);
}

bool CutCells::is_pushed(std::size_t at) const {
  if (floats(at)) return true;
  for (std::size_t a = 0; a < 3 && any_floats(); ++a)
    if (!parts_of_face(a, at).empty() || !parts_of_face(a, at + step_[a]).empty()) return true;
  return false;
}

namespace {

// For each body: volume, area, volume in cells that contain water, and the moments of the first two about its centre.
constexpr std::size_t sums_of_body = 9;
constexpr Real fine = 1U << 30U;

}  // namespace

// Sums in integers, in cells, so the result does not depend on the order.
std::vector<GlobalId> CutCells::sums_of_bodies(MPI_Comm comm, const ProjectionGrid& grid) const {
  const RigidBodies& bodies = *obstacles_.floating();
  PerThread<std::vector<GlobalId>> sums;
  sums.for_each([&](auto& of) { of.assign(sums_of_body * bodies.count(), 0); });
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const Range cut = cut_columns(k, r);
    for (LocalId c = cut.begin; c < cut.end; ++c) {
      const std::size_t at = grid.index(k, r, c);
      if (open(at) == 1 || (!floats(at) && parts_of_cell(at).empty())) continue;
      for_each_solid({k, r, c}, at, [&](std::size_t solid, Real volume, const Vec3& middle) {
        if (!bodies.holds(solid)) return;
        const std::size_t body = solid - bodies.first();
        const Vec3 arm = (middle - bodies.body(body).midway_position()) / size_.maxCoeff();
        const Real surface = parts_of_cell(at).empty() ? area(at) : area_of(solid, at);
        GlobalId* sum = &sums.mine()[sums_of_body * body];
        for (const Real one : {volume, surface, open(at) > 0 ? volume : 0, volume * arm.x(), volume * arm.y(),
                               volume * arm.z(), surface * arm.x(), surface * arm.y(), surface * arm.z()})
          *sum++ += std::llrint(one * fine);
      });
    }
  });
  return sum_over_threads_and_ranks(comm, sums);
}

void CutCells::measure_excess(MPI_Comm comm, const ProjectionGrid& grid) {
  const RigidBodies& bodies = *obstacles_.floating();
  excess_.assign(obstacles_.count(), {});  // as for_each_solid() uses it for the sums
  const std::vector<GlobalId> all = sums_of_bodies(comm, grid);
  const Real cell = size_.prod(), ceiling = box_.min.z() + grid.columns() * size_[2];
  for (std::size_t k = 0; k < bodies.count(); ++k) {
    const Box place = obstacles_.body(bodies.first() + k).surface_box();
    std::array<Real, sums_of_body> sum{};
    for (std::size_t n = 0; n < sums_of_body; ++n) sum[n] = static_cast<Real>(all[sums_of_body * k + n]) / fine;
    if (!box_.contains(place.min) || !box_.contains(place.max) || place.max.z() > ceiling || !(sum[1] > 0)) continue;
    Excess& excess = excess_[bodies.first() + k];
    excess.volume = (sum[0] - bodies.body(k).volume() / cell) / sum[1];
    const Vec3 moment = Vec3(sum[3], sum[4], sum[5]) - excess.volume * Vec3(sum[6], sum[7], sum[8]);
    const Real cut = sum[2] - excess.volume * sum[1];
    // Not where next to none of the body is in cells with water, as on the faces of cells beside another body.
    if (cut > 0 && moment.norm() < cut / 2) excess.middle = moment * size_.maxCoeff() / cut;
  }
}

// The horizontal distance of the centroid of the closed part of a lower or upper face from that of the other one, m.
Vec3 CutCells::off_other_end(const std::array<LocalId, 3>& cell, std::size_t at, bool upper) const {
  const Vec3 off = middle_of_closed(2, cell, at) - middle_of_closed(2, cell, at + step_[2]);
  return (upper ? -1 : 1) * Vec3(off.x(), off.y(), 0);
}

// The gap in one cell, or in two of a column across the face between them, under the index of the lower one; with
// nothing between if there is none.
CutCells::Gap CutCells::find_gap(const ProjectionGrid& grid, LocalId k, LocalId r, Range cells) const {
  constexpr Real thin = 0.2, min_space = 1e-4;
  const std::size_t low_at = grid.index(k, r, cells.begin), high_at = grid.index(k, r, cells.end - 1);
  for (std::size_t at = low_at; at <= high_at; ++at)
    if (open(at) == 0 || open(at) >= thin) return {};
  const bool at_floor = grid.is_wall({2, false}, k, r, cells.begin);
  const bool at_ceiling = grid.is_wall({2, true}, k, r, cells.end - 1);
  const Real low = at_floor ? 1 : 1 - face(2, low_at), high = at_ceiling ? 1 : 1 - face(2, high_at + 1);
  // Not where a solid goes through and leaves no space between.
  const Real through = low_at == high_at ? 1 - open(low_at) : 1 - face(2, high_at);
  if (std::min(low, high) < through + min_space) return {};
  // Whether a body at this end touches something beyond the other one.
  const auto touches = [&](bool upper) {
    const bool wall = upper ? at_floor : at_ceiling;
    const std::size_t beyond = upper ? low_at - 1 : high_at + 1;
    for (const PartOfFace& part : parts_of_face(2, upper ? high_at + 1 : low_at)) {
      if (!obstacles_.floating()->holds(part.solid)) continue;
      if (wall || (cells_[beyond].open == 0 && nearest(beyond) != part.solid)) return true;
    }
    return false;
  };
  if (!touches(false) && !touches(true)) return {};
  return {low_at, std::min(low, high) - (low_at == high_at ? 0 : through), {true, true}};
}

// In a gap of up to a fifth of a cell the inner cells are dry, and those around them have a part of the pressure only:
// a wide body that rose by a hair fell back.
void CutCells::find_gaps(const ProjectionGrid& grid) {
  PerThread<std::vector<Gap>> found;
  for_each_row(grid.rows_and_ghosts_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    const Range cut = cut_columns(k, r);
    for (LocalId c = cut.begin; c < std::min(cut.end, grid.columns()); ++c) {
      const std::size_t at = grid.index(k, r, c);
      if (const Gap gap = find_gap(grid, k, r, {c, c + 1}); gap.between > 0) {
        found.mine().push_back(gap);
      } else if (const Gap above = c + 1 < grid.columns() ? find_gap(grid, k, r, {c, c + 2}) : Gap{};
                 above.between > 0) {
        found.mine().push_back({at, above.between, {true, false}});
      } else if (const Gap below = c > 0 ? find_gap(grid, k, r, {c - 1, c + 1}) : Gap{}; below.between > 0) {
        found.mine().push_back({at, below.between, {false, true}});
      }
    }
  });
  gaps_.clear();
  found.for_each([&](const auto& some) { gaps_.insert(gaps_.end(), some.begin(), some.end()); });
  std::sort(gaps_.begin(), gaps_.end());
}

Pushes CutCells::pushes(const std::array<LocalId, 3>& cell, std::size_t at, const CellPressure& pressure) const {
  Pushes pushes;
  const Real level = middle(cell[0], cell[1], cell[2]).z();
  for_each_closed(cell, at, [&](std::size_t solid, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    const Real push = (pressure.phi + pressure.fall * (arm.z() - level)) / size_[static_cast<Eigen::Index>(a)] * closed;
    pushes.add(solid, (upper ? push : -push) * Vec3::Unit(axis_[a]), arm);
  });
  const Real beside = 1 - between(at);
  if (pushes.count == 0 || beside == 0) return pushes;
  for_each_solid(cell, at, [&](std::size_t solid, Real volume, const Vec3& place) {
    pushes.add(solid, -pressure.fall * beside * volume * Vec3::UnitZ(), place);
  });
  return pushes;
}

namespace {

// The integral from 0 to `height` of a quadratic function with the values q0 at 0, q1 at 1 and `mean` on average
// between them.
Real integral(Real q0, Real q1, Real mean, Real height) {
  return height * (q0 + height * ((3 * mean - 2 * q0 - q1) + height * (q0 + q1 - 2 * mean)));
}

// The part below a given height of the closed part of a side face, and its first moment. Its width is linear in height,
// as determined by its area and centroid. Where the centroid is less than a third of the height from an end, the width
// grows from zero, or falls to zero, within the face: a body that comes down from above closes only the upper end.
struct Strip {
  Real area, moment;
  Strip(Real closed, Real middle, Real height) {
    const bool upper = middle > 0.5;
    const Real from_end = std::clamp(upper ? 1 - middle : middle, 0.0, 0.5);
    const Real length = std::min(3 * from_end, 1.0);  // over which it has width
    if (!(length > 0)) {
      area = upper && height < 1 ? 0 : closed;
      moment = upper ? area : 0;
      return;
    }
    // From the end where it is widest, in units of length: w(t) = wide (1 − fall t).
    const Real fall = length < 1 ? 1 : 6 * (1 - 2 * from_end) / (4 - 6 * from_end), wide = closed / (1 - fall / 2);
    const auto below = [=](Real t) {
      return std::pair(wide * t * (1 - fall * t / 2), wide * t * t * (0.5 - fall * t / 3));
    };
    if (upper) {
      const auto [rest, rest_moment] = below(std::clamp((1 - height) / length, 0.0, 1.0));
      const auto [all, all_moment] = below(1);
      area = all - rest;
      moment = area - length * (all_moment - rest_moment);
    } else {
      const auto [all, all_moment] = below(std::min(height / length, 1.0));
      area = all;
      moment = length * all_moment;
    }
  }
};

}  // namespace

Pushes CutCells::pushes_below(const std::array<LocalId, 3>& cell, std::size_t at, Real height,
                              const CellPressure& pressure) const {
  Pushes pushes;
  const Vec3 corner = place(Vec3(cell[0], cell[1], cell[2]));
  const Real floor = corner.z(), fall = pressure.fall * size_[2];
  struct Filled {
    std::size_t solid;
    Real volume;
    Vec3 moment;
    // Closed areas of the lower and upper face, and the same times their centroids.
    Real low_area = 0, high_area = 0;
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  };
  std::array<Filled, SolidParts::max_solids> all;
  std::size_t count = 0;
  const Real beside = 1 - between(at);
  for_each_solid(cell, at, [&](std::size_t solid, Real volume, const Vec3& place) {
    all[count++] = {solid, beside * volume, beside * volume * (place - corner)};
  });
  for_each_closed(cell, at, [&](std::size_t solid, std::size_t a, bool upper, Real closed, const Vec3& arm) {
    const Vec3 out = (upper ? 1 : -1) / size_[static_cast<Eigen::Index>(a)] * Vec3::Unit(axis_[a]);
    if (pressure.phi != 0) pushes.add(solid, (a < 2 ? height : 1) * pressure.phi * closed * out, arm);
    if (a == 2) {
      for (std::size_t n = 0; n < count; ++n) {
        if (all[n].solid != solid) continue;
        (upper ? all[n].high : all[n].low) += closed * (arm - corner);
        (upper ? all[n].high_area : all[n].low_area) += closed;
      }
      if (!upper) pushes.add(solid, -fall * height * closed * out, arm);
      return;
    }
    const Strip wet(closed, (arm.z() - floor) / size_[2], height);
    if (!(wet.area > 0)) return;
    const Vec3 middle(arm.x(), arm.y(), floor + size_[2] * wet.moment / wet.area);
    pushes.add(solid, fall * (wet.moment - height * wet.area) * out, middle);
  });
  if (pushes.count == 0) return pushes;
  for (std::size_t n = 0; n < count; ++n) {
    const Filled& one = all[n];
    const Real volume = integral(one.low_area, one.high_area, one.volume, height);
    if (volume == 0) continue;
    Vec3 middle = corner;
    for (const Eigen::Index i : {0, 1}) middle[i] += integral(one.low[i], one.high[i], one.moment[i], height) / volume;
    pushes.add(one.solid, -pressure.fall * volume * Vec3::UnitZ(), middle);
  }
  return pushes;
}

}  // namespace trevi

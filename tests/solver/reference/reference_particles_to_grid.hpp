// What the particles say to the grid, by brute force and over the whole box: every face looks at every particle, every
// cell at all particles of the 27 cells around. Written from what particles_to_grid.hpp, affine.hpp, cell_sums.hpp and
// active_rows.hpp say of themselves and the constants of parameters.hpp; shares no code with them. Without obstacles.
// Cells are counted along x, y and z, whatever the slab axis. Not collective.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "reference_cells.hpp"
#include "reference_fit.hpp"
#include "trevi/scene.hpp"

namespace trevi::test {

class ReferenceParticlesToGrid {
 public:
  /// The particles by what hangs together, over faces, edges and corners of the cells in which they were
  /// predicted.
  std::vector<std::vector<std::size_t>> pieces() const {
    CellArray<std::vector<std::size_t>> left(cells_, {});  // not seen yet
    for (std::size_t i = 0; i < particles_.size(); ++i) left[particles_[i].cell].push_back(i);
    std::vector<std::vector<std::size_t>> all;
    for_each_cell([&](const Cell& start) {
      if (left[start].empty()) return;
      all.emplace_back();
      std::vector<Cell> open{start};
      while (!open.empty()) {
        const Cell c = open.back();
        open.pop_back();
        all.back().insert(all.back().end(), left[c].begin(), left[c].end());
        left[c].clear();
        for (int n = 0; n < 27; ++n) {
          const Cell beside = c + Cell(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
          if (!left[beside].empty()) open.push_back(beside);
        }
      }
    });
    return all;
  }

 protected:
  explicit ReferenceParticlesToGrid(const Scene& scene)
      : min_(scene.domain.min),
        s_(scene.fluid.spacing),
        h_(scene.fluid.kernel_radius),
        dimensions_(scene.fluid.dimensions) {
    const Vec3 extent = scene.domain.max - scene.domain.min;
    for (int a = 0; a < 3; ++a) count_[a] = std::max(1, static_cast<int>(std::floor(extent[a] / h_ * (1 + 1e-12))));
    cells_ = {count_, scene.periodic};
    size_ = extent.cwiseQuotient(count_.cast<Real>());
  }

  struct Particle {
    Vec3 way;      // from x to p, m
    Vec3 surface;  // where it counts as volume, in cells
    Vec3 y, f;     // midway of its path, where its motion is seen; and at its beginning; from the cell's corner
    Cell cell;     // of p
    bool in_flight = false;
  };
  template <class T>
  using Faces = std::array<CellArray<T>, 3>;  // the lower one of a cell in each direction

  static Cell unit(int a) { return Cell::Unit(a); }
  template <class Visit>
  void for_each_cell(Visit&& visit) const {
    for (int x = 0; x < count_.x(); ++x)
      for (int y = 0; y < count_.y(); ++y)
        for (int z = 0; z < count_.z(); ++z) visit(Cell(x, y, z));
  }
  template <class Visit>
  void for_each_face(Visit&& visit) const {
    for (int a = 0; a < 3; ++a)
      for_each_cell([&](const Cell& c) {
        visit(a, c);
        if (c[a] == count_[a] - 1 && !cells_.repeats(a)) visit(a, Cell(c + unit(a)));
      });
  }
  /// visit(cell, offset, weight) for a cell and those around it: a quarter along each axis on which they differ.
  template <class Visit>
  void for_each_around(const Cell& c, Visit&& visit) const {
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const Cell offset(x, y, z), cell = cells_.wrapped(c + offset);
          if ((cell.array() < 0).any() || (cell.array() >= count_.array()).any()) continue;
          visit(cell, Vec3(offset.cast<Real>()), std::pow(0.25, offset.cwiseAbs().sum()));
        }
  }
  bool is_wall(int a, const Cell& c) const { return !cells_.repeats(a) && (c[a] == 0 || c[a] == count_[a]); }

  /// Half a way back from p, but at most half a cell; in cells from the corner of the box.
  Vec3 midway(const Vec3& p, const Vec3& way) const {
    const Vec3 half = (way / 2).cwiseQuotient(size_).cwiseMax(-0.5).cwiseMin(0.5);
    return (p - min_).cwiseQuotient(size_) - half;
  }

  /// All of this of particles that go from x to p, of which gravity makes g_dt2, m.
  void gather(const std::vector<Vec3>& x, const std::vector<Vec3>& p, Real g_dt2) {
    find_particles(x, p, g_dt2);
    find_reach();
    fit_motion();
    const CellArray<Real> zero(cells_, 0);
    mean_ = {zero, zero, zero};
    weight_ = {zero, zero, zero};
    for_each_face([&](int a, const Cell& c) { (*mean_)[static_cast<std::size_t>(a)][c] = mean_at(a, c); });
  }
  void find_particles(const std::vector<Vec3>& x, const std::vector<Vec3>& p, Real g_dt2) {
    particles_.clear();
    for (std::size_t i = 0; i < p.size(); ++i) {
      Particle one;
      one.way = p[i] - x[i];
      const Vec3 place = (p[i] - min_).cwiseQuotient(size_), y = midway(p[i], one.way);
      for (int a = 0; a < 3; ++a) {
        one.cell[a] = std::clamp(static_cast<int>(std::floor(place[a])), 0, count_[a] - 1);
      }
      const Vec3 way = one.way.cwiseQuotient(size_);
      // In the middle of the path as it is without gravity, or where there is none at its beginning, but not far back.
      one.surface = g_dt2 > 0 ? Vec3(y + Vec3(0, 0, g_dt2 / 2 / size_.z()))
                              : Vec3(place - way * std::min(1.0, 0.25 / std::max(way.cwiseAbs().maxCoeff(), 1e-300)));
      one.y = y - one.cell.cast<Real>();
      one.f = one.y + (y - place);
      particles_.push_back(one);
    }
  }

  // Heights, kept in the lowest cell of a column: one above the highest within one column.
  CellArray<int> raised(const CellArray<int>& heights) const {
    CellArray<int> result(cells_, 0);
    for_each_cell([&](const Cell& c) {
      if (c.z() > 0) return;
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y) result[c] = std::max(result[c], heights[c + Cell(x, y, 0)] + 1);
    });
    return result;
  }
  // Water reaches up to the cell above the highest that particles fill to 0.4; what is more than a cell beyond flies.
  void find_reach() {
    const Real least = std::ceil(0.4 * size_.prod() / (s_ * s_ * s_));
    CellArray<int> held(cells_, 0), surface(cells_, 0);
    for (const Particle& i : particles_) ++held[i.cell];
    for_each_cell([&](const Cell& c) {
      if (held[c] >= least) surface[Cell(c.x(), c.y(), 0)] = c.z() + 1;
    });
    reach_.emplace(raised(surface));
    near_.emplace(raised(*reach_));
    members_.emplace(cells_, std::vector<std::size_t>{});
    for (std::size_t i = 0; i < particles_.size(); ++i) {
      particles_[i].in_flight = is_air(particles_[i].cell);
      if (!particles_[i].in_flight) (*members_)[particles_[i].cell].push_back(i);
    }
  }
  /// Whether no water is near.
  bool is_air(const Cell& c) const { return !cells_.repeats(2) && c.z() >= (*near_)[Cell(c.x(), c.y(), 0)]; }

  /// What all particles around a cell have as `u` at y, which is counted from the corners of their own cells. A cell
  /// without particles has nothing to fit.
  std::vector<Sample> samples_around(const Cell& c, const std::vector<Vec3>& y, const std::vector<Vec3>& u) const {
    std::vector<Sample> samples;
    if ((*members_)[c].empty()) return samples;
    for_each_around(c, [&](const Cell& cell, const Vec3& offset, Real weight) {
      for (const std::size_t i : (*members_)[cell]) samples.push_back({weight, y[i] + offset, u[i]});
    });
    return samples;
  }
  ReferenceFit fit_around(const Cell& c, const std::vector<Vec3>& y, const std::vector<Vec3>& u, Real penalty) const {
    return fit_of(samples_around(c, y, u), penalty);
  }
  /// Of a fit that closes its cell, from 0 where half of its strain is compression, or less, to 1 where all of it is.
  Real closing(const ReferenceFit& fit) const {
    const Eigen::Matrix3d slope = fit.b * size_.cwiseInverse().asDiagonal(), strain = (slope + slope.transpose()) / 2;
    return strain.norm() > 0 ? std::clamp(-2 * strain.trace() / strain.norm() - 1, 0.0, 1.0) : 0;
  }
  void fit_motion() {
    std::vector<Vec3> y, u;
    for (const Particle& i : particles_) {
      y.push_back(i.y);
      u.push_back(i.way);
    }
    fit_.emplace(cells_, ReferenceFit{});
    // With less than three eighths of the water of full cells, slopes are penalised more where the cell closes, and
    // where particles lie in a plane or on a line.
    for_each_cell([&](const Cell& c) {
      const std::vector<Sample> samples = samples_around(c, y, u);
      ReferenceFit& fit = (*fit_)[c] = fit_of(samples, 1e-3);
      const Real filled = fit.held / std::pow(1.5, dimensions_) * std::pow(s_, 3) / size_.prod();
      if (samples.empty() || filled >= 0.375) return;
      const Real more = std::max(0.2 * closing(fit), 0.05 * flatness_of(samples, dimensions_));
      fit = fit_of(samples, 1e-3 + (1 - filled / 0.375) * more);
    });
  }

  // Linear weights of what each particle says of the middle of the face, by the slope of its cell; where they come to
  // hardly any, what the fits say.
  Real mean_at(int a, const Cell& face) {
    Real w = 0, wu = 0, n = 0, nu = 0;
    for (const bool below : {false, true}) {
      const Cell cell = cells_.wrapped(below ? Cell(face - unit(a)) : face);
      Vec3 middle = Vec3::Constant(0.5);
      middle[a] = below ? 1 : 0;
      for (const Particle& i : particles_) {
        if (i.in_flight || i.cell != cell) continue;
        const Real share = below ? i.y[a] : 1 - i.y[a];
        w += share;
        wu += share * (i.way + (*fit_)[cell].b * (middle - i.y))[a];
        n += 1;
        nu += (*fit_)[cell].at(middle)[a];
      }
    }
    (*weight_)[static_cast<std::size_t>(a)][face] = w;
    return w >= 0.05 ? wu / w : n > 0 ? nu / n : is_wall(a, face) ? 0 : mean_around(a, face);
  }
  // Of a face with no particle on either side: what the fits of the cells beside say that lie along it, by particles.
  Real mean_around(int a, const Cell& face) const {
    Real n = 0, nu = 0;
    for (const bool below : {false, true}) {
      for (int b = 0; b < 3; ++b) {
        for (const int side : {-1, 1}) {
          const Cell cell = cells_.wrapped(face - (below ? 1 : 0) * unit(a) + side * unit(b));
          if (b == a || (cell.array() < 0).any() || (cell.array() >= count_.array()).any()) continue;
          Vec3 middle = Vec3::Constant(0.5);
          middle[a] = below ? 1 : 0;
          middle[b] -= side;
          const auto held = static_cast<Real>((*members_)[cell].size());
          n += held;
          nu += held * (*fit_)[cell].at(middle)[a];
        }
      }
    }
    return n > 0 ? nu / n : 0;
  }
  Real mean(int a, const Cell& c) const { return (*mean_)[static_cast<std::size_t>(a)][c]; }

  // The density of a particle is that of a box moved along a box: along x and y the first is as many whole spacings
  // wide as a cell has, and both together two cells, along z both are a spacing wide. Of that what is below a level
  // along `a`, in cells from the corner of the particle's own one.
  Real part_below(const Particle& i, int a, Real level) const {
    const Real edge = s_ / size_[a], first = a == 2 ? edge : edge * std::floor(1 / edge + 1e-9);
    const Real second = a == 2 ? edge : 2 - first;
    const bool moved_in = a == 2 && !cells_.repeats(a);
    const Real place = moved_in ? std::clamp(i.surface[a], edge / 2, count_[a] - edge / 2) : i.surface[a];
    const Real middle = cells_.way(a, place, i.cell[a] + 0.5) + 0.5;
    Real sum = 0;
    for (const Real k : {-0.5, 0.5}) {
      for (const Real l : {-0.5, 0.5}) {
        const Real way = std::max(level - middle + k * first + l * second, 0.0);
        sum += 2 * k * l * way * way / (first * second);
      }
    }
    return sum;
  }
  // What is beyond the cells beside its own is twice in these, at the expense of its own: the mean place is kept. What
  // is beyond a wall is before it.
  Real part_in(const Particle& i, int a, const Cell& c) const {
    const int own = i.cell[a], last = count_[a] - 1;
    const auto part = [&](int cells, Real beyond) { return cells > 0 || cells_.repeats(a) ? beyond : 0; };
    const Real below = part(own, part_below(i, a, 0)) + part(own - 1, part_below(i, a, -1));
    const Real above = part(last - own, 1 - part_below(i, a, 1)) + part(last - own - 1, 1 - part_below(i, a, 2));
    const auto beside = [&](int d) { return cells_.wrapped(i.cell + d * unit(a))[a] == c[a]; };
    return (beside(-1) ? below : 0) + (beside(0) ? 1 - below - above : 0) + (beside(1) ? above : 0);
  }
  Real volume_in(const Cell& c) const {
    Real volume = 0;
    for (const Particle& i : particles_) {
      if (!i.in_flight) volume += part_in(i, 0, c) * part_in(i, 1, c) * part_in(i, 2, c) * s_ * s_ * s_ / size_.prod();
    }
    return volume;
  }

  /// What layers of particles tell a cell, of which the first lies at its face and the others behind it, at most.
  Real told_from_one_side() const {
    Real most = 0;
    for (int a = 0; a < 3; ++a) {
      if (dimensions_ == 2 && a == 1) continue;
      const Real edge = s_ / size_[a];
      Real told = 0;
      for (int layer = 0; layer * edge < 1; ++layer) {
        Particle i{};
        i.cell = Cell::Zero();
        i.surface = Vec3::Constant(1 - layer * edge);
        told += edge * (1 - part_below(i, a, 1));
      }
      most = std::max(most, told);
    }
    return most;
  }
  bool holds_any(const Cell& c) const { return !(*members_)[c].empty(); }

  // The number of cells above one another that hold a fifth of what fills them.
  int depth() const {
    const Real least = std::ceil(0.2 * size_.prod() / (s_ * s_ * s_));
    CellArray<int> run(cells_, 0), held(cells_, 0);
    for (const Particle& i : particles_) ++held[i.cell];
    int depth = 0;
    for_each_cell([&](const Cell& c) {
      run[c] = held[c] < least ? 0 : c.z() == 0 ? 1 : run[c - unit(2)] + 1;
      depth = std::max(depth, run[c]);
    });
    return depth;
  }

  Vec3 min_;
  Real s_, h_;
  int dimensions_;
  Cell count_;
  Cells cells_{};
  Vec3 size_;
  std::vector<Particle> particles_;
  std::optional<CellArray<std::vector<std::size_t>>> members_;  // particles that do not fly
  std::optional<CellArray<ReferenceFit>> fit_;
  std::optional<Faces<Real>> mean_, weight_;  // of faces, and of the particles that tell of them
  std::optional<CellArray<int>> reach_, near_;
};

}  // namespace trevi::test

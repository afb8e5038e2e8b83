// The coarse-grid correction by brute force, serially and over the whole box: every cell and every face looks at every
// particle. Written from what coarse_water.hpp, coarse_pressure.hpp and coarse_correction.hpp say of themselves and the
// constants of their sources; shares no code with them. Cells are counted along x, y and z, whatever the slab axis.
// Not collective.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "reference_cells.hpp"
#include "trevi/scene.hpp"

namespace trevi::test {

class ReferenceCoarse {
 public:
  explicit ReferenceCoarse(const Scene& scene)
      : min_(scene.domain.min), s_(scene.fluid.spacing), h_(scene.fluid.kernel_radius) {
    const Vec3 extent = scene.domain.max - scene.domain.min;
    for (int a = 0; a < 3; ++a) count_[a] = std::max(1, static_cast<int>(std::floor(extent[a] / h_ * (1 + 1e-12))));
    cells_ = {count_, scene.periodic};
    size_ = extent.cwiseQuotient(count_.cast<Real>());
    if (scene.gravity) gravity_ = -scene.gravity->z();
  }

  /// Of particles that go from x to p in the time dt.
  std::vector<Vec3> displacements(const std::vector<Vec3>& x, const std::vector<Vec3>& p, Real dt) {
    gather(x, p);
    find_reach();
    find_means();
    find_water();
    const Real time = dt * std::sqrt(gravity_ / h_);
    solve(gravity_ * dt * dt, std::min(1.0, time / 6));
    std::vector<Vec3> result;
    noise_ = 0.2 * time * h_;
    for (const Particle& particle : particles_) result.push_back(displacement(particle, std::min(1.0, time / 3.5)));
    return result;
  }

 private:
  struct Particle {
    Vec3 way;      // from x to p, m
    Vec3 place;    // p, in cells
    Vec3 surface;  // where it counts as volume, in cells
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
  template <class T>
  Faces<T> faces(const T& value) const {
    return {CellArray<T>(cells_, value), CellArray<T>(cells_, value), CellArray<T>(cells_, value)};
  }
  bool is_wall(int a, const Cell& c) const { return !cells_.repeats(a) && (c[a] == 0 || c[a] == count_[a]); }

  void gather(const std::vector<Vec3>& x, const std::vector<Vec3>& p) {
    particles_.clear();
    for (std::size_t i = 0; i < p.size(); ++i) {
      Particle one;
      one.way = p[i] - x[i];
      one.place = (p[i] - min_).cwiseQuotient(size_);
      for (int a = 0; a < 3; ++a) {
        one.cell[a] = std::clamp(static_cast<int>(std::floor(one.place[a])), 0, count_[a] - 1);
        one.surface[a] = one.place[a] - std::clamp(one.way[a] / size_[a], -0.25, 0.25);
      }
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
    const CellArray<int> near = raised(*reach_);
    for (Particle& i : particles_) i.in_flight = i.cell.z() >= near[Cell(i.cell.x(), i.cell.y(), 0)];
  }

  // Linear weights, and along their regression line from the mean place to the face.
  Real mean_at(int a, const Cell& face) const {
    Real w = 0, wx = 0, wxx = 0, wu = 0, wxu = 0;
    for (const Particle& i : particles_) {
      if (i.in_flight || (i.cell != face && i.cell != cells_.wrapped(face - unit(a)))) continue;
      const Real x = cells_.way(a, i.place[a], face[a]), share = 1 - std::abs(x), u = i.way[a];
      w += share;
      wx += share * x;
      wxx += share * x * x;
      wu += share * u;
      wxu += share * x * u;
    }
    if (w < 1e-9) return 0;
    const Real x = wx / w, variance = wxx / w - x * x, covariance = wxu / w - x * wu / w;
    return wu / w - x * covariance / (variance + 0.1);
  }
  void find_means() {
    mean_ = faces(0.0);
    for_each_face([&](int a, const Cell& c) { (*mean_)[static_cast<std::size_t>(a)][c] = mean_at(a, c); });
  }
  Real mean(int a, const Cell& c) const { return (*mean_)[static_cast<std::size_t>(a)][c]; }

  // ---- the water and its surface ---------------------------------------------------------------------------------

  Real volume_in(const Cell& c) const {
    Real volume = 0;
    for (const Particle& i : particles_) {
      if (i.in_flight) continue;
      Real part = 1;
      for (int a = 0; a < 3; ++a) {
        const Real half = s_ / (2 * size_[a]);
        const Real inside = cells_.repeats(a) ? i.surface[a] : std::clamp(i.surface[a], half, count_[a] - half);
        const Real middle = cells_.way(a, inside, c[a] + 0.5) + 0.5;  // in cells from the corner of the cell
        part *= std::max(0.0, std::min(middle + half, 1.0) - std::max(middle - half, 0.0));
      }
      volume += part;
    }
    return volume;
  }

  void find_water() {
    fill_.emplace(cells_, 0);
    wet_.emplace(cells_, 0);
    height_.emplace(cells_, 1);
    for_each_cell([&](const Cell& c) { (*fill_)[c] = volume_in(c); });
    for_each_cell([&](const Cell& c) {
      const bool submerged = c.z() + 1 < count_.z() && (*fill_)[c] >= 0.3 && (*fill_)[c + unit(2)] >= 0.3;
      (*wet_)[c] = c.z() < (*reach_)[Cell(c.x(), c.y(), 0)] &&
                   ((*fill_)[c] >= 0.585 || submerged || (c.z() == 0 && (*fill_)[c] >= 0.2));
    });
    // Water under the ceiling has no surface.
    for_each_cell([&](const Cell& c) {
      if (c.z() + 1 == count_.z()) (*wet_)[c + unit(2)] = (*wet_)[c];
    });
    for_each_cell([&](const Cell& c) {
      if (is_top(c)) (*height_)[c] = std::max(height_of_top(c), 0.2);
    });
    find_depth();
  }
  bool wet(const Cell& c) const { return (*wet_)[c] != 0; }
  bool is_top(const Cell& c) const { return wet(c) && !wet(c + unit(2)); }
  // A column that stands on the floor has all of its volume below its surface.
  Real height_of_top(const Cell& c) const {
    const Real own = (*fill_)[c] + (*fill_)[c + unit(2)];
    Real excess = 0;
    for (Cell below = c - unit(2); below.z() >= 0; below -= unit(2)) {
      if (!wet(below)) return own;
      excess += (*fill_)[below] - 1;
    }
    return own + std::clamp(excess, -0.25, 0.25);
  }
  Real above_middle(const Cell& c) const { return std::max((*height_)[c] - 0.5, 0.05); }

  // Cells above one another that hold a fifth of what fills them; fills are not known yet when the solver counts them.
  void find_depth() {
    const Real least = std::ceil(0.2 * size_.prod() / (s_ * s_ * s_));
    CellArray<int> run(cells_, 0), held(cells_, 0);
    for (const Particle& i : particles_) ++held[i.cell];
    depth_ = 0;
    for_each_cell([&](const Cell& c) {
      run[c] = held[c] >= least ? run[c - unit(2)] + 1 : 0;
      depth_ = std::max(depth_, run[c]);
    });
  }

  // ---- the pressure -------------------------------------------------------------------------------------------

  // Area under water over the distance between what is on either side; 0 where nothing passes.
  Real weight(int a, const Cell& c) const {
    const Cell below = c - unit(a);
    if (is_wall(a, c) || (!wet(below) && !wet(c))) return 0;
    if (a == 2) return is_top(below) ? 1 / above_middle(below) : 1;
    if (wet(below) && wet(c)) return ((*height_)[below] + (*height_)[c]) / 2;
    return (*height_)[wet(c) ? c : below];
  }
  Real area(int a, const Cell& c) const {
    const Real w = weight(a, c);
    return a == 2 && w > 0 ? 1 : w;
  }

  Real source(const Cell& c, Real return_share) const {
    Real divergence = 0;
    for (int a = 0; a < 3; ++a) {
      const Cell up = c + unit(a);
      divergence += (area(a, up) * mean(a, up) - area(a, c) * mean(a, c)) / size_[a];
    }
    const Real covered = is_top(c) ? std::min(1.0, 2 * (*fill_)[c + unit(2)]) : 1;
    return return_share * covered * ((*fill_)[c] - 1) - divergence;
  }

  /// Of a column that stands on the floor and has a surface: what water at rest would have.
  void start_at_rest(Real fall) {
    for_each_cell([&](const Cell& c) {
      Cell top = c;
      for (Cell below = c; below.z() >= 0; below -= unit(2))
        if (!wet(below)) return;
      while (wet(top) && !is_top(top) && top.z() < count_.z()) top += unit(2);
      if (top.z() < count_.z()) (*phi_)[c] = -fall * size_.z() * (above_middle(top) + top.z() - c.z());
    });
  }

  // ---- multigrid, in matrices ---------------------------------------------------------------------------------

  struct Level {
    Eigen::MatrixXd matrix;
    std::vector<Cell> cells;  // that the rows stand for
    int width = 1;            // of a column, in cells
  };

  Level finest() const {
    Level level;
    CellArray<int> row(cells_, -1);
    for_each_cell([&](const Cell& c) {
      if (!wet(c)) return;
      row[c] = static_cast<int>(level.cells.size());
      level.cells.push_back(c);
    });
    const auto rows = static_cast<Eigen::Index>(level.cells.size());
    level.matrix = Eigen::MatrixXd::Zero(rows, rows);
    for_each_face([&](int a, const Cell& c) {
      const int below = row[c - unit(a)], above = row[c];
      const Real link = weight(a, c) / (size_[a] * size_[a]);
      if (below >= 0) level.matrix(below, below) += link;
      if (above >= 0) level.matrix(above, above) += link;
      if (below >= 0 && above >= 0) level.matrix(below, above) = level.matrix(above, below) = -link;
    });
    return level;
  }

  static bool same_column(const Cell& a, const Cell& b) { return a.head<2>() == b.head<2>(); }

  // Of a link to the column below along a: a half, but where a periodic axis has a narrow column at its end what the
  // way between the middles becomes longer by.
  Real share(const Level& fine, int a, const Cell& c) const {
    if (!cells_.repeats(a)) return 0.5;
    const auto way = [&](int width, int k) {
      const int columns = (count_[a] + width - 1) / width, before = (k + columns - 1) % columns;
      return Real(std::min(width, count_[a] - k * width) + std::min(width, count_[a] - before * width));
    };
    return way(fine.width, c[a]) / way(2 * fine.width, c[a] / 2);
  }

  // Two by two columns become one. Links between columns have their share; what holds phi at 0 stays.
  Level coarser(const Level& fine, Eigen::MatrixXd& join) const {
    Level coarse{{}, {}, 2 * fine.width};
    const auto rows = static_cast<Eigen::Index>(fine.cells.size());
    std::vector<Eigen::Index> parents;
    for (const Cell& c : fine.cells) {
      const Cell parent(c.x() / 2, c.y() / 2, c.z());
      const auto found = std::find(coarse.cells.begin(), coarse.cells.end(), parent);
      parents.push_back(found - coarse.cells.begin());
      if (found == coarse.cells.end()) coarse.cells.push_back(parent);
    }
    const auto size = static_cast<Eigen::Index>(coarse.cells.size());
    join = Eigen::MatrixXd::Zero(size, rows);
    coarse.matrix = Eigen::MatrixXd::Zero(size, size);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Eigen::Index to = parents[static_cast<std::size_t>(i)];
      join(to, i) = 1;
      for (Eigen::Index j = 0; j < rows; ++j) {
        const Eigen::Index from = parents[static_cast<std::size_t>(j)];
        const Cell &here = fine.cells[static_cast<std::size_t>(i)], &there = fine.cells[static_cast<std::size_t>(j)];
        const int a = here.x() != there.x() ? 0 : 1, way = here[a] - there[a];
        Real part = 1;
        if (fine.matrix(i, j) != 0 &&
            !same_column(coarse.cells[static_cast<std::size_t>(to)], coarse.cells[static_cast<std::size_t>(from)]))
          part = share(fine, a, way == 1 || way < -1 ? here : there);
        coarse.matrix(to, from) += part * fine.matrix(i, j);
        coarse.matrix(to, to) += (1 - part) * fine.matrix(i, j);
      }
    }
    return coarse;
  }

  /// phi after `times` sweeps that go a share of the way to what each column would have beside the others as they are.
  static void sweep(const Level& level, Eigen::VectorXd& phi, const Eigen::VectorXd& right, int times, Real share) {
    Eigen::MatrixXd columns = level.matrix;
    for (Eigen::Index i = 0; i < columns.rows(); ++i)
      for (Eigen::Index j = 0; j < columns.rows(); ++j)
        if (!same_column(level.cells[static_cast<std::size_t>(i)], level.cells[static_cast<std::size_t>(j)]))
          columns(i, j) = 0;
    const Eigen::FullPivLU<Eigen::MatrixXd> inverse(columns);
    for (int k = 0; k < times; ++k) phi += share * inverse.solve(right - level.matrix * phi);
  }

  void improve(const Level& level, Eigen::VectorXd& phi, const Eigen::VectorXd& right, int levels) const {
    if (level.cells.empty()) return;
    const int width = 1 << (levels_ - levels);
    if (levels == 1) {
      const bool single = width >= count_.x() && width >= count_.y();
      return sweep(level, phi, right, single ? 1 : 4, single ? 1 : 0.8);
    }
    sweep(level, phi, right, 2, 0.8);
    Eigen::MatrixXd join;
    const Level coarse = coarser(level, join);
    Eigen::VectorXd correction = Eigen::VectorXd::Zero(coarse.matrix.rows());
    improve(coarse, correction, join * (right - level.matrix * phi), levels - 1);
    phi += join.transpose() * correction;
    sweep(level, phi, right, 2, 0.8);
  }

  void solve(Real fall, Real return_share) {
    phi_.emplace(cells_, 0);
    start_at_rest(fall);
    const Level level = finest();
    Eigen::VectorXd phi(level.matrix.rows()), right(level.matrix.rows());
    for (Eigen::Index i = 0; i < phi.size(); ++i) {
      phi[i] = (*phi_)[level.cells[static_cast<std::size_t>(i)]];
      right[i] = -source(level.cells[static_cast<std::size_t>(i)], return_share);
    }
    const int widest = std::max(count_.x(), count_.y());
    levels_ = 1;
    while (1 << (levels_ - 1) < widest && 1 << (levels_ - 1) <= std::max(depth_, 1)) ++levels_;
    for (int cycle = 0; cycle < 3; ++cycle) improve(level, phi, right, levels_);
    for (Eigen::Index i = 0; i < phi.size(); ++i)
      (*phi_)[level.cells[static_cast<std::size_t>(i)]] = std::min(phi[i], 0.0);
  }

  // ---- what the particles take from it ------------------------------------------------------------------------

  /// Through a face, m; nothing where neither side is wet.
  std::optional<Real> through(int a, const Cell& face) const {
    const Cell below = face - unit(a);
    if (is_wall(a, face)) {
      const Cell inner = face[a] == 0 ? face : below;
      return wet(inner) ? std::optional(-mean(a, face)) : std::nullopt;
    }
    if (!wet(face) && !wet(below)) return std::nullopt;
    const Real u = ((*phi_)[face] - (*phi_)[below]) / size_[a];
    return a == 2 && is_top(below) ? u / above_middle(below) : u;
  }

  Vec3 displacement(const Particle& i, Real noise_share) const {
    if (i.in_flight) return Vec3::Zero();
    const Cell& c = i.cell;
    const bool follows = !wet(c) && c.z() > 0 && wet(c - unit(2));  // what little is above a top cell
    Vec3 u, off;
    for (int a = 0; a < 3; ++a) {
      const Cell cell = follows && a < 2 ? Cell(c - unit(2)) : c;
      const std::optional<Real> low = through(a, cell), high = through(a, cell + unit(a));
      const Real from = low.value_or(high.value_or(0)), to = high.value_or(from), f = i.place[a] - c[a];
      u[a] = from + f * (to - from);
      const Real lower = mean(a, cell), upper = follows && a == 2 ? lower : mean(a, cell + unit(a));
      off[a] = lower + f * (upper - lower) - i.way[a];
    }
    if (wet(c) || follows) u += noise_share / (1 + off.squaredNorm() / std::pow(noise_, 2)) * off;
    if (!follows && !is_top(c)) return u;
    const Cell top = follows ? Cell(c - unit(2)) : c;
    const Real below = (top.z() + (*height_)[top] - i.surface.z()) * size_.z() / s_;
    return u * std::clamp((below + 0.25) / 2 + 1, 0.0, 1.0);
  }

  Vec3 min_;
  Real s_, h_, gravity_ = 0, noise_ = 0;
  Cell count_;
  Cells cells_{};
  Vec3 size_;
  std::vector<Particle> particles_;
  std::optional<Faces<Real>> mean_;
  std::optional<CellArray<Real>> fill_, height_, phi_;
  std::optional<CellArray<char>> wet_;
  std::optional<CellArray<int>> reach_;
  int depth_ = 0, levels_ = 1;
};

}  // namespace trevi::test

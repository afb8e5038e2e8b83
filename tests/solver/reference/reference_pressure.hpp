// The water, its surface and the pressure of the projection by brute force, serially and over the whole box. Written
// from what the headers of src/projection say of themselves and the constants of parameters.hpp; shares no code with
// them. Without obstacles. Not collective.
#pragma once

#include "reference_multigrid.hpp"
#include "reference_particles_to_grid.hpp"

namespace trevi::test {

class ReferencePressure : public ReferenceParticlesToGrid {
 protected:
  explicit ReferencePressure(const Scene& scene) : ReferenceParticlesToGrid(scene) {
    if (scene.gravity) gravity_ = -scene.gravity->z();
  }

  bool upright() const { return gravity_ > 0; }

  // ---- the water and its surface ----------------------------------------------------------------------------------

  void find_water() {
    fill_.emplace(cells_, 0);
    wet_.emplace(cells_, 0);
    height_.emplace(cells_, 1);
    for_each_cell([&](const Cell& c) { (*fill_)[c] = volume_in(c); });
    const Real told = told_from_one_side();
    for_each_cell([&](const Cell& c) {
      const bool submerged = c.z() + 1 < count_.z() && (*fill_)[c] >= 0.3 && (*fill_)[c + unit(2)] >= 0.3;
      const bool on_floor = c.z() == 0 && (*fill_)[c] >= 0.2;
      // Without a particle, and told no more than from one side, it is air.
      const bool is_water = holds_any(c) || (*fill_)[c] > 1.001 * told;
      (*wet_)[c] = is_water && (cells_.repeats(2) || c.z() < (*reach_)[Cell(c.x(), c.y(), 0)]) &&
                   ((*fill_)[c] >= 0.585 || (upright() && (submerged || on_floor)));
    });
    // Water under the ceiling has no surface.
    for_each_cell([&](const Cell& c) {
      if (c.z() + 1 == count_.z() && !cells_.repeats(2)) (*wet_)[c + unit(2)] = (*wet_)[c];
    });
    for_each_cell([&](const Cell& c) {
      if (!is_top(c)) return;
      const Real midway = height_of_top(c);
      (*height_)[c] = std::max(midway - half_rise(c, midway), 0.2);
    });
    closed_ = true;
    for_each_face([&](int a, const Cell& c) {
      if (!is_wall(a, c) && wet(c) != wet(c - unit(a))) closed_ = false;
    });
  }
  bool wet(const Cell& c) const { return (*wet_)[c] != 0; }
  bool is_top(const Cell& c) const { return upright() && wet(c) && !wet(c + unit(2)); }
  // A column that stands on the floor has all of its volume below its surface.
  Real height_of_top(const Cell& c) const {
    const Real own = (*fill_)[c] + (*fill_)[c + unit(2)];
    Real excess = 0;
    for (Cell below = c - unit(2); below.z() >= 0; below -= unit(2)) {
      if (!wet(below)) return own;
      const Real off = (*fill_)[below] - 1;  // counts in full up to 0.1, not at all from 0.2 on
      excess += off * std::clamp(2 - std::abs(off) / 0.1, 0.0, 1.0);
    }
    return own + std::clamp(excess, -0.25, 0.25);
  }
  // Of the surface at a height in cells, in the first half of the paths as they are without gravity; in cells.
  Real half_rise(const Cell& c, Real height) const {
    if ((*fit_)[c].weight == 0) return 0;
    return std::clamp(((*fit_)[c].at(Vec3(0.5, 0.5, height)).z() + g_dt2_) / 2 / size_.z(), -0.25, 0.25);
  }
  Real above_middle(const Cell& c) const { return std::max((*height_)[c] - 0.5, 0.05); }

  // Water at rest has the mass of its level, whatever its top cell holds; thin water has that of its fill, but at
  // walls.
  Real mass(const Cell& c) const {
    for (int a = 0; a < 3; ++a)
      if ((is_wall(a, c) || is_wall(a, c + unit(a))) && !(a == 1 && dimensions_ == 2)) return 1;
    Real fill = (*fill_)[c];
    if (is_top(c)) {
      fill += std::max((*fill_)[c + unit(2)], 0.0);
      if (wet(c - unit(2))) fill = std::max(fill, (*fill_)[c - unit(2)]);
    }
    if (fill >= 0.8) return 1;
    return fill <= 0.6 ? fill : fill + (fill - 0.6) / 0.2 * (1 - fill);
  }
  // What divides the difference of phi over face (a, c): the mass beside it times the distance, in cells, of the points
  // at which phi is given; the surface is one where a cell is dry. At a side the water's own weight is both.
  Real resistance(int a, const Cell& c) const {
    const Cell below = c - unit(a), water = wet(c) ? c : below, beside = (wet(c) ? below : c) - unit(2);
    if (wet(below) == wet(c)) return (mass(c) + mass(below)) / 2;
    if (!upright() || a == 2) return mass(water) * (is_top(below) && a == 2 ? above_middle(below) : 1);
    if (!is_top(beside)) return weight_at_side(a, c, water);  // the surface does not step down by one cell
    const Real in = is_top(water) ? above_middle(water) : 1 + above_middle(water + unit(2));
    return mass(water) * in / std::max(in + 1.5 - (*height_)[beside], 1e-6);
  }
  Real weight_at_side(int a, const Cell& c, const Cell& water) const {
    Real sum = 0;
    for (const Particle& i : particles_)
      if (!i.in_flight && i.cell == cells_.wrapped(water)) sum += wet(c) ? 1 - i.y[a] : i.y[a];
    return std::clamp(sum * std::pow(s_, 3) / size_.prod(), 0.3, 1.0);
  }

  // ---- the pressure -----------------------------------------------------------------------------------------------

  bool is_open(int a, const Cell& c) const { return !is_wall(a, c) && (wet(c) || wet(c - unit(a))); }
  Real weight(int a, const Cell& c) const { return is_open(a, c) ? 1 / resistance(a, c) : 0; }

  Real divergence(const Cell& c) const {
    Real sum = 0;
    for (int a = 0; a < 3; ++a) {
      const Cell up = c + unit(a);
      sum += ((is_open(a, up) ? mean(a, up) : 0) - (is_open(a, c) ? mean(a, c) : 0)) / size_[a];
    }
    return sum;
  }

  // A cell beside air that is not full takes in water without resisting it, unless the surface is in it. What the
  // weight would bring in a step is not taken in.
  Real without_filling(const Cell& c, Real flow) const {
    const Real slow = -1.05 * g_dt2_ / size_.z(), room = std::max(0.9 - (*fill_)[c], 0.0);
    return closed_ || !may_swell(c) || is_top(c) || flow >= slow ? flow : std::min(flow + room, slow);
  }

  // Nothing pulls where air is beside a cell or below it, or, without gravity, above it.
  bool may_swell(const Cell& c) const {
    for (int a = 0; a < 3; ++a) {
      const Cell down = c - unit(a), up = c + unit(a);
      if (!is_wall(a, c) && !wet(down)) return true;
      if ((a < 2 || !upright()) && !is_wall(a, up) && !wet(up)) return true;
    }
    return false;
  }
  Real returned(const Cell& c, Real return_fraction) const {
    Real less = (*fill_)[c] - 1;
    if (closed_ || (less < 0 && may_swell(c))) return 0;
    Real height = 1;
    if (is_top(c)) {  // of the water above it, whose last layer reaches down into it
      const Real above = (*fill_)[c + unit(2)], edge = s_ / size_.z();
      height = above < edge / 2 ? edge * (std::sqrt(2 * above / edge) - 0.5) : above;
      if (less < 0) less = std::min(less + above - height, 0.0);
    }
    if (upright()) return return_fraction * std::clamp(2 * height, 0.0, 1.0) * less;
    Vec3 way = Vec3::Zero();  // of the water of the cell, in cells
    const std::vector<std::size_t>& here = (*members_)[c];
    for (const std::size_t i : here) way += particles_[i].way.cwiseQuotient(size_) / static_cast<Real>(here.size());
    return std::min(way.norm() / 6, 1.0) * less;
  }

  /// Of a column that stands on the floor: what water at rest would have below its surface, or below the ceiling where
  /// there is no surface at all.
  void set_hydrostatic_guess(Real g_dt2) {
    for_each_cell([&](const Cell& c) {
      Cell top = c;
      for (Cell below = c; below.z() >= 0; below -= unit(2))
        if (!wet(below)) return;
      while (top.z() < count_.z() && !is_top(top)) top += unit(2);
      if (top.z() < count_.z()) {
        (*phi_)[c] = -g_dt2 * size_.z() * (above_middle(top) + top.z() - c.z());
      } else if (closed_) {
        (*phi_)[c] = -g_dt2 * size_.z() * (count_.z() - 0.5 - c.z());
      }
    });
  }

  ReferenceMultigrid::Level equation() const {
    ReferenceMultigrid::Level level;
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

  void solve(Real g_dt2, Real return_fraction) {
    phi_.emplace(cells_, 0);
    if (upright()) set_hydrostatic_guess(g_dt2);
    const ReferenceMultigrid::Level level = equation();
    Eigen::VectorXd phi(level.matrix.rows()), right(level.matrix.rows());
    for (Eigen::Index i = 0; i < phi.size(); ++i) {
      const Cell& c = level.cells[static_cast<std::size_t>(i)];
      phi[i] = (*phi_)[c];
      right[i] = without_filling(c, divergence(c)) - returned(c, return_fraction);
    }
    ReferenceMultigrid(cells_, depth(), closed_).solve(level, phi, right, closed_ ? 6 : 3);
    const Real origin = closed_ && phi.size() > 0 ? phi.maxCoeff() : 0;
    for (Eigen::Index i = 0; i < phi.size(); ++i)
      (*phi_)[level.cells[static_cast<std::size_t>(i)]] = std::min(phi[i] - origin, 0.0);
  }

  Real gravity_ = 0;     // m/s²
  Real g_dt2_ = 0;       // m, of the step
  bool closed_ = false;  // no water has a surface
  std::optional<CellArray<Real>> fill_, height_, phi_;
  std::optional<CellArray<char>> wet_;
};

}  // namespace trevi::test

// The projection by brute force, serially and over the whole box. Written from what the headers of src/projection say
// of themselves and the constants of parameters.hpp; shares no code with them. Without obstacles. Not collective.
#pragma once

#include "reference_multigrid.hpp"
#include "reference_particles_to_grid.hpp"

namespace trevi::test {

class ReferenceProjection : ReferenceParticlesToGrid {
 public:
  using ReferenceParticlesToGrid::pieces;
  explicit ReferenceProjection(const Scene& scene) : ReferenceParticlesToGrid(scene) {
    if (scene.gravity) gravity_ = -scene.gravity->z();
  }

  struct Displacement {
    Vec3 u;    // m
    Real act;  // how far the grid acts, from 0 to 1
  };
  /// Of particles that go from x to p in the time dt.
  std::vector<Displacement> displacements(const std::vector<Vec3>& x, const std::vector<Vec3>& p, Real dt) {
    gather(x, p);
    find_water();
    const Real time = dt * std::sqrt(gravity_ / h_);
    g_dt2_ = gravity_ * dt * dt;
    solve(g_dt2_, std::min(1.0, time / 6));
    const std::vector<Vec3> damping = dampings(time);
    result_.clear();
    for (std::size_t i = 0; i < particles_.size(); ++i) result_.push_back(displacement(particles_[i], damping[i]));
    return result_;
  }

  /// Of the same particles, shifted from x to p since: the smooth part of each shift, as far as the grid acts. The
  /// particles still count to the cells in which they were predicted. `compression`: rho/rho0 − 1.
  std::vector<Vec3> smooth_shifts(const std::vector<Vec3>& x, const std::vector<Vec3>& p,
                                  const std::vector<Real>& compression) const {
    std::vector<Vec3> y, u;
    for (std::size_t i = 0; i < p.size(); ++i) {
      u.push_back(p[i] - x[i]);
      y.push_back(midway(p[i], u[i]) - particles_[i].cell.cast<Real>());
    }
    CellArray<ReferenceFit> fits(cells_, {});
    CellArray<Real> kept(cells_, 0);
    for_each_cell([&](const Cell& c) {
      Real n = 0, sum = 0;
      for_each_around(c, [&](const Cell& cell, const Vec3&, Real weight) {
        for (const std::size_t i : (*members_)[cell]) {
          n += weight;
          sum += weight * compression[i];
        }
      });
      kept[c] = 1 - std::clamp(((n > 0 ? sum / n : 0) - 0.004) / (0.008 - 0.004), 0.0, 1.0);
      if (wet(c) || wet(c - unit(2))) fits[c] = fit_around(c, y, u, 1e-3);
    });
    std::vector<Vec3> smooth;
    for (std::size_t i = 0; i < p.size(); ++i) {
      Vec3 sum = Vec3::Zero();
      Real all = 0;
      for_each_around(particles_[i].cell, [&](const Cell& cell, const Vec3& offset, Real weight) {
        all += weight * fits[cell].weight;
        sum += weight * fits[cell].weight * fits[cell].at(y[i] - offset);
      });
      const Real squeezed = std::clamp((compression[i] - 0.02) / (0.04 - 0.02), 0.0, 1.0);  // keeps its own shift
      const Real part = result_[i].act * (1 - squeezed) * kept[particles_[i].cell];
      smooth.push_back(all > 0 ? Vec3(part / all * sum) : Vec3::Zero());
    }
    return smooth;
  }

  /// What the water's motion differs by along shifts from `start`, m: of each less the mean of its cell, as far as the
  /// grid acts, less along the noise of the cell, what the motion has beside the affine one, and less half along that.
  std::vector<Vec3> carried(const std::vector<Vec3>& start, const std::vector<Vec3>& shifts,
                            const std::vector<Vec3>& motion) const {
    std::vector<Vec3> result(shifts.size(), Vec3::Zero());
    for_each_cell([&](const Cell& c) {
      Vec3 at = Vec3::Zero(), shift = Vec3::Zero(), mean = Vec3::Zero();
      Real all = 0;
      for (const std::size_t i : (*members_)[c]) {
        at += result_[i].act * start[i];
        shift += result_[i].act * shifts[i];
        mean += result_[i].act * motion[i];
        all += result_[i].act;
      }
      if (all == 0) return;
      const auto along = [&](const Vec3& y) -> Vec3 { return (*fit_)[c].b * y.cwiseQuotient(size_); };
      const auto affine = [&](std::size_t i) -> Vec3 { return along(start[i] - at / all); };
      const auto noise = [&](std::size_t i) -> Vec3 { return motion[i] - mean / all - affine(i); };
      Real of_noise = 0, of_affine = 0, noise2 = 0, affine2 = 0;
      for (const std::size_t i : (*members_)[c]) {
        result[i] = along(shifts[i] - shift / all);
        of_noise += result_[i].act * noise(i).dot(result[i]);
        of_affine += result_[i].act * affine(i).dot(result[i]);
        noise2 += result_[i].act * noise(i).squaredNorm();
        affine2 += result_[i].act * affine(i).squaredNorm();
      }
      const Real g = noise2 + affine2 > 0 ? of_noise / (noise2 + affine2) : 0;
      const Real q = affine2 > 0 ? of_affine / affine2 / 2 : 0;
      for (const std::size_t i : (*members_)[c])
        result[i] = result_[i].act * (result[i] - g * noise(i) - q * affine(i));
    });
    return result;
  }

 private:
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
      if (is_top(c)) (*height_)[c] = std::max(height_of_top(c), 0.2);
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
      right[i] = divergence(c) - returned(c, return_fraction);
    }
    ReferenceMultigrid(cells_, depth(), closed_).solve(level, phi, right, closed_ ? 6 : 3);
    const Real origin = closed_ && phi.size() > 0 ? phi.maxCoeff() : 0;
    for (Eigen::Index i = 0; i < phi.size(); ++i)
      (*phi_)[level.cells[static_cast<std::size_t>(i)]] = std::min(phi[i] - origin, 0.0);
  }

  // ---- what the particles take from it ----------------------------------------------------------------------------

  /// Whether what little is in the cell follows the top cell below it.
  bool follows(const Cell& c) const { return upright() && !wet(c) && c.z() > 0 && wet(c - unit(2)); }

  // With F u of a particle the sum over the cells around it of what their fits differ by from its own motion, F is
  // applied twice, and the second time each cell has its own rate.
  std::vector<Vec3> dampings(Real time) const {
    std::vector<Vec3> y, noise, damping;
    if (!upright()) return std::vector<Vec3>(particles_.size(), Vec3::Zero());
    for (const Particle& i : particles_) {
      y.push_back(i.y);
      noise.push_back(filtered(i, i.way, *fit_));
    }
    CellArray<ReferenceFit> second(cells_, {});
    for_each_cell([&](const Cell& c) {
      if (!wet(c) && !follows(c)) return;
      second[c] = fit_around(c, y, noise, (*fit_)[c].penalty);
      second[c].weight *= std::min(time / 12, 1.0) / (1 + (*fit_)[c].rest2 / std::pow(0.2 * time * h_, 2));
    });
    for (std::size_t i = 0; i < particles_.size(); ++i) damping.push_back(-filtered(particles_[i], noise[i], second));
    return damping;
  }
  Vec3 filtered(const Particle& i, const Vec3& own, const CellArray<ReferenceFit>& fits) const {
    Vec3 sum = Vec3::Zero();
    for_each_around(i.cell, [&](const Cell& cell, const Vec3& offset, Real weight) {
      sum += weight / std::pow(1.5, dimensions_) * fits[cell].weight * (fits[cell].at(i.y - offset) - own);
    });
    return sum;
  }

  /// Back from a wall, m: by the linear mean at its face, but no more than the cell's own particles move towards it in
  /// the mean, and nothing against that.
  Real at_wall(int a, const Cell& face, const Cell& inner) const {
    Real sum = 0, count = 0;
    for (const Particle& i : particles_) {
      if (i.in_flight || (i.cell.array() != inner.array()).any()) continue;
      sum += i.way[a];
      ++count;
    }
    const Real there = mean(a, face);
    if (count == 0) return -there;
    if (sum * there <= 0) return 0;
    return -std::copysign(std::min(std::abs(sum / count), std::abs(there)), there);
  }

  /// Through a face of `inner`, m; nothing where neither side is wet.
  std::optional<Real> through(int a, const Cell& face, const Cell& inner) const {
    const Cell below = face - unit(a);
    if (is_wall(a, face)) return wet(inner) ? std::optional(at_wall(a, face, inner)) : std::nullopt;
    if (!wet(face) && !wet(below)) return std::nullopt;
    return ((*phi_)[face] - (*phi_)[below]) / size_[a] / resistance(a, face);
  }

  bool in_full_water(int a, const Cell& face) const {
    const auto is_full = [&](const Cell& c) { return c.z() < count_.z() && wet(c) && !is_top(c) && mass(c) == 1; };
    return is_full(face) && is_full(face - unit(a));
  }
  /// What particles share of the impulse of a face in full water beyond those around it in its plane.
  Real beyond(int a, const Cell& face) const {
    if (!in_full_water(a, cells_.wrapped(face))) return 0;
    const auto rise = [&](const Cell& of) { return ((*phi_)[of] - (*phi_)[of - unit(a)]) / size_[a]; };
    const Cell b = unit((a + 1) % 3), c = unit((a + 2) % 3);
    Real rough = 0, count = 0;
    for (int i = -1; i <= 1; ++i) {
      for (int j = -1; j <= 1; ++j) {
        const Cell off = i * b + j * c, other = cells_.wrapped(face + off);
        if (off.isZero() || (dimensions_ == 2 && off.y() != 0)) continue;
        const Real w = (i == 0 ? 2 : 1) * (j == 0 ? 2 : 1);
        if (in_full_water(a, other)) rough += w * (rise(face) - rise(other));
        count += w;
      }
    }
    const Real full = size_.prod() / std::pow(s_, 3), w = (*weight_)[static_cast<std::size_t>(a)][face];
    return ((w > full / 2 ? std::max(full / w, 2.0 / 3) : 2) - 1) * rough / count;
  }

  /// Displacements as found where the motion is seen, where the path begins, and in the middle of the cell, m.
  struct Found {
    Vec3 seen, begin, middle;
  };
  /// At the beginning of the path, by the water in cell c: under gravity what is beyond one and a half of the weight,
  /// and from two and a half on all, goes by the gradient there, which is that where it is seen and the transpose of
  /// half of the motion's slope times that; but for what holds the weight.
  Vec3 at_begin(const Found& found, const Cell& c) const {
    if (!upright() || !wet(c) || (*fit_)[c].weight == 0) return found.begin;
    const Real share = std::clamp(found.middle.norm() / g_dt2_ - 1.5, 0.0, 1.0);
    const Vec3 held(0, 0, std::clamp(found.middle.z(), 0.0, g_dt2_));
    const Vec3 more = ((*fit_)[c].b.transpose() * (found.seen - held)).cwiseQuotient(2 * size_);
    return share * (found.seen + more) + (1 - share) * found.begin;
  }

  Displacement displacement(const Particle& i, const Vec3& damping) const {
    const Cell& c = i.cell;
    const bool acts = wet(c) || follows(c);
    if (i.in_flight || (upright() && !acts)) return {Vec3::Zero(), 0};
    Found found;
    Vec3 shared;
    for (int a = 0; a < 3; ++a) {
      const Cell cell = follows(c) && a < 2 ? Cell(c - unit(2)) : c;
      std::optional<Real> low = through(a, cell, cell), high = through(a, cell + unit(a), cell);
      if (upright()) {  // what is not known is as on the other side
        low = low ? low : high;
        high = high ? high : low;
      }
      const Real first = low.value_or(0), rise = high.value_or(0) - first;
      found.seen[a] = first + i.y[a] * rise;
      found.begin[a] = first + i.f[a] * rise;
      found.middle[a] = first + rise / 2;
      shared[a] = (1 - i.y[a]) * beyond(a, c) + i.y[a] * beyond(a, c + unit(a));
    }
    const Vec3 u = at_begin(found, follows(c) ? Cell(c - unit(2)) : c) + shared + damping;
    if (!follows(c) && !is_top(c)) return {u, acts ? 1.0 : 0.0};
    const Cell top = follows(c) ? Cell(c - unit(2)) : c;
    const Real below = (top.z() + (*height_)[top] - i.surface.z()) * size_.z() / s_;
    const Real faded = std::clamp((below - 0.25) / 2 + 1, 0.0, 1.0);
    return {faded * u, faded};
  }

  Real gravity_ = 0;     // m/s²
  Real g_dt2_ = 0;       // m, of the step
  bool closed_ = false;  // no water has a surface
  std::optional<CellArray<Real>> fill_, height_, phi_;
  std::optional<CellArray<char>> wet_;
  std::vector<Displacement> result_;
};

}  // namespace trevi::test

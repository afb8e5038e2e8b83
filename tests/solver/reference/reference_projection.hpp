// What the projection does to particles by brute force, serially and over the whole box. Written from what the headers
// of src/projection say of themselves and the constants of parameters.hpp; shares no code with them. Without obstacles.
// Not collective.
#pragma once

#include "reference_pressure.hpp"

namespace trevi::test {

class ReferenceProjection : ReferencePressure {
 public:
  using ReferencePressure::pieces;
  explicit ReferenceProjection(const Scene& scene) : ReferencePressure(scene) {}

  struct Displacement {
    Vec3 u;    // m
    Real act;  // how far the grid acts, from 0 to 1
  };
  /// Of particles that go from x to p in the time dt.
  std::vector<Displacement> displacements(const std::vector<Vec3>& x, const std::vector<Vec3>& p, Real dt) {
    g_dt2_ = gravity_ * dt * dt;
    gather(x, p, g_dt2_);
    find_water();
    const Real time = dt * std::sqrt(gravity_ / h_);
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

  /// Displacements as found where the motion is seen and where the path begins, and upwards in the middle of the cell,
  /// m.
  struct Found {
    Vec3 seen, begin;
    Real middle = 0;
  };
  /// At the beginning of the path, by the water in cell c: under gravity by the gradient there, which is that where it
  /// is seen and the transpose of half of the motion's slope times that, but for what holds the weight.
  bool is_pulled_back(const Cell& c) const { return upright() && wet(c) && (*fit_)[c].weight > 0; }
  Vec3 at_begin(const Found& found, const Cell& c) const {
    if (!is_pulled_back(c)) return found.begin;
    const Vec3 held(0, 0, std::clamp(found.middle, 0.0, g_dt2_));
    return found.seen + ((*fit_)[c].b.transpose() * (found.seen - held)).cwiseQuotient(2 * size_);
  }

  /// The mean upward displacement by the faces of a cell in the water; at a floor and a ceiling that of water at rest.
  std::optional<Real> mean_rise(const Cell& c) const {
    if (!wet(c)) return std::nullopt;
    Real sum = 0;
    for (const Cell& face : {c, Cell(c + unit(2))}) sum += is_wall(2, face) ? g_dt2_ : *through(2, face, c);
    return sum / 2;
  }
  Eigen::Matrix3d mixed_derivatives(const Cell& c) const {
    Eigen::Matrix3d mixed = Eigen::Matrix3d::Zero();
    for (int a = 0; a < dimensions_ - 1; ++a) {
      const Cell step = unit(a);  // beyond a wall the water is that before it, in a mirror
      const auto own = mean_rise(c), low = is_wall(a, c) ? own : mean_rise(c - step);
      const auto high = is_wall(a, c + step) ? own : mean_rise(c + step);
      Real change = 0;
      if (own && (low || high)) change = (high.value_or(*own) - low.value_or(*own)) / (low && high ? 2 : 1);
      if (upright()) change = std::clamp(change, -2 * g_dt2_, 2 * g_dt2_);  // in an impact it is not linear
      mixed(a, 2) = mixed(2, a) = change / size_[a];
    }
    Real sum = 0;
    int edges = 0;
    for (const int i : {-1, 1}) {
      for (const int j : {-1, 1}) {
        const Cell x = c + i * unit(0), y = c + j * unit(1), both = x + j * unit(1);
        const bool mirror = is_wall(0, i < 0 ? c : x) || is_wall(1, j < 0 ? c : y);
        if (mirror) ++edges;
        if (dimensions_ == 2 || mirror || !wet(x) || !wet(y) || !wet(both)) continue;
        sum += i * j * ((*phi_)[both] - (*phi_)[x] - (*phi_)[y] + (*phi_)[c]);
        ++edges;
      }
    }
    if (edges > 0) mixed(0, 1) = mixed(1, 0) = sum / edges / size_[0] / size_[1];
    return mixed;
  }
  /// Across its direction a displacement is that at the ends of paths, but for this: moved back by the mean path of the
  /// cell; what is pulled back by half of it.
  Vec3 back_across(const Cell& c) const {
    const std::vector<std::size_t>& here = (*members_)[c];
    if (!wet(c) || static_cast<Real>(here.size()) * std::pow(s_, 3) < 0.375 * size_.prod()) return Vec3::Zero();
    Vec3 path = Vec3::Zero();
    for (const std::size_t i : here) path += particles_[i].way / static_cast<Real>(here.size());
    path = path.cwiseQuotient(size_);
    const Real bound = upright() ? 1 : 0.25;
    path *= bound / std::max(path.cwiseAbs().maxCoeff(), bound);
    path = (path.array().abs() < 1e-3).select(0, path).cwiseProduct(size_);
    return -(is_pulled_back(c) ? 0.5 : 1.0) * mixed_derivatives(c) * path;
  }

  /// The height by which a displacement fades at the surface, cells: that of the volume, but near the path's beginning.
  static Real fade_height(const Particle& i) {
    const Real begin = i.cell.z() + i.f.z();
    return begin + std::clamp(i.surface.z() - begin, -0.1, 0.1);
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
      if (a == 2) found.middle = first + rise / 2;
      shared[a] = (1 - i.y[a]) * beyond(a, c) + i.y[a] * beyond(a, c + unit(a));
    }
    const Vec3 u = at_begin(found, follows(c) ? Cell(c - unit(2)) : c) + back_across(c) + shared + damping;
    if (!follows(c) && !is_top(c)) return {u, acts ? 1.0 : 0.0};
    const Cell top = follows(c) ? Cell(c - unit(2)) : c;
    const Real below = (top.z() + (*height_)[top] - fade_height(i)) * size_.z() / s_;
    const Real faded = std::clamp((below - 0.15) / 2 + 1, 0.0, 1.0);
    return {faded * u, faded};
  }

  std::vector<Displacement> result_;
};

}  // namespace trevi::test

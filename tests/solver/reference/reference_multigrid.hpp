// The multigrid of the projection by brute force: levels are whole matrices, and the columns of a level are solved by
// elimination with full pivoting. Written from what multigrid.hpp and level.hpp say of themselves and the constants of
// their sources; shares no code with them. Not collective.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "reference_cells.hpp"

namespace trevi::test {

class ReferenceMultigrid {
 public:
  struct Level {
    Eigen::MatrixXd matrix;
    std::vector<Cell> cells;  // that the rows stand for
    int width = 1;            // of a column, in cells
  };

  /// Of water at most `depth` cells deep; `closed`: without a surface.
  ReferenceMultigrid(const Cells& cells, int depth, bool closed) : cells_(cells), closed_(closed) {
    const int widest = std::max(cells.count.x(), cells.count.y());
    while (1 << (levels_ - 1) < widest && 1 << (levels_ - 1) <= std::max(depth, 1)) ++levels_;
  }

  void solve(const Level& finest, Eigen::VectorXd& phi, const Eigen::VectorXd& right, int cycles) const {
    for (int k = 0; k < cycles; ++k) improve(finest, phi, right, levels_);
  }

 private:
  static bool same_column(const Cell& a, const Cell& b) { return a.head<2>() == b.head<2>(); }

  // Of a link to the column below along a: a half, but where a periodic axis has a narrow column at its end what the
  // way between the middles becomes longer by.
  Real share(const Level& fine, int a, const Cell& c) const {
    if (!cells_.repeats(a)) return 0.5;
    const int count = cells_.count[a];
    const auto way = [&](int width, int k) {
      const int columns = (count + width - 1) / width, before = (k + columns - 1) % columns;
      return Real(std::min(width, count - k * width) + std::min(width, count - before * width));
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

  bool is_single(const Level& level) const {
    return level.width >= cells_.count.x() && level.width >= cells_.count.y();
  }

  /// phi after `times` sweeps that go a share of the way to what each column would have beside the others as they are;
  /// where columns repeat, each end is beside the other. Nothing holds phi of a single closed column: it is counted
  /// from the highest cell.
  void sweep(const Level& level, Eigen::VectorXd& phi, const Eigen::VectorXd& right, int times, Real share) const {
    Eigen::MatrixXd columns = level.matrix;
    for (Eigen::Index i = 0; i < columns.rows(); ++i) {
      for (Eigen::Index j = 0; j < columns.rows(); ++j) {
        const Cell &here = level.cells[static_cast<std::size_t>(i)], &there = level.cells[static_cast<std::size_t>(j)];
        if (!same_column(here, there) || std::abs(here.z() - there.z()) > 1) columns(i, j) = 0;
      }
    }
    const Eigen::Index top = columns.rows() - 1;
    const bool pinned = closed_ && is_single(level) && !cells_.repeats(2);
    if (pinned) columns.row(top) = Eigen::RowVectorXd::Unit(columns.cols(), top);
    const Eigen::FullPivLU<Eigen::MatrixXd> inverse(columns);
    for (int k = 0; k < times; ++k) {
      Eigen::VectorXd missing = right - level.matrix * phi;
      if (pinned) missing[top] = -phi[top];
      phi += share * inverse.solve(missing);
    }
  }

  void improve(const Level& level, Eigen::VectorXd& phi, const Eigen::VectorXd& right, int levels) const {
    if (level.cells.empty()) return;
    if (levels == 1) return sweep(level, phi, right, is_single(level) ? 1 : 4, is_single(level) ? 1 : 0.8);
    sweep(level, phi, right, 2, 0.8);
    Eigen::MatrixXd join;
    const Level coarse = coarser(level, join);
    Eigen::VectorXd correction = Eigen::VectorXd::Zero(coarse.matrix.rows());
    improve(coarse, correction, join * (right - level.matrix * phi), levels - 1);
    phi += join.transpose() * correction;
    sweep(level, phi, right, 2, 0.8);
  }

  Cells cells_;
  bool closed_;
  int levels_ = 1;
};

}  // namespace trevi::test

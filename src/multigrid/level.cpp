#include "multigrid/level.hpp"

#include <algorithm>
#include <cmath>

#include "multigrid/column_loops.hpp"

namespace trevi {

namespace {

// Least pivot of the elimination in a column, as a fraction of its diagonal. Below that nothing fixes phi, as in a box
// that is full of water up to its ceiling; phi is then measured relative to the highest cell.
constexpr Real min_pivot = 1e-10;

}  // namespace

void MultigridLevel::borrow(std::initializer_list<Borrowed<Real>*> fields, Scratch& scratch) const {
  for (auto* field : fields) {
    *field = scratch.borrow_briefly<Real>(shape_.cells());
    field->fill(0);
  }
}

void MultigridLevel::borrow_equation(Scratch& scratch) {
  borrow({&phi, &link[0], &link[1], &link[2], &dirichlet, &rhs}, scratch);
}

void MultigridLevel::borrow_for_cycles(Scratch& scratch) { borrow({&next, &per_pivot}, scratch); }

void MultigridLevel::resize(const LevelShape& shape) {
  shape_ = shape;
  give_back();
  const std::size_t rows = (static_cast<std::size_t>(shape.planes) + 2) * static_cast<std::size_t>(shape.rows);
  top_.assign(rows, 0);
  used_.assign(rows, static_cast<std::size_t>(shape.columns));
}

void MultigridLevel::give_back_all_but_phi() {
  for (auto* field : {&link[0], &link[1], &link[2], &dirichlet, &rhs, &next, &per_pivot}) field->give_back();
}

void MultigridLevel::give_back() {
  give_back_all_but_phi();
  phi.give_back();
}

void MultigridLevel::use_columns(LocalId k, LocalId r, std::size_t columns) { used_[row_index(k, r)] = columns; }

void MultigridLevel::factor() {
  for_each_row(shape_.own_rows(), [&](LocalId k, LocalId r) { factor_column(k, r); });
}

void MultigridLevel::factor_column(LocalId k, LocalId r) {
  const std::size_t floor = shape_.index(k, r, 0), row = shape_.step(1), plane = shape_.step(0);
  std::size_t count = 0;
  Real below = 0;  // of the pivot
  const std::size_t end = floor + used(k, r);
  for (std::size_t at = floor; at < end; ++at) {
    const Real diagonal = dirichlet[at] + (link[0][at] + link[0][at + plane]) + (link[1][at] + link[1][at + row]) +
                          (link[2][at] + link[2][at + 1]);
    const Real pivot = diagonal - link[2][at] * link[2][at] * below;
    below = per_pivot[at] = pivot > min_pivot * diagonal ? 1 / pivot : 0;
    if (diagonal > 0) count = at - floor + 1;
  }
  for (std::size_t at = floor + count; at < end; ++at) phi[at] = next[at] = rhs[at] = 0;
  top_[row_index(k, r)] = count;
}

// In `next`: rhs and the contributions of the sides.
void MultigridLevel::gather_column(const Column& column) {
  const auto [at, count] = column;
  const std::size_t row = shape_.step(1), plane = shape_.step(0);
  const Real* x = phi.data() + at;
  Real* y = next.data() + at;
  gather_sides({x, link[0].data() + at, link[1].data() + at, rhs.data() + at, row, plane, count}, y);
  if (!shape_.repeats[2] || count == 0) return;
  const Real* wz = link[2].data() + at;
  y[0] += wz[0] * x[-1];
  y[count - 1] += wz[count] * x[count];
}

// Solves columns for `next`, in place, by elimination from the floor up. Each step in a column depends on the previous
// one, so the steps of several columns are interleaved.
void MultigridLevel::solve_columns(std::span<const Column> columns) {
  if (columns.size() != together) {
    for (const Column& column : columns) {
      const std::array<Column, 1> alone{column};
      std::array<Real, 1> last{};
      eliminate(alone, {0, column.count}, last);
      last = {};
      substitute(alone, {0, column.count}, last);
    }
    return;
  }
  std::array<Column, together> all{};
  std::copy(columns.begin(), columns.end(), all.begin());
  std::size_t common = all[0].count;
  for (const Column& column : all) common = std::min(common, column.count);
  std::array<Real, together> last{}, top{};
  eliminate(all, {0, common}, last);
  for (std::size_t i = 0; i < together; ++i) {
    const std::array<Column, 1> alone{all[i]};
    std::array<Real, 1> own{last[i]};
    eliminate(alone, {common, all[i].count}, own);
    own = {};
    substitute(alone, {common, all[i].count}, own);
    top[i] = own[0];
  }
  substitute(all, {0, common}, top);
}

template <std::size_t n>
void MultigridLevel::eliminate(const std::array<Column, n>& columns, Cells cells, std::array<Real, n>& last) {
  const Real *wz = link[2].data(), *per = per_pivot.data();
  Real* y = next.data();
  for (std::size_t c = cells.begin; c < cells.end; ++c) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t at = columns[i].at + c;
      y[at] = last[i] = y[at] * per[at] + wz[at] * per[at] * last[i];
    }
  }
}

template <std::size_t n>
void MultigridLevel::substitute(const std::array<Column, n>& columns, Cells cells, std::array<Real, n>& last) {
  const Real *wz = link[2].data(), *per = per_pivot.data();
  Real* y = next.data();
  for (std::size_t c = cells.end; c-- > cells.begin;) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t at = columns[i].at + c;
      y[at] = last[i] = y[at] + wz[at + 1] * per[at] * last[i];
    }
  }
}

// Calls make(column) for each column of the planes and solves them, then finish(column).
template <class Make, class Finish>
void MultigridLevel::solve_rows(Range planes, Range of_plane, const Make& make, const Finish& finish) {
  const LocalId rows = of_plane.size(), first = of_plane.begin;
  for_each_part(Range{planes.begin * rows, planes.end * rows}, rows_at_a_time(shape_.columns), [&](Range part) {
    std::array<Column, together> columns{};
    for (LocalId i = part.begin; i < part.end;) {
      std::size_t count = 0;
      for (; i < part.end && count < together; ++i) {
        columns[count] = {shape_.index(i / rows, first + i % rows, 0), top(i / rows, first + i % rows)};
        make(columns[count++]);
      }
      solve_columns(std::span(columns).first(count));
      for (std::size_t j = 0; j < count; ++j) finish(columns[j]);
    }
  });
}

void MultigridLevel::sweep(Range planes, Range rows, Real weight) {
  solve_rows(
      planes, rows, [&](const Column& column) { gather_column(column); },
      [&](const Column& column) { damp(phi.data() + column.at, weight, column.count, next.data() + column.at); });
}

void MultigridLevel::sweep_from_zero(Real weight) {
  solve_rows(
      {1, shape_.planes + 1}, {0, shape_.rows},
      [&](const Column& column) {
        const auto at = static_cast<std::ptrdiff_t>(column.at);
        std::copy_n(rhs.begin() + at, column.count, next.begin() + at);
      },
      [&](const Column& column) {
        for (std::size_t i = column.at; i < column.at + column.count; ++i) next[i] *= weight;
      });
}

void MultigridLevel::find_residual() {
  const std::size_t row = shape_.step(1), plane = shape_.step(0);
  for_each_row(shape_.own_rows(), [&](LocalId k, LocalId r) {
    const std::size_t at = shape_.index(k, r, 0), count = top(k, r);
    const ColumnOfLevel column{
        phi.data() + at, link[0].data() + at, link[1].data() + at, rhs.data() + at, row, plane, count};
    find_residual_of(column, {link[2].data() + at, dirichlet.data() + at, per_pivot.data() + at}, next.data() + at);
  });
}

void MultigridLevel::repeat(Borrowed<Real>& field) const {
  if (shape_.repeats[0] && shape_.is_whole()) {
    const auto plane = static_cast<std::ptrdiff_t>(shape_.step(0));
    std::copy_n(field.end() - 2 * plane, plane, field.begin());
    std::copy_n(field.begin() + plane, plane, field.end() - plane);
  }
  if (shape_.repeats[2]) repeat_columns(field, shape_.columns);
  if (shape_.repeats[1] && !shape_.rows_are_cut()) repeat_rows(field, shape_.rows, shape_.columns);
}

MultigridLevel::Children MultigridLevel::children_of(const LevelShape& coarse, LocalId k, LocalId r) const {
  const LocalId plane = 2 * (k - 1 + coarse.first), row = 2 * (r + coarse.first_row);
  return {shape_.index(plane - shape_.first + 1, row - shape_.first_row, 0), row + 1 < shape_.all_rows ? 1.0 : 0.0,
          plane + 1 < shape_.all_planes ? 1.0 : 0.0};
}

// The plane of `coarse` that contains plane k of this level; it may be a ghost plane of both.
LocalId MultigridLevel::parent_of(const LevelShape& coarse, LocalId k) const {
  const LocalId plane = k - 1 + shape_.first;
  return (plane == shape_.all_planes ? coarse.all_planes + 1 : (plane + 2) / 2) - coarse.first;
}

// The same for rows.
LocalId MultigridLevel::parent_row_of(const LevelShape& coarse, LocalId r) const {
  const LocalId row = r + shape_.first_row;
  return (row == shape_.all_rows ? coarse.all_rows : (row + 2) / 2 - 1) - coarse.first_row;
}

LocalId LevelShape::distance_below(std::size_t a, LocalId k) const {
  const LocalId last = count(a) - 1;
  return k == 0 || k == last ? width + last_width[a] : 2 * width;
}

// The fraction of the sum of links across the lower face of plane or row k of `coarse`: a half, because the distance is
// twice as long. If the level is periodic, the last one may be narrow, and the distance to its neighbours shorter; a
// single one has no neighbour.
Real MultigridLevel::fraction_of_link(const LevelShape& coarse, std::size_t a, LocalId k) const {
  if (!coarse.repeats[a]) return 0.5;
  if (coarse.count(a) == 1) return 0;
  return static_cast<Real>(shape_.distance_below(a, 2 * k)) / coarse.distance_below(a, k);
}

namespace {

// A link of a coarse cell from the sum of the finer ones, and from the sums of those inside the two coarse cells beyond
// it. Between their centres these count as well, in series and by half. Only weak links are treated so.
Real of_coarse(Real sum, Real fraction, Real inside_below, Real inside_above) {
  constexpr Real weak = 0.25;
  if (sum == 0 || sum > weak * std::min(inside_below, inside_above)) return sum * fraction;
  return sum * std::max(fraction, 1 / (1 + sum / 2 * (1 / inside_below + 1 / inside_above)));
}

}  // namespace

void MultigridLevel::coarsen(MultigridLevel& coarse, const CellRows& made, bool among_solids) const {
  const LevelShape& to = coarse.shape_;
  const std::size_t row = shape_.step(1), plane = shape_.step(0);
  for_each_row(made, [&](LocalId k, LocalId r) {
    const Children of = children_of(to, k, r);
    const std::size_t at = to.index(k, r, 0);
    const Real over_planes = fraction_of_link(to, 0, k - 1 + to.first),
               over_rows = fraction_of_link(to, 1, r + to.first_row);
    const auto sum = [&](const Borrowed<Real>& x, std::size_t i) {
      return (x[i] + of.rows * x[i + row]) + of.planes * (x[i + plane] + of.rows * x[i + plane + row]);
    };
    for (std::size_t c = 0; c < static_cast<std::size_t>(to.columns); ++c) {
      const std::size_t i = of.first + c;
      const auto across_planes = [&](std::size_t n) { return link[0][n] + of.rows * link[0][n + row]; };
      const auto across_rows = [&](std::size_t n) { return link[1][n] + of.planes * link[1][n + plane]; };
      const Real planes = across_planes(i), rows = across_rows(i);
      if (among_solids) {
        coarse.link[0][at + c] = of_coarse(planes, over_planes, across_planes(i - plane),
                                           of.planes > 0 ? across_planes(i + plane) : INFINITY);
        coarse.link[1][at + c] =
            of_coarse(rows, over_rows, across_rows(i - row), of.rows > 0 ? across_rows(i + row) : INFINITY);
      } else {
        coarse.link[0][at + c] = planes * over_planes;
        coarse.link[1][at + c] = rows * over_rows;
      }
      coarse.link[2][at + c] = sum(link[2], i);
      coarse.dirichlet[at + c] = sum(dirichlet, i);
    }
  });
}

void MultigridLevel::restrict_residual(MultigridLevel& coarse, const CellRows& made) const {
  const LevelShape& to = coarse.shape_;
  const std::size_t row = shape_.step(1), plane = shape_.step(0);
  for_each_row(made, [&](LocalId k, LocalId r) {
    const Children of = children_of(to, k, r);
    const Real* from = next.data() + of.first;
    Real* y = coarse.rhs.data() + to.index(k, r, 0);
    for (std::size_t c = 0; c < static_cast<std::size_t>(to.columns); ++c)
      y[c] = (from[c] + of.rows * from[c + row]) + of.planes * (from[c + plane] + of.rows * from[c + plane + row]);
  });
}

void MultigridLevel::add_correction(const MultigridLevel& coarse) {
  const LevelShape& from = coarse.shape_;
  const LocalId beside = shape_.rows_are_cut() ? 1 : 0;
  const CellRows rows{{0, shape_.planes + 2}, shape_.rows + 2 * beside, shape_.columns, -beside};
  for_each_row(rows, [&](LocalId k, LocalId r) {
    const std::size_t at = shape_.index(k, r, 0), above = from.index(parent_of(from, k), parent_row_of(from, r), 0);
    const bool is_own = r >= 0 && r < shape_.rows;
    const std::size_t end = is_own ? used(k, r) : static_cast<std::size_t>(shape_.columns);
    add_where_water(coarse.phi.data() + above, per_pivot.data() + at, end, phi.data() + at);
  });
  repeat(phi);
}

std::size_t MultigridLevel::bytes() const { return (top_.capacity() + used_.capacity()) * sizeof(std::size_t); }

}  // namespace trevi

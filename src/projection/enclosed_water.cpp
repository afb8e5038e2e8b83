#include "projection/enclosed_water.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/threads.hpp"
#include "parallel/reductions.hpp"
#include "parallel/waiting.hpp"
#include "projection/free_surface.hpp"

namespace trevi {

namespace {

constexpr GlobalId whole_cell = 1'000'000;

Real unit_of_phi(const FreeSurface& surface) { return surface.grid().size()[2] * surface.grid().size()[2]; }

// Sets that are joined two by two, with the smallest member as the root of each.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) {
    i = root(i);
    j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace

// Calls visit(the cell beyond it) for each open face of an owned cell. Among obstacles, faces at drains count as open:
// which of them are closed is not known yet.
template <class Visit>
void EnclosedWater::for_each_beside(const FreeSurface& surface, std::size_t at, const Visit& visit) const {
  const ProjectionGrid& grid = surface.grid();
  const auto [k, r, c] = grid.cell_at(at);
  for (std::size_t a = 0; a < 3; ++a) {
    for (const bool upper : {false, true}) {
      const std::size_t above = upper ? at + grid.step(a) : at;
      const Real open = surface.cuts() != nullptr ? surface.cuts()->face(a, above) : surface.face(a, above);
      if (open == 0 || grid.is_wall({a, upper}, k, r, c)) continue;
      visit(upper ? above : at - grid.step(a));
    }
  }
}

bool EnclosedWater::is_at_air(const FreeSurface& surface, std::size_t at) const {
  bool found = false;
  for_each_beside(surface, at, [&](std::size_t beside) { found = found || !surface.may_hold_water(beside); });
  return found;
}

// Calls visit(first cell, end, whether any of them touches air) for each run of cells that open faces connect in a
// column. All cells of a run have a surface if one of them has.
template <class Visit>
void EnclosedWater::for_each_run(const FreeSurface& surface, const Visit& visit) const {
  const ProjectionGrid& grid = surface.grid();
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    const std::size_t floor = grid.index(k, r, 0), ceiling = floor + static_cast<std::size_t>(grid.columns(k, r));
    for (std::size_t begin = floor; begin < ceiling;) {
      if (!surface.may_hold_water(begin)) {
        ++begin;
        continue;
      }
      std::size_t end = begin + 1;
      while (end < ceiling && surface.may_hold_water(end) &&
             (surface.cuts() == nullptr || surface.cuts()->face(2, end) > 0))
        ++end;
      bool at_air = is_at_air(surface, end - 1);
      for (std::size_t at = begin; at + 1 < end && !at_air; ++at) at_air = is_at_air(surface, at);
      visit(begin, end, at_air);
      begin = end;
    }
  });
}

void EnclosedWater::find_whole(const FreeSurface& surface, Halo& halo) {
  const ProjectionGrid& grid = surface.grid();
  all_ = false;
  // Under gravity only water that reaches the ceiling has none.
  if (surface.upright() && grid.columns() < grid.count(2)) return;
  PerThread<char> found;
  for_each_run(surface, [&](std::size_t, std::size_t, bool at_air) { found.mine() |= at_air ? 1 : 0; });
  int any = 0;
  found.for_each([&](char one) { any |= one; });
  all_reduce(halo.comm(), &any, 1, MPI_INT, MPI_MAX);
  all_ = any == 0;
}

// `names` has the name of its part for each cell that may hold such water, and 0 for all others.
void EnclosedWater::find(const FreeSurface& surface, Halo& halo) {
  const ProjectionGrid& grid = surface.grid();
  marks_.give_back();
  cells_.clear();
  PerThread<std::vector<std::size_t>> found;
  for_each_run(surface, [&](std::size_t begin, std::size_t end, bool at_air) {
    for (std::size_t at = begin; at < end && !at_air; ++at) found.mine().push_back(at);
  });
  found.for_each([&](const auto& some) { cells_.insert(cells_.end(), some.begin(), some.end()); });
  int any = cells_.empty() ? 0 : 1;
  all_reduce(halo.comm(), &any, 1, MPI_INT, MPI_MAX);
  if (any == 0) return;
  std::sort(cells_.begin(), cells_.end());
  Borrowed<GlobalId> names = grid.scratch().borrow_briefly<GlobalId>(grid.cells());
  names.fill(0);
  join_cells(surface, halo.comm(), names);
  grid.exchange(halo, names);
  join_parts(halo.comm(), edges_between(surface, names));
  names.give_back();
  keep_enclosed(surface, halo);
}

// The parts of pieces on this rank. At first names are those of single cells; ghost cells have none yet.
void EnclosedWater::join_cells(const FreeSurface& surface, MPI_Comm comm, const Borrowed<GlobalId>& names) {
  for (std::size_t i = 0; i < cells_.size(); ++i) names[cells_[i]] = static_cast<GlobalId>(i) + 1;
  DisjointSets sets(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    for_each_beside(surface, cells_[i], [&](std::size_t beside) {
      if (names[beside] > 0) sets.join(i, static_cast<std::size_t>(names[beside] - 1));
    });
  }
  parts_.clear();
  part_of_.resize(cells_.size());
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const std::size_t root = sets.root(i);
    if (root == i) parts_.push_back({});
    part_of_[i] = root == i ? parts_.size() - 1 : part_of_[root];
  }
  const GlobalId first = 1 + sum_over_lower_ranks(comm, static_cast<GlobalId>(parts_.size()));
  for (std::size_t k = 0; k < parts_.size(); ++k) parts_[k].name = first + static_cast<GlobalId>(k);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Part& part = parts_[part_of_[i]];
    if (surface.holds_particles(cells_[i]))
      part.volume += std::llround(surface.open(cells_[i]) * static_cast<Real>(whole_cell));
    names[cells_[i]] = part.name;
    const CutCells* const cuts = surface.cuts();
    if (cuts != nullptr && cuts->any_floats() && cuts->is_pushed(cells_[i])) part.has_body = 1;
  }
}

// Where parts touch parts of other ranks or, across a periodic end, of this one. It also finds which of them touch
// water that has a surface, or air.
std::vector<EnclosedWater::Edge> EnclosedWater::edges_between(const FreeSurface& surface,
                                                              const Borrowed<GlobalId>& names) {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    Part& part = parts_[part_of_[i]];
    for_each_beside(surface, cells_[i], [&](std::size_t beside) {
      if (names[beside] == 0) {
        part.has_surface = 1;
      } else if (names[beside] != part.name) {
        edges.push_back({part.name, names[beside]});
      }
    });
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Pieces of several parts, on all ranks alike. What a piece has is then said of each of its parts.
void EnclosedWater::join_parts(MPI_Comm comm, const std::vector<Edge>& edges) {
  std::vector<Part> touching;
  for (const Part& part : parts_) {
    const auto edge = std::lower_bound(edges.begin(), edges.end(), Edge{part.name, 0});
    if (edge != edges.end() && edge->from == part.name) touching.push_back(part);
  }
  std::vector<Part> all = gather_over_ranks(comm, touching);  // in the order of their names
  const auto number_of = [&](GlobalId name) {
    const auto is_before = [](const Part& part, GlobalId other) { return part.name < other; };
    return static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), name, is_before) - all.begin());
  };
  DisjointSets sets(all.size());
  for (const Edge& edge : gather_over_ranks(comm, edges)) sets.join(number_of(edge.from), number_of(edge.to));
  std::vector<std::size_t> piece_of(all.size());
  shared_pieces_ = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::size_t root = sets.root(k);
    piece_of[k] = root == k ? ++shared_pieces_ : piece_of[root];
    if (root == k) continue;
    all[root].volume += all[k].volume;
    all[root].has_surface |= all[k].has_surface;
    all[root].has_body |= all[k].has_body;
  }
  shared_.assign(parts_.size(), 0);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const std::size_t number = number_of(parts_[k].name);
    if (number == all.size() || all[number].name != parts_[k].name) continue;
    const Part& piece = all[sets.root(number)];
    shared_[k] = piece_of[number];
    parts_[k].volume = piece.volume;
    parts_[k].has_surface = piece.has_surface;
    parts_[k].has_body = piece.has_body;
  }
}

void EnclosedWater::keep_enclosed(const FreeSurface& surface, Halo& halo) {
  const ProjectionGrid& grid = surface.grid();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Part& part = parts_[part_of_[i]];
    if (part.has_surface != 0 || part.volume < (part.has_body != 0 ? 1 : whole_cell)) continue;
    cells_[kept] = cells_[i];
    part_of_[kept++] = part_of_[i];
  }
  cells_.resize(kept);
  part_of_.resize(kept);
  int any = kept > 0 ? 1 : 0;
  all_reduce(halo.comm(), &any, 1, MPI_INT, MPI_MAX);
  if (any == 0) return;
  marks_ = grid.scratch().borrow<char>(grid.cells());
  marks_.fill(0);
  for (const std::size_t at : cells_) marks_[at] = 1;
  grid.exchange(halo, marks_);
}

// As integers, so that the sums do not depend on the ranks. Those of pieces on several ranks come first.
std::vector<EnclosedWater::Flow> EnclosedWater::sums_over_pieces(MPI_Comm comm, const std::vector<Flow>& flows) const {
  constexpr Real units = 1 << 30;  // of a cell
  const auto number_of = [&](const Flow& flow) {
    if (all_) return std::size_t{0};
    const auto cell = std::lower_bound(cells_.begin(), cells_.end(), flow.cell) - cells_.begin();
    const std::size_t part = part_of_[static_cast<std::size_t>(cell)];
    return shared_[part] > 0 ? shared_[part] - 1 : shared_pieces_ + part;
  };
  const std::size_t shared = all_ ? 1 : shared_pieces_;
  std::vector<GlobalId> sums(2 * (all_ ? 1 : shared + parts_.size()), 0);
  for (const Flow& flow : flows) {
    const std::size_t n = 2 * number_of(flow);
    sums[n] += std::llround(flow.brought * units);
    sums[n + 1] += std::llround(flow.leaving * units);
  }
  if (shared > 0) all_reduce(comm, sums.data(), static_cast<int>(2 * shared), MPI_INT64_T, MPI_SUM);
  std::vector<Flow> found;
  for (const Flow& flow : flows) {
    const std::size_t n = 2 * number_of(flow);
    found.push_back({flow.cell, static_cast<Real>(sums[n]) / units, static_cast<Real>(sums[n + 1]) / units});
  }
  return found;
}

void EnclosedWater::set_origins(const FreeSurface& surface, Halo& halo, Borrowed<Real>& phi,
                                std::span<const Real> origins) const {
  if (all_) return set_common_origin(surface, halo.comm(), phi, origins[0]);
  const std::vector<Real> most = largest_of_parts(halo.comm(), phi);
  std::vector<Real> means;
  if (surface.cuts()->any_floats()) means = means_of_parts(surface, halo.comm(), phi, unit_of_phi(surface), INFINITY);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const std::size_t part = part_of_[i];
    phi[cells_[i]] -= (has_body(part) ? means[part] : most[part]) - origins[part];
  }
  surface.grid().exchange(halo, phi);
}

std::vector<Real> EnclosedWater::origins(const FreeSurface& surface, MPI_Comm comm, const Borrowed<Real>& phi,
                                         Real largest) const {
  if (all_) return {largest};
  if (!surface.cuts()->any_floats()) return std::vector<Real>(parts_.size(), largest);
  std::vector<Real> found = means_of_parts(surface, comm, phi, unit_of_phi(surface), 0);
  for (std::size_t k = 0; k < parts_.size(); ++k)
    if (!has_body(k) || found[k] == 0) found[k] = largest;
  return found;
}

void EnclosedWater::balance(const FreeSurface& surface, MPI_Comm comm, Borrowed<Real>& rhs) const {
  if (all_ || !any()) return;
  const std::vector<Real> means = means_of_parts(surface, comm, rhs, 1, INFINITY);
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (has_body(part_of_[i])) rhs[cells_[i]] -= means[part_of_[i]];
}

// For each part of this rank, the largest phi of its piece.
std::vector<Real> EnclosedWater::largest_of_parts(MPI_Comm comm, const Borrowed<Real>& phi) const {
  std::vector<Real> most(parts_.size(), -INFINITY), of_shared(shared_pieces_ + 1, -INFINITY);
  for (std::size_t i = 0; i < cells_.size(); ++i) most[part_of_[i]] = std::max(most[part_of_[i]], phi[cells_[i]]);
  for (std::size_t k = 0; k < parts_.size(); ++k) of_shared[shared_[k]] = std::max(of_shared[shared_[k]], most[k]);
  if (shared_pieces_ > 0) all_reduce(comm, of_shared.data(), static_cast<int>(of_shared.size()), MPI_DOUBLE, MPI_MAX);
  for (std::size_t k = 0; k < parts_.size(); ++k)
    if (shared_[k] > 0) most[k] = of_shared[shared_[k]];
  return most;
}

// For each part of this rank, the mean over the cells of its piece with values less than `below`; 0 without any. Sums
// are of integers, multiples of a small part of the unit, so that they do not depend on the ranks.
std::vector<Real> EnclosedWater::means_of_parts(const FreeSurface& surface, MPI_Comm comm, const Borrowed<Real>& field,
                                                Real unit, Real below) const {
  constexpr Real fine = 1 << 30, most = 1 << 20;
  std::vector<GlobalId> sums(2 * parts_.size(), 0), of_shared(2 * (shared_pieces_ + 1), 0);
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Real here = field[cells_[i]];
    if (!(here < below) || surface.open(cells_[i]) == 0) continue;
    sums[2 * part_of_[i]] += std::llround(std::clamp(here / unit, -most, most) * fine);
    ++sums[2 * part_of_[i] + 1];
  }
  for (std::size_t k = 0; k < parts_.size(); ++k)
    for (std::size_t n = 0; n < 2; ++n) of_shared[2 * shared_[k] + n] += sums[2 * k + n];
  if (shared_pieces_ > 0) all_reduce(comm, of_shared.data(), static_cast<int>(of_shared.size()), MPI_INT64_T, MPI_SUM);
  std::vector<Real> means(parts_.size(), 0);
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const GlobalId* const own = shared_[k] > 0 ? &of_shared[2 * shared_[k]] : &sums[2 * k];
    if (own[1] > 0) means[k] = static_cast<Real>(own[0]) / static_cast<Real>(own[1]) / fine * unit;
  }
  return means;
}

void EnclosedWater::set_common_origin(const FreeSurface& surface, MPI_Comm comm, Borrowed<Real>& phi, Real largest) {
  const ProjectionGrid& grid = surface.grid();
  PerThread<Real> found;
  found.for_each([](Real& most) { most = -INFINITY; });
  for_each_row(grid.rows_of({1, grid.planes() + 1}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid.columns(k, r); ++c) {
      const std::size_t at = grid.index(k, r, c);
      if (surface.is_wet(at)) found.mine() = std::max(found.mine(), phi[at]);
    }
  });
  Real most = -INFINITY;
  found.for_each([&](Real one) { most = std::max(most, one); });
  all_reduce(comm, &most, 1, MPI_DOUBLE, MPI_MAX);
  if (!std::isfinite(most)) return;
  for_each_row(grid.rows_of({0, grid.planes() + 2}), [&](LocalId k, LocalId r) {
    for (LocalId c = 0; c < grid.columns(k, r); ++c) phi[grid.index(k, r, c)] -= most - largest;
  });
}

}  // namespace trevi

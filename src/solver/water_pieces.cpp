#include "solver/water_pieces.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <numeric>

#include "base/threads.hpp"
#include "parallel/reductions.hpp"

namespace trevi {

namespace {

constexpr std::int64_t touching = -1;  // less than all labels of cells

// The smallest element connected with `of`; parents are smaller than their children.
template <class Index>
Index root_in(std::vector<Index>& parent, Index of) {
  auto at = [&](Index k) -> Index& { return parent[static_cast<std::size_t>(k)]; };
  while (at(of) != of) of = at(of) = at(at(of));
  return of;
}

template <class Index>
void join_in(std::vector<Index>& parent, Index a, Index b) {
  const Index of_a = root_in(parent, a), of_b = root_in(parent, b);
  parent[static_cast<std::size_t>(std::max(of_a, of_b))] = std::min(of_a, of_b);
}

// -1 for positions below [0, count), 1 for those beyond, otherwise 0.
int way_out(LocalId at, LocalId count) { return at < 0 ? -1 : at >= count ? 1 : 0; }

// Calls work(k, r) for owned rows, or for the ghost rows around them.
template <class Work>
void for_each_row(const CellOrder& order, bool ghosts, const Work& work) {
  for_each_part(order.planes() + 2, [&](LocalId k) {
    for (LocalId r = -1; r <= order.rows(); ++r) {
      const bool own = k > 0 && k <= order.planes() && r >= 0 && r < order.rows();
      if (own != ghosts) work(k, r);
    }
  });
}

}  // namespace

std::size_t WaterPieces::root(std::size_t run) { return root_in(parent_, run); }

// In each row no cell beyond its last particle is examined: the air above the water costs nothing.
void WaterPieces::find_runs(const CellOrder& order, bool ghosts) {
  rows_.resize(static_cast<std::size_t>((order.planes() + 2) * (order.rows() + 2)));
  for_each_row(order, ghosts, [&](LocalId k, LocalId r) {
    std::vector<CellRun>& runs = row(order, k, r);
    runs.clear();
    const Range all = order.row(k, r);
    bool open = false;
    for (LocalId c = 0, next = all.begin; next < all.end; ++c) {
      const LocalId end = order.run(k, r, {c, c + 1}).end;
      if (end > next && !open) runs.push_back({{c, c}, {next, next}});
      open = end > next;
      if (open) runs.back().columns.end = c + 1;
      if (open) runs.back().particles.end = end;
      next = end;
    }
  });
}

// Calls join(one of a, one of b) for runs that have cells next to each other.
void WaterPieces::join_rows(const CellOrder& order, const std::vector<CellRun>& a, const std::vector<CellRun>& b,
                            const std::function<void(const CellRun&, const CellRun&)>& join) const {
  if (a.empty() || b.empty()) return;
  for (auto one = a.begin(), other = b.begin(); one != a.end() && other != b.end();) {
    if (one->columns.begin <= other->columns.end && other->columns.begin <= one->columns.end) join(*one, *other);
    (one->columns.end < other->columns.end ? one : other)++;
  }
  if (!order.grid().is_periodic(2)) return;
  const LocalId end = order.grid().columns();
  if (a.front().columns.begin == 0 && b.back().columns.end == end) join(a.front(), b.back());
  if (b.front().columns.begin == 0 && a.back().columns.end == end) join(a.back(), b.front());
}

void WaterPieces::join_own(const CellOrder& order) {
  own_.clear();
  for (LocalId k = 1; k <= order.planes(); ++k) {
    for (LocalId r = 0; r < order.rows(); ++r) {
      for (CellRun& run : row(order, k, r)) {
        run.number = own_.size();
        own_.push_back(&run);
      }
    }
  }
  parent_.resize(own_.size());
  std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  const auto join = [&](const CellRun& a, const CellRun& b) { join_in(parent_, a.number, b.number); };
  const bool wraps = order.grid().is_periodic(1) && !order.rows_are_cut();
  for (LocalId k = 1; k <= order.planes(); ++k) {
    for (LocalId r = 0; r < order.rows(); ++r) {
      const std::vector<CellRun>& here = row(order, k, r);
      if (here.empty()) continue;
      join_rows(order, here, here, join);
      for (const auto& [plane, across] : {std::pair{k, r - 1}, {k - 1, r - 1}, {k - 1, r}, {k - 1, r + 1}}) {
        const LocalId beside = wraps ? (across + order.rows()) % order.rows() : across;
        if (plane > 0 && beside >= 0 && beside < order.rows()) join_rows(order, here, row(order, plane, beside), join);
      }
    }
  }
}

// Finds the labels of the roots. Returns whether some piece on this rank is not touched along all axes.
bool WaterPieces::find_touching(const CellOrder& order, const std::function<Axes(std::size_t)>& touches) {
  of_roots_.assign(own_.size(), 0);
  std::vector<std::size_t> roots(own_.size());
  for (std::size_t run = 0; run < own_.size(); ++run) roots[run] = root(run);
  constexpr LocalId part_size = 8;
  for_each_part({0, static_cast<LocalId>(own_.size())}, part_size, [&](Range part) {
    for (auto run = static_cast<std::size_t>(part.begin); run < static_cast<std::size_t>(part.end); ++run) {
      std::atomic_ref<Axes> mark(of_roots_[roots[run]]);
      const Range particles = own_[run]->particles;
      Axes axes = mark.load(std::memory_order_relaxed);
      for (LocalId i = particles.begin; i < particles.end && axes != all_axes; ++i)
        axes |= touches(static_cast<std::size_t>(i - order.low_ghosts()));
      mark.fetch_or(axes, std::memory_order_relaxed);
    }
  });
  labels_.assign(own_.size(), touching);
  bool any = false;
  std::size_t run = 0;
  for (LocalId k = 1; k <= order.planes(); ++k) {
    for (LocalId r = 0; r < order.rows(); ++r) {
      for (const CellRun& one : row(order, k, r)) {
        if (roots[run] == run && of_roots_[run] != all_axes) {
          any = true;
          const std::int64_t plane = order.window().planes.begin + k - 1, across = order.window().rows.begin + r;
          labels_[run] = (plane * order.grid().rows() + across) * order.grid().columns() + one.columns.begin;
        }
        ++run;
      }
    }
  }
  return any;
}

// Calls visit(own, ghost, ways) for runs that have cells next to each other across a cut. `ways`: the direction by
// planes and by rows, -1, 0 or 1.
void WaterPieces::visit_beyond(const CellOrder& order, const BeyondVisit& visit) {
  const bool wraps = order.grid().is_periodic(1) && !order.rows_are_cut();
  for (LocalId k = 1; k <= order.planes(); ++k) {
    for (LocalId r = 0; r < order.rows(); ++r) {
      for (int n = 0; n < 9; ++n) {
        const LocalId plane = k + n / 3 - 1, across = r + n % 3 - 1;
        const LocalId beside = wraps ? (across + order.rows()) % order.rows() : across;
        const std::array<int, 2> ways{way_out(plane - 1, order.planes()), way_out(beside, order.rows())};
        if (ways == std::array<int, 2>{}) continue;
        join_rows(order, row(order, k, r), row(order, plane, beside),
                  [&](const CellRun& own, const CellRun& ghost) { visit(own, ghost, ways); });
      }
    }
  }
}

// Whether a piece may end on this rank along an axis along which it is not touched here. Pieces for which this is not
// the case continue from cut to cut up to the walls.
bool WaterPieces::find_ends(const CellOrder& order) {
  constexpr unsigned low = 1, high = 2;
  std::vector<std::array<unsigned, 2>> goes_on(own_.size());  // of roots, by planes and by rows
  visit_beyond(order, [&](const CellRun& own, const CellRun&, const std::array<int, 2>& ways) {
    for (std::size_t a = 0; a < ways.size(); ++a)
      if (ways[a] != 0) goes_on[root(own.number)][a] |= ways[a] < 0 ? low : high;
  });
  for (std::size_t run = 0; run < own_.size(); ++run) {
    if (labels_[run] == touching) continue;
    for (std::size_t a = 0; a < 3; ++a) {
      if ((static_cast<unsigned>(of_roots_[run]) >> static_cast<unsigned>(order.grid().axis(a)) & 1U) != 0) continue;
      const bool is_cut = a == 0 || (a == 1 && order.rows_are_cut());
      if (!is_cut || order.grid().is_periodic(a) || goes_on[run][a] != (low | high)) return true;
    }
  }
  return false;
}

// The connections across cuts as seen by this rank, each only once: the label of the own part, that of the part beyond,
// and the axes along which the own part is touched here. Each label belongs to an owned cell of the rank that has the
// part.
WaterPieces::Numbers WaterPieces::joints(const CellOrder& order, const Labels& labels) {
  std::vector<std::array<std::int64_t, 3>> found;
  visit_beyond(order, [&](const CellRun& own, const CellRun& ghost, const std::array<int, 2>&) {
    const std::int64_t a = label(own.number), b = labels[static_cast<std::size_t>(ghost.particles.begin)];
    if (a != b) found.push_back({a, b, of_roots_[root(own.number)]});
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  Numbers joints;
  for (const auto& joint : found) joints.insert(joints.end(), joint.begin(), joint.end());
  return joints;
}

void WaterPieces::join_ranks(MPI_Comm comm, const Numbers& own_joints) {
  const Numbers joints = gather_over_ranks(comm, own_joints);
  Numbers all;
  for (std::size_t k = 0; k < joints.size(); k += 3) all.insert(all.end(), {joints[k], joints[k + 1]});
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const auto place = [&](std::int64_t one) { return std::lower_bound(all.begin(), all.end(), one) - all.begin(); };
  std::vector<std::ptrdiff_t> parent(all.size());
  std::iota(parent.begin(), parent.end(), std::ptrdiff_t{0});
  for (std::size_t k = 0; k < joints.size(); k += 3) join_in(parent, place(joints[k]), place(joints[k + 1]));
  std::vector<Axes> touched(all.size(), 0);  // of roots
  const auto of_root = [&](std::ptrdiff_t k) -> Axes& { return touched[static_cast<std::size_t>(root_in(parent, k))]; };
  for (std::size_t k = 0; k < joints.size(); k += 3) of_root(place(joints[k])) |= static_cast<Axes>(joints[k + 2]);
  joined_.clear();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto at = static_cast<std::ptrdiff_t>(k);
    const Axes axes = of_root(at);
    joined_.push_back({all[k], axes == all_axes ? touching : all[static_cast<std::size_t>(root_in(parent, at))], axes});
  }
}

void WaterPieces::find_pieces(const CellOrder& order) {
  runs_.clear();
  touched_.clear();
  Numbers least;  // of pieces on several ranks
  for (const Joined& joined : joined_) {
    if (joined.label != joined.first || joined.label == touching) continue;
    least.push_back(joined.label);
    touched_.push_back(joined.touched);
  }
  shared_ = least.size();
  std::vector<std::size_t> piece(own_.size());  // of local roots
  for (std::size_t run = 0; run < own_.size(); ++run) {
    const std::size_t first = root(run);
    std::int64_t name = labels_[first];
    if (name == touching) continue;
    const auto joined = std::lower_bound(joined_.begin(), joined_.end(), name,
                                         [](const Joined& one, std::int64_t label) { return one.label < label; });
    const bool is_shared = joined != joined_.end() && joined->label == name;
    if (is_shared) name = joined->first;
    if (name == touching) continue;
    if (is_shared) {
      piece[first] = static_cast<std::size_t>(
          std::lower_bound(least.begin(), least.begin() + static_cast<std::ptrdiff_t>(shared_), name) - least.begin());
    } else if (first == run) {
      piece[first] = least.size();
      least.push_back(name);
      touched_.push_back(of_roots_[run]);
    }
    const Range& particles = own_[run]->particles;
    runs_.push_back({{particles.begin - order.low_ghosts(), particles.end - order.low_ghosts()}, piece[first]});
  }
  first_cells_.clear();
  const std::int64_t columns = order.grid().columns(), rows = order.grid().rows();
  for (const std::int64_t cell : least)
    first_cells_.push_back({static_cast<LocalId>(cell / columns / rows), static_cast<LocalId>(cell / columns % rows),
                            static_cast<LocalId>(cell % columns)});
}

bool WaterPieces::find(MPI_Comm comm, const CellOrder& order, Scratch& scratch,
                       const std::function<Axes(std::size_t)>& touches, const std::function<void(Labels&)>& exchange) {
  find_runs(order, false);
  join_own(order);
  const bool any = find_touching(order, touches);
  if (any) find_runs(order, true);
  if (max_over_ranks(comm, any && find_ends(order) ? 1.0 : 0.0) == 0) {
    runs_.clear();
    first_cells_.clear();
    touched_.clear();
    shared_ = 0;
    return false;
  }
  Labels labels = scratch.borrow<std::int64_t>(static_cast<std::size_t>(order.size()));
  labels.fill(touching);
  for (std::size_t run = 0; run < own_.size(); ++run) {
    const Range& particles = own_[run]->particles;
    std::fill(labels.begin() + particles.begin, labels.begin() + particles.end, label(run));
  }
  exchange(labels);
  if (!any) find_runs(order, true);
  join_ranks(comm, joints(order, labels));
  find_pieces(order);
  return max_over_ranks(comm, count() > 0 ? 1.0 : 0.0) > 0;
}

}  // namespace trevi

#include "projection/active_rows.hpp"

#include <algorithm>
#include <array>

#include "base/threads.hpp"
#include "parallel/waiting.hpp"

namespace trevi {

void ActiveRows::measure(const CellOrder& order, Halo& halo) {
  planes_ = order.planes();
  rows_ = order.rows();
  rows_are_cut_ = order.rows_are_cut();
  rows_wrap_ = order.grid().is_periodic(1) && !rows_are_cut_;
  // Beyond the ends of the box nothing is received.
  for (auto* of_rows : {&surface_, &wet_, &near_}) of_rows->assign(index(planes_ + 2, -1), 0);
  PerThread<int> depth;
  for_each_row(rows_and_ghosts_of({0, planes_ + 2}),
               [&](LocalId k, LocalId r) { look_at_row(order, k, r, depth.mine()); });
  spread(surface_, rows_of({1, planes_ + 1}), wet_);
  halo.start_planes(wet_, static_cast<std::size_t>(rows_) + 2);
  halo.start_rows(wet_, static_cast<std::size_t>(rows_) + 2);
  halo.finish();
  spread(wet_, rows_and_ghosts_of({0, planes_ + 2}), near_);
  std::array<LocalId, 2> most{};
  depth.for_each([&](int one) { most[0] = std::max(most[0], one); });
  most[1] = find_max_columns();
  all_reduce(comm_, most.data(), 2, MPI_INT32_T, MPI_MAX);
  depth_ = most[0];
  max_columns_ = most[1];
}

void ActiveRows::look_at_row(const CellOrder& order, LocalId k, LocalId r, int& depth) {
  const LocalId columns = order.grid().columns();
  LocalId& surface = surface_[index(k, r)] = 0;
  int run = 0;
  for (LocalId c = 0; c < columns; ++c) {
    const LocalId count = order.run(k, r, {c, c + 1}).size();
    run = count >= least_.depth ? run + 1 : 0;
    depth = std::max(depth, run);
    if (count >= least_.surface) surface = c + 1;
  }
}

LocalId ActiveRows::find_max_columns() const {
  PerThread<LocalId> of_threads;
  for_each_row(rows_of({1, planes_ + 1}), [&](LocalId k, LocalId r) {
    LocalId& most = of_threads.mine();
    most = std::max(most, columns(k, r));
  });
  LocalId most = 0;
  of_threads.for_each([&](LocalId one) { most = std::max(most, one); });
  return most;
}

// One more than the highest value of the surrounding 3 x 3 rows.
void ActiveRows::spread(const std::vector<LocalId>& from, const CellRows& rows, std::vector<LocalId>& to) const {
  for_each_row(rows, [&](LocalId k, LocalId r) {
    LocalId highest = 0;
    for (LocalId i = std::max(k - 1, 0); i <= std::min(k + 1, planes_ + 1); ++i) {
      for (LocalId j = std::max(r - 1, -1); j <= std::min(r + 1, rows_); ++j)
        highest = std::max(highest, from[index(i, rows_wrap_ ? (j + rows_) % rows_ : j)]);
    }
    to[index(k, r)] = highest + 1;
  });
}

}  // namespace trevi

#include "projection/active_rows.hpp"

#include <algorithm>
#include <array>

#include "base/threads.hpp"
#include "parallel/waiting.hpp"

namespace trevi {

void ActiveRows::measure(const CellOrder& order, Halo& halo) {
  planes_ = order.planes();
  rows_ = order.grid().rows();
  rows_repeat_ = order.grid().is_periodic(1);
  for (auto* of_rows : {&surface_, &wet_, &near_}) of_rows->resize(index(planes_ + 2, 0));
  for (const LocalId ghosts : {0, planes_ + 1})  // where the box ends nothing is received
    std::fill_n(wet_.begin() + static_cast<std::ptrdiff_t>(index(ghosts, 0)), rows_, 0);
  PerThread<int> depth;
  for_each_row(rows_of({0, planes_ + 2}), [&](LocalId k, LocalId r) { look_at_row(order, k, r, depth.mine()); });
  spread(surface_, {1, planes_ + 1}, wet_);
  halo.start_planes(wet_, static_cast<std::size_t>(rows_));
  halo.finish();
  spread(wet_, {0, planes_ + 2}, near_);
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
    const LocalId cell = r * columns + c, count = order.start(k, cell + 1) - order.start(k, cell);
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

// One more than the highest of the 3 x 3 rows around.
void ActiveRows::spread(const std::vector<LocalId>& from, Range planes, std::vector<LocalId>& to) const {
  const LocalId beyond = rows_repeat_ ? 1 : 0;
  for_each_row(rows_of(planes), [&](LocalId k, LocalId r) {
    LocalId highest = 0;
    for (LocalId i = std::max(k - 1, 0); i <= std::min(k + 1, planes_ + 1); ++i) {
      for (LocalId j = std::max(r - 1, -beyond); j <= std::min(r + 1, rows_ - 1 + beyond); ++j)
        highest = std::max(highest, from[index(i, (j + rows_) % rows_)]);
    }
    to[index(k, r)] = highest + 1;
  });
}

}  // namespace trevi

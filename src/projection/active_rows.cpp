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
  for (auto* of_rows : {&surface_, &wet_, &near_}) of_rows->assign(index(planes_ + 2, 0), 0);
  PerThread<int> depth;
  for_each_part(planes_ + 2, [&](LocalId k) { look_at_plane(order, k, depth.mine()); });
  spread(surface_, {1, planes_ + 1}, wet_);
  halo.start_planes(wet_, static_cast<std::size_t>(rows_));
  halo.finish();
  spread(wet_, {0, planes_ + 2}, near_);
  std::array<LocalId, 2> most{};
  depth.for_each([&](int one) { most[0] = std::max(most[0], one); });
  for (LocalId k = 1; k <= planes_; ++k) {
    for (LocalId r = 0; r < rows_; ++r) most[1] = std::max(most[1], columns(k, r));
  }
  all_reduce(comm_, most.data(), 2, MPI_INT32_T, MPI_MAX);
  depth_ = most[0];
  max_columns_ = most[1];
}

void ActiveRows::look_at_plane(const CellOrder& order, LocalId k, int& depth) {
  const LocalId columns = order.grid().columns();
  for (LocalId r = 0; r < rows_; ++r) {
    int run = 0;
    for (LocalId c = 0; c < columns; ++c) {
      const LocalId cell = r * columns + c, count = order.start(k, cell + 1) - order.start(k, cell);
      run = count >= least_.depth ? run + 1 : 0;
      depth = std::max(depth, run);
      if (count >= least_.surface) surface_[index(k, r)] = c + 1;
    }
  }
}

// One more than the highest of the 3 x 3 rows around.
void ActiveRows::spread(const std::vector<LocalId>& from, Range planes, std::vector<LocalId>& to) const {
  for_each_part(planes, 1, [&](Range plane) {
    const LocalId k = plane.begin;
    const LocalId beyond = rows_repeat_ ? 1 : 0;
    for (LocalId r = 0; r < rows_; ++r) {
      LocalId highest = 0;
      for (LocalId i = std::max(k - 1, 0); i <= std::min(k + 1, planes_ + 1); ++i) {
        for (LocalId j = std::max(r - 1, -beyond); j <= std::min(r + 1, rows_ - 1 + beyond); ++j)
          highest = std::max(highest, from[index(i, (j + rows_) % rows_)]);
      }
      to[index(k, r)] = highest + 1;
    }
  });
}

}  // namespace trevi

#include "particles/cell_order.hpp"

#include <cassert>
#include <numeric>
#include <type_traits>

#include "base/growth.hpp"

namespace trevi {

void CellOrder::count(const Particles& particles, LocalId first) {
  counts_.assign(static_cast<std::size_t>(planes_) * cells(), 0);
  resize_tightly(cell_, particles.id.size());
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    const Vec3& p = particles.predicted[i];
    const LocalId plane = grid_.plane_of(p) - first;
    assert(plane >= 0 && plane < planes_);
    // 32 bits are enough for the cells of one rank: Slabs::check_capacity and Balance see to it.
    cell_[i] = static_cast<LocalId>(static_cast<std::size_t>(plane) * cells()) + grid_.cell_in_plane(p);
    ++counts_[static_cast<std::size_t>(cell_[i])];
  }
}

void CellOrder::find_order(const Particles& particles) {
  std::vector<LocalId>& next = start_;  // used as scratch here; add_ghosts() fills it with its real values
  next.resize(counts_.size() + 1);
  std::exclusive_scan(counts_.begin(), counts_.end(), next.begin(), 0);
  resize_tightly(order_, cell_.size());
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    order_[static_cast<std::size_t>(next[static_cast<std::size_t>(cell_[i])]++)] = static_cast<LocalId>(i);
  }
  // Within a cell by id: the order of arrival depends on the ranks, ids do not.
  const auto by_id = [&](LocalId a, LocalId b) {
    return particles.id[static_cast<std::size_t>(a)] < particles.id[static_cast<std::size_t>(b)];
  };
  auto begin = order_.begin();
  for (const LocalId n : counts_) {
    if (n > 1) std::sort(begin, begin + n, by_id);
    begin += n;
  }
}

template <class T>
void CellOrder::apply(std::vector<T>& field, std::vector<T>& scratch) const {
  resize_tightly(scratch, field.size());
  for (std::size_t i = 0; i < field.size(); ++i) scratch[i] = field[static_cast<std::size_t>(order_[i])];
  std::swap(scratch, field);
}

void CellOrder::sort(Particles& particles, const Planes& planes, Velocities velocities) {
  planes_ = planes.last - planes.first;
  owned_ = particles.size();
  count(particles, planes.first);
  find_order(particles);
  std::vector<Vec3> own;
  std::vector<Vec3>& vectors = velocities == Velocities::overwritten ? particles.velocity : own;
  particles.for_each_kept_field([&]<class T>(std::vector<T>& field) {
    if constexpr (std::is_same_v<T, Vec3>) {
      apply(field, vectors);
    } else {
      apply(field, std::get<std::vector<T>>(scratch_));
    }
  });
  if (velocities == Velocities::kept) apply(particles.velocity, own);
}

std::span<const LocalId> CellOrder::first_plane_counts() const { return {counts_.data(), cells()}; }

std::span<const LocalId> CellOrder::last_plane_counts() const {
  return {counts_.data() + (static_cast<std::size_t>(planes_) - 1) * cells(), cells()};
}

void CellOrder::add_ghosts(std::span<const LocalId> low_counts, std::span<const LocalId> high_counts) {
  start_.assign((static_cast<std::size_t>(planes_) + 2) * cells() + 1, 0);
  // Counts are stored one place further on, so that the partial sums are the starts.
  std::copy(low_counts.begin(), low_counts.end(), start_.begin() + 1);
  std::copy(counts_.begin(), counts_.end(), start_.begin() + 1 + static_cast<std::ptrdiff_t>(cells()));
  std::copy(high_counts.begin(), high_counts.end(),
            start_.begin() + 1 + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(planes_) + 1) * cells()));
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  low_ghosts_ = start(1, 0);
  high_ghosts_ = start_.back() - low_ghosts_ - owned_;
}

Range CellOrder::owned_range(LocalId k, LocalId l) const {
  return {start(k + 1, 0) - low_ghosts_, start(l + 1, 0) - low_ghosts_};
}

std::size_t CellOrder::bytes() const {
  std::size_t bytes = (counts_.capacity() + start_.capacity() + cell_.capacity() + order_.capacity()) * sizeof(LocalId);
  std::apply([&](const auto&... field) { ((bytes += field.capacity() * sizeof(field[0])), ...); }, scratch_);
  return bytes;
}

}  // namespace trevi

#include "projection/row_storage.hpp"

#include <algorithm>
#include <utility>

namespace trevi {

namespace {

constexpr LocalId four = FourCells::count;

}  // namespace

void RowStorage::lay_out(const Shape& shape, const CellOrder& order, std::span<const LocalId> columns) {
  shape_ = shape;
  const CellRows& cells = shape_.cells;
  whole_ = static_cast<std::size_t>(cells.columns + four - 1) / four;
  const std::size_t rows = row_index(cells.planes.end, -1);
  places_.resize(rows * whole_);
  held_.resize(rows * whole_);
  begin_.assign(rows, 0);
  for_each_row(cells, [&](LocalId k, LocalId r) { find_held(order, k, r, columns[row_index(k, r)]); });
  place_exchanged();
  for_each_row(cells, [&](LocalId k, LocalId r) {
    for (std::size_t f = 0; f < whole_; ++f) begin_[row_index(k, r)] += is_needed(k, r, f) ? 1U : 0U;
  });
  find_begins();
  for_each_row(cells, [&](LocalId k, LocalId r) { place_row(k, r); });
}

// From the number of groups of four that each row needs.
void RowStorage::find_begins() {
  std::uint32_t next = nowhere_ + 1;
  std::vector<std::uint32_t> shared(static_cast<std::size_t>(shape_.window), 0);  // largest need of a plane
  const auto rows_of = [&](LocalId k) {
    return std::span(begin_).subspan(row_index(k, -1), static_cast<std::size_t>(shape_.cells.rows) + 2);
  };
  for (LocalId k = 0; k < shape_.cells.planes.end; ++k) {
    std::uint32_t in_plane = 0;
    for (std::uint32_t& begin : rows_of(k)) in_plane += std::exchange(begin, is_shared(k) ? in_plane : next + in_plane);
    if (is_shared(k)) {
      std::uint32_t& most = shared[static_cast<std::size_t>(k % shape_.window)];
      most = std::max(most, in_plane);
    } else {
      next += in_plane;
    }
  }
  for (std::uint32_t& begin : shared) next += std::exchange(begin, next);
  for (LocalId k = 0; k < shape_.cells.planes.end; ++k) {
    if (!is_shared(k)) continue;
    for (std::uint32_t& begin : rows_of(k)) begin += shared[static_cast<std::size_t>(k % shape_.window)];
  }
  size_ = next;
}

void RowStorage::place_exchanged() {
  const LocalId planes = shape_.cells.planes.end;
  nowhere_ = 0;
  planes_.assign(static_cast<std::size_t>(planes), {});
  for (LocalId k = 0; k < planes; ++k)
    if (is_exchanged(k)) place_exchanged_plane(k);
  for (LocalId k = 0; k < planes; ++k) place_whole_rows(k);
  for (LocalId k = 0; k < planes; ++k) {
    for (const LocalId r : {-1, shape_.cells.rows})
      if (!are_cut() || !is_exchanged(k, r)) std::fill_n(&places_[row_index(k, r) * whole_], whole_, nowhere_);
    if (!is_exchanged(k) || are_cut()) continue;
    for (LocalId r = 0; r < shape_.cells.rows; ++r) {
      for (std::size_t f = 0; f < whole_; ++f)
        if (!is_held(k, r, f, true)) places_[row_index(k, r) * whole_ + f] = nowhere_;
    }
  }
}

void RowStorage::place_exchanged_plane(LocalId k) {
  const std::size_t before = nowhere_;
  const LocalId ring = are_cut() ? 1 : 0;
  for (LocalId r = -ring; r < shape_.cells.rows + ring; ++r) {
    for (std::size_t f = 0; f < whole_; ++f)
      if (are_cut() || is_held(k, r, f, true)) places_[row_index(k, r) * whole_ + f] = nowhere_++;
  }
  planes_[static_cast<std::size_t>(k)] = {before, nowhere_ - before};
}

void RowStorage::place_whole_rows(LocalId k) {
  if (is_exchanged(k) || !are_cut()) return;
  for (LocalId r = -1; r <= shape_.cells.rows; ++r) {
    for (std::size_t f = 0; f < whole_ && is_exchanged(k, r); ++f) places_[row_index(k, r) * whole_ + f] = nowhere_++;
  }
}

// In exchanged planes all columns are considered, because that is what both ranks know.
void RowStorage::find_held(const CellOrder& order, LocalId k, LocalId r, LocalId columns) {
  char* const held = &held_[row_index(k, r) * whole_];
  std::fill_n(held, whole_, 0);
  const LocalId all = shape_.cells.columns, first = r * order.grid().columns();
  const bool beside_it = shape_.beside || is_exchanged(k);
  if (is_exchanged(k)) columns = all;
  for (LocalId c = 0; c < columns; ++c) {
    if (order.start(k, first + c) == order.start(k, first + c + 1)) continue;
    held[c / four] = 1;
    for (const LocalId beside : {c - 1, c + 1}) {
      if (beside_it) held[(shape_.repeats[2] ? (beside + all) % all : std::clamp(beside, 0, all - 1)) / four] = 1;
    }
  }
}

// Whether a cell of the group holds particles, or with `beside` a cell next to the group in its plane.
bool RowStorage::is_held(LocalId k, LocalId r, std::size_t f, bool beside) const {
  if (!beside) return held_[row_index(k, r) * whole_ + f] != 0;
  const LocalId rows = shape_.cells.rows, beyond = shape_.repeats[1] && !are_cut() ? 1 : 0;
  for (LocalId row = std::max(r - 1, -beyond); row <= std::min(r + 1, rows - 1 + beyond); ++row)
    if (held_[row_index(k, (row + rows) % rows) * whole_ + f] != 0) return true;
  return false;
}

void RowStorage::place_row(LocalId k, LocalId r) {
  if (is_exchanged(k, r)) return;
  std::uint32_t next = begin_[row_index(k, r)];
  std::uint32_t* const places = &places_[row_index(k, r) * whole_];
  for (std::size_t f = 0; f < whole_; ++f) places[f] = is_needed(k, r, f) ? next++ : nowhere_;
}

}  // namespace trevi

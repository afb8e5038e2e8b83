#include "io/frames/visible.hpp"

#include <algorithm>
#include <cmath>

#include "base/hash.hpp"

namespace trevi {

namespace {

constexpr Real max_cells = 2e6;

// Keeps a mark where both neighbours along an axis are marked, too; beyond the ends there is none. A run of `count`
// cells, `stride` apart, goes along the axis; contiguous cells are processed together.
void erode(std::vector<std::uint8_t>& marks, std::size_t stride, std::size_t count) {
  const std::vector<std::uint8_t> old = marks;
  const std::size_t block = stride * count;
  for (std::size_t first = 0; first < marks.size(); first += block) {
    std::uint8_t* to = marks.data() + first;
    const std::uint8_t* from = old.data() + first;
    for (std::size_t k = stride; k + stride < block; ++k) to[k] = from[k - stride] & from[k] & from[k + stride];
    std::fill(to, to + stride, std::uint8_t{0});
    std::fill(to + block - stride, to + block, std::uint8_t{0});
  }
}

}  // namespace

VisibleCells::VisibleCells(const Box& box, Real size) : min_(box.min) {
  const Vec3 extent = box.max - box.min;
  per_metre_ = 1 / std::max(size, std::cbrt(extent.prod() / max_cells));
  std::ptrdiff_t cells = 1;
  for (int a = 0; a < 3; ++a) {
    count_[static_cast<std::size_t>(a)] = std::max<std::ptrdiff_t>(1, std::lround(std::ceil(extent[a] * per_metre_)));
    cells *= count_[static_cast<std::size_t>(a)];
  }
  marks_.assign(static_cast<std::size_t>(cells), 0);
}

std::size_t VisibleCells::cell_of(const Vec3& p) const {
  std::ptrdiff_t cell = 0;
  for (int a = 2; a >= 0; --a) {
    const std::ptrdiff_t count = count_[static_cast<std::size_t>(a)];
    // In double first: a particle of a file may be anywhere, or nowhere (nan becomes 0).
    const Real index = std::floor((p[a] - min_[a]) * per_metre_);
    cell = cell * count + (index > 0 ? static_cast<std::ptrdiff_t>(std::min(index, static_cast<Real>(count - 1))) : 0);
  }
  return static_cast<std::size_t>(cell);
}

void VisibleCells::mark(const Vec3& p) { marks_[cell_of(p)] = 1; }

void VisibleCells::find_hidden() {
  hidden_ = marks_;
  // All 26 neighbours are marked if three passes along the axes keep the mark.
  std::size_t stride = 1;
  for (const std::ptrdiff_t count : count_) {
    erode(hidden_, stride, static_cast<std::size_t>(count));
    stride *= static_cast<std::size_t>(count);
  }
}

int thinning_level(std::int64_t count, std::int64_t budget) {
  int level = 0;
  while (level < 62 && (count >> level) > std::max<std::int64_t>(budget, 1)) ++level;
  return level;
}

bool drawn_at(GlobalId id, int level) {
  return (mix(static_cast<std::uint64_t>(id)) & ((std::uint64_t{1} << level) - 1)) == 0;
}

}  // namespace trevi

#include "boundary/volume_map/volume_map.hpp"

#include <algorithm>
#include <cmath>

#include "boundary/volume_map/spline.hpp"

namespace trevi {

namespace {

// The mean of the kernel over a cell that begins at `corner`, from 4³ points because its peak is sharp. Of a kernel in
// the plane across coordinate `along`, only the cells on both sides of this plane have any.
Real mean_over_cell(const Kernel& kernel, const Vec3& corner, Real size, Real h, std::optional<Eigen::Index> along) {
  constexpr int parts = 4;
  Real sum = 0;
  if (along && (corner[*along] > 0.5 * size || corner[*along] < -1.5 * size)) return 0;
  for (int k = 0; k < parts * parts * parts; ++k) {
    Vec3 place(k % parts + 0.5, k / parts % parts + 0.5, k / parts / parts + 0.5);
    place = corner + size / parts * place;
    if (along) place[*along] = 0;
    sum += kernel.value(place, h);
  }
  return sum / (parts * parts * parts);
}

}  // namespace

Real VolumeMap::min_bytes(const Box& bounds, Real h) {
  const Real brick = LazyBlocks<Nodes>::edge * block * h / (static_cast<Real>(reach) / fine);
  return 2 * sizeof(void*) * ((bounds.max - bounds.min).array() / brick + 1).prod();
}

// The outermost blocks are as far from the surface as is ever needed.
VolumeMap::VolumeMap(const Shape& shape, const Kernel& kernel, Real h, const std::optional<Fixed>& fixed)
    : shape_(shape),
      fixed_(fixed),
      h_(h),
      node_(h / (static_cast<Real>(reach) / fine)),
      vessel_(shape.distance(shape.bounds().max + Vec3::Constant(h)) < 0),
      plane_(kernel, h),
      low_(shifted_place(block_place(shape.bounds().min, block * node_), -2)),
      high_(shifted_place(block_place(shape.bounds().max, block * node_), 3)),
      cells_(shifted_place(low_, -1), shifted_place(high_, 1)),
      nodes_(low_, high_) {
  weigh_cells(kernel);
}

void VolumeMap::weigh_cells(const Kernel& kernel) {
  const std::optional<Eigen::Index> along = kernel.dimensions == 2 ? shape_.extruded_along() : std::nullopt;
  Real sum = 0;
  for (int z = -reach; z < reach; ++z) {
    for (int y = -reach; y < reach; ++y) {
      for (int x = -reach; x < reach; ++x) {
        const Real w = mean_over_cell(kernel, node_ / fine * Vec3(x, y, z), node_ / fine, h_, along);
        if (w <= 0) continue;
        const int column = x + reach, row = (z + reach) * window + y + reach;
        weights_.push_back({static_cast<std::size_t>(column % 2), row * (window / 2) + column / 2, w});
        sum += w;
      }
    }
  }
  for (Weight& one : weights_) one.weight /= sum;
}

// Clamping to the box increases no distance, so that it remains a safe one. Positions are clamped to slightly inside
// the box, because the face on which a solid stands would otherwise count as half solid.
Real VolumeMap::solid_distance(const Vec3& p) const {
  if (!fixed_) return shape_.distance(p);
  const Vec3 world = fixed_->pose.into_world(p);
  const Vec3 gap = Vec3::Constant(h_ / 32);
  const Vec3 in_box = world.cwiseMax(fixed_->box.min + gap).cwiseMin(fixed_->box.max - gap);
  return shape_.distance(in_box == world ? p : fixed_->pose.into_body(in_box));
}

// For a cube that the surface meets: in 27 parts, each treated as if cut by a plane.
Real VolumeMap::cut_fraction(const Vec3& middle, Real size) const {
  constexpr int parts = 3;
  Real sum = 0;
  for (int z = 0; z < parts; ++z) {
    for (int y = 0; y < parts; ++y) {
      for (int x = 0; x < parts; ++x) {
        const Vec3 p = middle + size / parts * Vec3(x - 1, y - 1, z - 1);
        sum += std::clamp(0.5 - solid_distance(p) * parts / size, 0.0, 1.0);
      }
    }
  }
  return sum / (parts * parts * parts);
}

// In groups of 4³ cells, most of which the surface does not meet.
void VolumeMap::fill_cells(const Vec3& corner, Cells& cells) const {
  constexpr int group = 4;
  const Real cell = node_ / fine;
  cells.fraction.assign(edge * edge * edge, 0.0F);
  const auto middle = [&](int x, int y, int z, int count) {
    return Vec3(corner + cell * (Vec3(x, y, z) + Vec3::Constant(count / 2.0)));
  };
  for (int first = 0; first < edge * edge * edge; first += group * group * group) {
    const int number = first / (group * group * group), across = edge / group;
    const int x0 = number % across * group, y0 = number / across % across * group,
              z0 = number / across / across * group;
    const Real far = solid_distance(middle(x0, y0, z0, group));
    const bool whole = std::abs(far) > group * half_diagonal * cell;
    for (int k = 0; k < group * group * group; ++k) {
      const int x = x0 + k % group, y = y0 + k / group % group, z = z0 + k / group / group;
      const Vec3 here = middle(x, y, z, 1);
      const Real d = whole ? far : solid_distance(here);
      const Real fraction = std::abs(d) > half_diagonal * cell ? (d < 0 ? 1 : 0) : cut_fraction(here, cell);
      cells.fraction[static_cast<std::size_t>((z * edge + y) * edge + x)] = static_cast<float>(fraction);
    }
  }
}

std::unique_ptr<VolumeMap::Cells> VolumeMap::make_cells(const BlockPlace& place) const {
  auto cells = std::make_unique<Cells>();
  const Real size = block * node_;
  const Vec3 corner = corner_of(place, size);
  const Real far = solid_distance(corner + Vec3::Constant(size / 2));
  if (std::abs(far) > half_diagonal * size) {
    cells->kind = far < 0 ? Kind::full : Kind::empty;
    return cells;
  }
  cells->kind = Kind::cut;
  fill_cells(corner, *cells);
  return cells;
}

const VolumeMap::Cells& VolumeMap::cells_at(const BlockPlace& place) const {
  return cells_.at(place, [&] { return make_cells(place); });
}
const VolumeMap::Nodes& VolumeMap::nodes_at(const BlockPlace& place) const {
  return nodes_.at(place, [&] { return make_nodes(place); });
}

// Gathers the cells that the nodes of a block see; false if all of the surrounding blocks are empty, or all full.
bool VolumeMap::gather(const BlockPlace& place, Window& window_cells, Kind& kind) const {
  std::array<const Cells*, 27> around;
  for (int k = 0; k < 27; ++k) {
    const BlockPlace there{place[0] + k % 3 - 1, place[1] + k / 3 % 3 - 1, place[2] + k / 9 - 1};
    around[static_cast<std::size_t>(k)] = &cells_at(there);
  }
  kind = around[0]->kind;
  if (kind != Kind::cut && std::all_of(around.begin(), around.end(), [&](auto* one) { return one->kind == kind; }))
    return false;
  kind = Kind::cut;
  for (auto& half : window_cells) half.reserve(window * window * window / 2);
  constexpr int before = reach + fine;  // cells before the block's own that its first node sees
  for (int z = 0; z < window; ++z) {
    for (int y = 0; y < window; ++y) {
      for (int x = 0; x < window; ++x) {
        const int fx = x - before + edge, fy = y - before + edge, fz = z - before + edge;
        const Cells& from = *around[static_cast<std::size_t>((fz / edge * 3 + fy / edge) * 3 + fx / edge)];
        const int cell = (fz % edge * edge + fy % edge) * edge + fx % edge;
        const float fraction = from.kind == Kind::cut    ? from.fraction[static_cast<std::size_t>(cell)]
                               : from.kind == Kind::full ? 1.0F
                                                         : 0.0F;
        window_cells[static_cast<std::size_t>(x % 2)].push_back(static_cast<Real>(fraction));
      }
    }
  }
  return true;
}

// Near h, where the fraction says hardly anything any more, it is replaced by the distance of the surface.
Real VolumeMap::plane_distance(Real fraction, const Vec3& node) const {
  constexpr Real begin = 0.8;  // of h
  const Real d = plane_.distance(std::clamp(fraction, 0.0, 1.0));
  const Real t = (std::abs(d) / h_ - begin) / (1 - begin);
  if (t <= 0) return d;
  const Real surface = solid_distance(node), far = d > 0 ? std::max(surface, d) : std::min(surface, d);
  return d + t * t * (3 - 2 * t) * (far - d);
}

std::unique_ptr<VolumeMap::Nodes> VolumeMap::make_nodes(const BlockPlace& place) const {
  auto result = std::make_unique<Nodes>();
  Window cells;
  if (!gather(place, cells, result->kind)) return result;
  result->distance.reserve(nodes * nodes * nodes);
  const Vec3 corner = corner_of(place, block * node_);
  for (int z = 0; z < nodes; ++z) {
    for (int y = 0; y < nodes; ++y) {
      const std::ptrdiff_t row = (z * window + y) * fine * (window / 2);
      std::array<Real, nodes> fraction{};  // of all nodes of a row at once, in vectors
      for (const Weight& one : weights_) {
        const Real* from = cells[one.odd].data() + row + one.offset;
        for (std::size_t x = 0; x < nodes; ++x) fraction[x] += one.weight * from[x];
      }
      for (int x = 0; x < nodes; ++x)
        result->distance.push_back(
            plane_distance(fraction[static_cast<std::size_t>(x)], corner + node_ * Vec3(x - 1, y - 1, z - 1)));
    }
  }
  return result;
}

BlockPlace VolumeMap::block_of(const Vec3& p) const { return block_place(p, block * node_); }

bool VolumeMap::covers(const BlockPlace& place) const {
  bool inside = true;
  for (std::size_t a = 0; a < 3; ++a) inside = inside && place[a] >= low_[a] && place[a] < high_[a];
  return inside;
}

bool VolumeMap::is_near(const Vec3& p) const {
  const BlockPlace place = block_of(p);
  return covers(place) ? nodes_at(place).kind != Kind::empty : vessel_;
}

EquivalentPlane VolumeMap::at(const Vec3& p, Real flat) const {
  const BlockPlace place = block_of(p);
  if (!covers(place)) return {vessel_ ? -h_ : h_, Vec3::Zero(), vessel_};
  const Nodes& here = nodes_at(place);
  if (here.kind != Kind::cut) return {here.kind == Kind::full ? -h_ : h_, Vec3::Zero(), here.kind == Kind::full};
  return interpolated(here, (p - corner_of(place, block * node_)) / node_, flat);
}

EquivalentPlane VolumeMap::interpolated(const Nodes& here, const Vec3& in_nodes, Real flat) const {
  std::array<std::size_t, 3> cell;
  Vec3 t;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const int lower = std::clamp(static_cast<int>(in_nodes[a]), 0, block - 1);
    cell[static_cast<std::size_t>(a)] = static_cast<std::size_t>(lower);
    t[a] = in_nodes[a] - lower;
  }
  constexpr auto row = static_cast<std::size_t>(nodes), plane = row * row;
  const auto [value, slope] =
      interpolate({&here.distance[cell[2] * plane + cell[1] * row + cell[0]], row, plane}, t, flat);
  return {value, slope / node_};
}

}  // namespace trevi

// One record per particle as the pair loops read it: position and one scalar (lambda, |omega|) side by side, so that a
// neighbour costs one cache line. Records exist for ghosts, too; low ghosts, owned, high ghosts.
//
// Single precision stores a position as 32-bit integers in units of h / 2^22, counted from the box corner and wrapping
// around. The difference of two such numbers is exact whatever the size of the box, so that a pair has the same
// resolution of 2^-22 h near the corner and a kilometre away, and no rank has an origin of its own. (Neighbours that
// drift more than 512 h apart within a step would alias; the box of any run that gets there has exploded long before.)
// Double precision uses units of h.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

template <class T>
struct Packed;

template <>
struct alignas(16) Packed<float> {
  using Coordinate = std::int32_t;
  static constexpr Real units_per_h = 4194304;  // 2^22
  std::int32_t x, y, z;
  float w;
};

template <>
struct alignas(32) Packed<double> {
  using Coordinate = double;
  static constexpr Real units_per_h = 1;
  double x, y, z, w;
};

/// Conversion from metres to the units of the records.
template <class T>
class Encoding {
 public:
  Encoding(const Vec3& origin, Real h) : origin_(origin), per_metre_(Packed<T>::units_per_h / h) {}

  /// Divides `axis` into `cells` cells of a width that is h up to rounding, on which no difference of records depends.
  void count_cells(int axis, Real width, Real cells) {
    cells_[static_cast<std::size_t>(axis)] = {width, (1 + 0x1p-50) / width,
                                              std::ldexp(1.5, 52 - (48 - std::ilogb(cells)))};
    counts_cells_ = true;
  }
  bool counts_cells() const { return counts_cells_; }

  const Vec3& origin() const { return origin_; }
  Real per_metre() const { return per_metre_; }

  Packed<T> operator()(const Vec3& p, T w) const {
    const Vec3 u = (p - origin_) * per_metre_;
    return {coordinate(u.x()), coordinate(u.y()), coordinate(u.z()), w};
  }
  /// The same if axes are counted in cells: the position within a cell is rounded before the cells are added, exactly.
  Packed<T> in_cells(const Vec3& p, T w) const {
    Vec3 u = (p - origin_) * per_metre_;
    for (std::size_t a = 0; a < 3; ++a) {
      const Cells& cells = cells_[a];
      if (cells.width == 0) continue;
      const auto b = static_cast<Eigen::Index>(a);
      const Real offset = p[b] - origin_[b], cell = std::floor(offset * cells.per_metre);
      const Real within = (offset - cell * cells.width) / cells.width;
      u[b] = (cell + ((within + cells.rounding) - cells.rounding)) * Packed<T>::units_per_h;
    }
    return {coordinate(u.x()), coordinate(u.y()), coordinate(u.z()), w};
  }

 private:
  struct Cells {
    Real width = 0, per_metre = 0;
    Real rounding = 0;  // adding and subtracting it leaves as many bits as there is room for beside the cells
  };
  static typename Packed<T>::Coordinate coordinate(Real u) {
    if constexpr (std::is_same_v<T, float>) {
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::lrint(u)));
    } else {
      return u;
    }
  }

  Vec3 origin_;
  Real per_metre_;
  std::array<Cells, 3> cells_{};
  bool counts_cells_ = false;
};

/// Moves a record along one axis by this many of its units. Single precision wraps around, as its positions do.
inline void move(Packed<float>& record, int axis, Real units) {
  std::int32_t& x = axis == 0 ? record.x : axis == 1 ? record.y : record.z;
  x = static_cast<std::int32_t>(static_cast<std::uint32_t>(x) + static_cast<std::uint32_t>(std::llround(units)));
}
inline void move(Packed<double>& record, int axis, Real units) {
  (axis == 0 ? record.x : axis == 1 ? record.y : record.z) += units;
}

/// Four values per particle for other quantities that are read of neighbours, such as velocities.
template <class T>
struct alignas(4 * sizeof(T)) Vec4 {
  T x, y, z, w;
};

template <class T>
Vec3 vector_of(const Vec4<T>& q) {
  return Vec3(static_cast<Real>(q.x), static_cast<Real>(q.y), static_cast<Real>(q.z));
}

}  // namespace trevi

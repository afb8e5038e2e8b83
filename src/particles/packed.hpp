// One record per particle as the pair loops read it: position and one scalar (lambda, |omega|) side by side, so that a
// neighbour costs one cache line. Records exist for ghosts, too; low ghosts, owned, high ghosts.
//
// Single precision keeps a position as 32-bit integers in units of h / 2^22, counted from the box corner and wrapping
// around. The difference of two such numbers is exact whatever the size of the box, so that a pair has 2^-22 h of
// resolution near the corner and a kilometre away alike, and no rank has an origin of its own. (Neighbours that drift
// more than 512 h apart within a step would alias; the box of any run that gets there has exploded long before.) Double
// precision keeps units of h.
#pragma once

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

/// Metres to the units of the records.
template <class T>
class Encoding {
 public:
  Encoding(const Vec3& origin, Real h) : origin_(origin), per_metre_(Packed<T>::units_per_h / h) {}

  const Vec3& origin() const { return origin_; }
  Real per_metre() const { return per_metre_; }

  Packed<T> operator()(const Vec3& p, T w) const {
    const Vec3 u = (p - origin_) * per_metre_;
    return {coordinate(u.x()), coordinate(u.y()), coordinate(u.z()), w};
  }

 private:
  static typename Packed<T>::Coordinate coordinate(Real u) {
    if constexpr (std::is_same_v<T, float>) {
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(std::lrint(u)));
    } else {
      return u;
    }
  }

  Vec3 origin_;
  Real per_metre_;
};

/// Moves a record along one axis by so many of its units. Single precision wraps around, as its positions do.
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

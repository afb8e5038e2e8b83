// Six numbers for the motion of a rigid body: translation along x, y, z, then rotation about x, y, z; and symmetric 6 x
// 6 mass matrices. The order of sums is fixed: the same bits on any processor.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "trevi/types.hpp"

namespace trevi {

using Six = std::array<Real, 6>;
using Mass6 = std::array<Real, 36>;

inline Six six_of(const Vec3& along, const Vec3& about) {
  return {along.x(), along.y(), along.z(), about.x(), about.y(), about.z()};
}
inline Vec3 along_of(const Six& six) { return {six[0], six[1], six[2]}; }
inline Vec3 about_of(const Six& six) { return {six[3], six[4], six[5]}; }

inline Six plus(const Six& a, const Six& b, Real factor = 1) {
  Six sum{};
  for (std::size_t i = 0; i < 6; ++i) sum[i] = a[i] + factor * b[i];
  return sum;
}
inline Real dot(const Six& a, const Six& b) {
  Real sum = 0;
  for (std::size_t i = 0; i < 6; ++i) sum += a[i] * b[i];
  return sum;
}
inline Mass6 plus(const Mass6& a, const Mass6& b) {
  Mass6 sum{};
  for (std::size_t i = 0; i < 36; ++i) sum[i] = a[i] + b[i];
  return sum;
}
inline Six times(const Mass6& a, const Six& x) {
  Six product{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) product[i] += a[6 * i + j] * x[j];
  }
  return product;
}
/// a += factor x xᵀ.
inline void add_square(Mass6& a, const Six& x, Real factor) {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) a[6 * i + j] += factor * x[i] * x[j];
  }
}

/// The mass matrix of the same body in a rotated frame.
inline Mass6 turned(const Mass6& a, const Eigen::Matrix3d& turn) {
  Mass6 half{}, all{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      for (std::size_t k = 0; k < 3; ++k)
        half[6 * i + j] +=
            turn(static_cast<Eigen::Index>(i % 3), static_cast<Eigen::Index>(k)) * a[6 * (i / 3 * 3 + k) + j];
    }
  }
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      for (std::size_t k = 0; k < 3; ++k)
        all[6 * i + j] +=
            half[6 * i + j / 3 * 3 + k] * turn(static_cast<Eigen::Index>(j % 3), static_cast<Eigen::Index>(k));
    }
  }
  return all;
}

/// x with a x = b for the free numbers, and 0 for the others, by Cholesky factorization of the positive definite a.
inline Six solved(const Mass6& a, const Six& b, const std::array<bool, 6>& free) {
  Mass6 l{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      Real sum = free[i] && free[j] ? a[6 * i + j] : i == j ? 1 : 0;
      for (std::size_t k = 0; k < j; ++k) sum -= l[6 * i + k] * l[6 * j + k];
      l[6 * i + j] = i == j ? std::sqrt(sum > 1e-300 ? sum : 1e-300) : sum / l[6 * j + j];
    }
  }
  Six x{};
  for (std::size_t i = 0; i < 6; ++i) {
    Real sum = free[i] ? b[i] : 0;
    for (std::size_t k = 0; k < i; ++k) sum -= l[6 * i + k] * x[k];
    x[i] = sum / l[6 * i + i];
  }
  for (std::size_t i = 6; i-- > 0;) {
    Real sum = x[i];
    for (std::size_t k = i + 1; k < 6; ++k) sum -= l[6 * k + i] * x[k];
    x[i] = free[i] ? sum / l[6 * i + i] : 0;
  }
  return x;
}

}  // namespace trevi

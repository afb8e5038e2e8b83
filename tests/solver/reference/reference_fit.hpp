// Affine fits by brute force: weighted least squares over particles, solved by an orthogonal factorisation of the
// whole, tall matrix rather than by normal equations. Not collective.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "trevi/types.hpp"

namespace trevi::test {

/// u(y) = a + b y.
struct ReferenceFit {
  Real weight = 0;  ///< 1, or 0 where there is nothing to fit
  Vec3 a = Vec3::Zero();
  Eigen::Matrix3d b = Eigen::Matrix3d::Zero();
  Real held = 0;     ///< sum of the weights of what is fitted
  Real penalty = 0;  ///< of the slopes, in fit_of
  Real rest2 = 0;    ///< mean of u · (u − fit), with a fit without penalty the mean square of what it leaves

  Vec3 at(const Vec3& y) const { return a + b * y; }
};

struct Sample {
  Real weight;
  Vec3 y, u;
};

/// Least squares Σ w |u − a − b y|² + penalty |b|² Σ w: the variance of positions grows by it in each direction. What
/// it leaves out is fitted, too, `again` times (iterated Tikhonov regularisation).
inline ReferenceFit fit_of(const std::vector<Sample>& samples, Real penalty) {
  constexpr int again = 2;
  ReferenceFit fit;
  if (samples.empty()) return fit;
  const auto rows = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(rows + 3, 4), right = Eigen::MatrixXd::Zero(rows + 3, 3);
  Real total = 0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Sample& sample = samples[static_cast<std::size_t>(i)];
    left.row(i) << 1, sample.y.transpose();
    left.row(i) *= std::sqrt(sample.weight);
    right.row(i) = std::sqrt(sample.weight) * sample.u.transpose();
    total += sample.weight;
  }
  left.bottomRightCorner<3, 3>() = std::sqrt(penalty * total) * Eigen::Matrix3d::Identity();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> least_squares(left);
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(4, 3), rest = right;
  for (int k = 0; k <= again; ++k) {
    found += least_squares.solve(rest);
    rest.topRows(rows) = right.topRows(rows) - left.topRows(rows) * found;
  }
  fit.weight = 1;
  fit.held = total;
  fit.penalty = penalty;
  fit.a = found.row(0);
  fit.b = found.bottomRows<3>().transpose();
  fit.rest2 = std::max(right.cwiseProduct(rest).sum() / total, 0.0);
  return fit;
}

/// How flat the places lie: 0 where Σ 1/m, of their variances m along the principal axes, is 1/0.03 or less, 1 where it
/// is twice that. 1/m is what fit_of makes of it with the penalty 1e-3. In two dimensions y is no matter.
inline Real flatness_of(const std::vector<Sample>& samples, int dimensions) {
  constexpr Real penalty = 1e-3;
  Real total = 0, trace = 0;
  Vec3 mean = Vec3::Zero();
  for (const Sample& one : samples) {
    total += one.weight;
    mean += one.weight * one.y;
  }
  mean /= total;
  Eigen::Matrix3d variance = Eigen::Matrix3d::Zero();
  for (const Sample& one : samples) variance += one.weight / total * (one.y - mean) * (one.y - mean).transpose();
  if (dimensions == 2) {
    variance.row(1).setZero();
    variance.col(1).setZero();
    trace = -3 / penalty;  // what y adds
  }
  for (const Real m : Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(variance).eigenvalues()) {
    const Real left = penalty / (std::max(m, 0.0) + penalty);
    trace += left / penalty * (1 + left + left * left);
  }
  return std::clamp(0.03 * trace - 1, 0.0, 1.0);
}

}  // namespace trevi::test

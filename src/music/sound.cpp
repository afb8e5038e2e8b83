#include "music/sound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trevi {

namespace {

constexpr Real window_seconds = 0.04;
constexpr Real lowest_voice = 60, highest_voice = 1500;  // Hz
constexpr Real min_rate = 11025;                         // Hz, enough for the highest voice
constexpr Real periodic = 0.15;                          // YIN's threshold for a period, its authors' 0.1 to 0.15

/// Means of groups of samples: a lower sample rate, and less of the frequencies above it.
std::vector<Real> thinned(std::span<const float> samples, std::size_t group) {
  std::vector<Real> means(samples.size() / group, 0.0);
  for (std::size_t k = 0; k < means.size(); ++k) {
    for (std::size_t i = 0; i < group; ++i) means[k] += samples[k * group + i];
    means[k] /= static_cast<Real>(group);
  }
  return means;
}

/// YIN's difference d(lag) over its mean up to that lag: 1 if nothing repeats, 0 at a perfect period.
std::vector<Real> differences(const std::vector<Real>& x, std::size_t longest) {
  std::vector<Real> relative(longest + 1, 1.0);
  const std::size_t terms = x.size() - longest;
  Real sum = 0;
  for (std::size_t lag = 1; lag <= longest; ++lag) {
    Real d = 0;
    for (std::size_t i = 0; i < terms; ++i) d += (x[i] - x[i + lag]) * (x[i] - x[i + lag]);
    sum += d;
    if (sum > 0) relative[lag] = d * static_cast<Real>(lag) / sum;
  }
  return relative;
}

/// The minimum of the parabola through three points one apart, relative to the middle one.
Real bottom(Real left, Real middle, Real right) {
  const Real bend = left - 2 * middle + right;
  return bend > 0 ? 0.5 * (left - right) / bend : 0;
}

}  // namespace

Ear::Ear(Real rate) : rate_(rate), weights_(static_cast<std::size_t>(std::lround(window_seconds * rate))) {
  const Real count = static_cast<Real>(weights_.size());
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const Real phase = 2 * std::numbers::pi * (static_cast<Real>(i) + 0.5) / count;
    weights_[i] = static_cast<float>((1 - std::cos(phase)) / count);
  }
}

Real Ear::loudness(std::span<const float> samples) const {
  Real sum = 0;
  for (std::size_t i = 0; i < weights_.size(); ++i) sum += static_cast<Real>(weights_[i]) * samples[i] * samples[i];
  return std::sqrt(sum);
}

Real Ear::pitch(std::span<const float> samples) const {
  const auto group = static_cast<std::size_t>(std::max(1.0, std::floor(rate_ / min_rate)));
  const Real rate = rate_ / static_cast<Real>(group);
  const std::vector<Real> x = thinned(samples.first(weights_.size()), group);
  const auto shortest = static_cast<std::size_t>(std::max(2.0, std::floor(rate / highest_voice)));
  const auto longest = static_cast<std::size_t>(std::ceil(rate / lowest_voice));
  if (longest + 2 > x.size() || shortest >= longest) return NAN;
  const std::vector<Real> d = differences(x, longest);
  std::size_t lag = shortest;
  while (lag < longest && d[lag] >= periodic) ++lag;
  while (lag < longest && d[lag + 1] < d[lag]) ++lag;
  if (lag >= longest || !(d[lag] < periodic)) return NAN;
  const Real period = static_cast<Real>(lag) + bottom(d[lag - 1], d[lag], d[lag + 1]);
  // In steps of 1/4096 of a semitone, because the last bit of a logarithm differs between versions of the C library.
  return std::round(4096 * (69 + 12 * std::log2(rate / period / 440))) / 4096;
}

}  // namespace trevi

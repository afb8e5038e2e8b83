#include "boundary/waves/wave_theory.hpp"

#include <cmath>
#include <numbers>

#include "boundary/geometry/pose.hpp"
#include "boundary/waves/elementary.hpp"
#include "trevi/forcing.hpp"

namespace trevi {

namespace {

constexpr Real two_pi = 2 * std::numbers::pi;

}  // namespace

// Newton's method, starting from Eckart's approximation, which is within 5 %.
Real wave_number(Real omega, Real depth, Real gravity) {
  const Real deep = omega * omega * depth / gravity;
  Real kd = deep / std::sqrt(elementary::tanh(deep));
  constexpr int enough = 12;
  for (int n = 0; n < enough; ++n) {
    const Real t = elementary::tanh(kd);
    kd -= (kd * t - deep) / (t + kd * (1 - t * t));
  }
  return kd / depth;
}

// Hyperbolic functions divided by their largest term, so that deep water does not overflow.
Real biesel_transfer(PaddleKind kind, Real kd) {
  const Real e = elementary::exp(-2 * kd), e2 = e * e;
  const Real below = (1 - e2) / 2 + 2 * kd * e;  // (sinh 2kd + 2kd) e^(-2kd)
  if (kind == PaddleKind::piston) return 2 * ((1 + e2) / 2 - e) / below;
  const Real s = (1 - e) / 2, c = (1 + e) / 2, one = elementary::exp(-kd);  // each over e^kd
  return 4 * s / kd * (kd * s - c + one) / below;
}

// Modes e^(-k_j x) cos k_j z with x tan x = -kd tanh kd, x = k_j d between (j - 1/2) pi and j pi: each has sin x <f,
// Z>/<Z²> of the displacement, f being that of the face at a height over that at the surface, and Z the mode.
Real evanescent_transfer(PaddleKind kind, Real kd, Real strip) {
  constexpr int modes = 16, halvings = 50;
  const Real deep = kd * elementary::tanh(kd);
  Real sum = 0;
  for (int j = 1; j <= modes; ++j) {
    Real low = j / 2.0 - 0.25, high = j / 2.0;  // of x, in turns
    for (int n = 0; n < halvings; ++n) {
      const Real middle = (low + high) / 2;
      const auto [sine, cosine] = sine_cosine_of_turns(middle);
      // From -x cos j pi at the lower end to deep cos j pi at the upper one.
      ((two_pi * middle * sine + deep * cosine) * (j % 2 == 0 ? 1 : -1) < 0 ? low : high) = middle;
    }
    const Real x = two_pi * low;
    const auto [sine, cosine] = sine_cosine_of_turns(low);
    const Real face = kind == PaddleKind::piston ? sine : sine + (cosine - 1) / x;  // times x
    const Real mean = (1 - elementary::exp(-x * strip)) / (x * strip);
    sum += 4 * sine * face / (2 * x + 2 * sine * cosine) * mean;
  }
  return sum;
}

Real madsen_correction(Real height, Real kd, Real depth) {
  const Real s = elementary::sinh(kd), c = elementary::cosh(kd);
  return height * height / (32 * depth) * (3 * c / (s * s * s) - 2 / biesel_transfer(PaddleKind::piston, kd));
}

Real stokes_second_amplitude(Real height, Real k, Real depth) {
  const Real s = elementary::sinh(k * depth), c = elementary::cosh(k * depth);
  return k * height * height / 16 * c * (2 + elementary::cosh(2 * k * depth)) / (s * s * s);
}

// Grimshaw's equations for the level and the speed, and the integral of the level.
SolitaryWave::SolitaryWave(Real height, Real depth, Real gravity) : steepness(height / depth) {
  const Real e = steepness;
  kappa = std::sqrt(3 * e / 4) * (1 - 5 * e / 8 + 71 * e * e / 128) / depth;
  celerity = std::sqrt(gravity * depth * (1 + e - e * e / 20 - 3 * e * e * e / 70));
  a = e;
  b = -e * e / 4 - 17 * e * e * e / 80;
  c = 101 * e * e * e / 400;
}

// From T = −0.999 to 0.999, approximately.
Real SolitaryWave::duration() const {
  constexpr Real half_width = 3.8;
  return 2 / (kappa * celerity) * (half_width + steepness);
}

Real spectral_shape(WaveSpectrum spectrum, Real peak_enhancement, Real ratio) {
  const Real square = ratio * ratio, fifth = square * square * ratio;
  const Real shape = elementary::exp(-1.25 / (square * square)) / fifth;
  if (spectrum == WaveSpectrum::pierson_moskowitz) return shape;
  const Real sigma = ratio <= 1 ? 0.07 : 0.09, off = (ratio - 1) / sigma;
  return shape * elementary::exp(elementary::log(peak_enhancement) * elementary::exp(-off * off / 2));
}

namespace {

std::vector<PaddleComponent> regular(const WavemakerSettings& w) {
  const Real kd = wave_number(two_pi / w.period, w.depth, w.gravity) * w.depth;
  std::vector<PaddleComponent> motion{{w.height / biesel_transfer(w.kind, kd) / 2, 1 / w.period, 0}};
  if (w.second_order && w.kind == PaddleKind::piston)
    motion.push_back({madsen_correction(w.height, kd, w.depth), 2 / w.period, 0});
  return motion;
}

std::vector<PaddleComponent> irregular(const WavemakerSettings& w) {
  constexpr Real lowest = 0.5, highest = 2.5;  // of the peak's frequency
  constexpr int place = 0, phase = 1;          // streams of random numbers
  const Real width = (highest - lowest) / w.components;
  std::vector<PaddleComponent> waves;
  Real energy = 0;  // sum of a²/2, m²
  for (int n = 0; n < w.components; ++n) {
    const StepInfo number{n, 0, 0, 0};
    const Real ratio = lowest + width * (n + uniform(w.seed, 0, number, place));
    const Real amplitude = std::sqrt(spectral_shape(w.spectrum, w.peak_enhancement, ratio));
    waves.push_back({amplitude, ratio / w.period, uniform(w.seed, 0, number, phase)});
    energy += amplitude * amplitude / 2;
  }
  const Real scale = w.height / 4 / std::sqrt(energy);
  for (PaddleComponent& wave : waves) {
    const Real kd = wave_number(two_pi * wave.frequency, w.depth, w.gravity) * w.depth;
    wave.amplitude *= scale / biesel_transfer(w.kind, kd);
  }
  return waves;
}

}  // namespace

std::vector<PaddleComponent> paddle_components(const WavemakerSettings& wavemaker) {
  return wavemaker.wave == WaveKind::irregular ? irregular(wavemaker) : regular(wavemaker);
}

}  // namespace trevi

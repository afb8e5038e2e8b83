// Theory of waves on water of constant depth and of the paddles that make them. Pure functions of their arguments with
// the same bits on any processor (elementary.hpp). SI units. Sources: Biésel, La Houille Blanche 6 (1951); Madsen, J.
// Geophys. Res. 76 (1971); Goring, Caltech KH-R-38 (1978); Grimshaw, J. Fluid Mech. 46 (1971); Goda, Random seas and
// design of maritime structures. Not collective.
#pragma once

#include <vector>

#include "trevi/wavemaker.hpp"

namespace trevi {

/// Wave number k, 1/m, with omega² = g k tanh(k depth).
Real wave_number(Real omega, Real depth, Real gravity);

/// H/S of a paddle by Biésel: the height of a linear wave far away over the stroke. For a flap, which is hinged on the
/// floor, the stroke is that at the surface of the still water.
Real biesel_transfer(PaddleKind kind, Real k_depth);

/// The part of the level in front of a paddle that does not propagate away as a wave (evanescent modes), over the
/// displacement of the paddle at the surface: the mean over a strip from the face on, whose width is given in depths.
/// It is in phase with the displacement.
Real evanescent_transfer(PaddleKind kind, Real k_depth, Real strip_depths);

/// Amplitude of the term in sin 2 omega t that a piston with S/2 sin omega t needs in addition, so that no free wave of
/// twice the frequency accompanies a wave of height H (Madsen, equation 17).
Real madsen_correction(Real height, Real k_depth, Real depth);

/// Amplitude of the second harmonic of a Stokes wave, m.
Real stokes_second_amplitude(Real height, Real k, Real depth);

/// A third-order solitary wave (Grimshaw), in T = tanh(kappa (x − c t)).
struct SolitaryWave {
  SolitaryWave(Real height, Real depth, Real gravity);

  /// The displacement of the water from the middle of its path when the passing wave has this T there, m: the integral
  /// of eta/d along the wave.
  Real way(Real tanh) const {
    return (a * tanh + b * tanh * tanh * tanh + c * tanh * tanh * tanh * tanh * tanh) / kappa;
  }
  /// eta/d, which is d way/d x.
  Real level(Real tanh) const {
    const Real square = tanh * tanh;
    return (a + 3 * b * square + 5 * c * square * square) * (1 - square);
  }
  /// How long the paddle that makes it moves, s; stroke(): how far, m (Goring).
  Real duration() const;
  Real stroke() const { return 2 * way(1); }

  Real kappa;      ///< 1/m
  Real celerity;   ///< m/s
  Real steepness;  ///< H/d
  Real a, b, c;    ///< coefficients of T, T³ and T⁵ in kappa way
};

/// A component a sin(2 pi (frequency t + phase)) of the motion of a paddle at the surface of the still water.
struct PaddleComponent {
  Real amplitude;  ///< m
  Real frequency;  ///< Hz
  Real phase;      ///< turns
};

/// The motion of a paddle that makes regular or irregular waves. For irregular waves the spectrum from half to two and
/// a half times the peak frequency is divided into bands of equal width. Each has one component, at a random place in
/// the band and with a random phase; their energy is exactly H_m0²/16.
std::vector<PaddleComponent> paddle_components(const WavemakerSettings& wavemaker);

/// The spectral density of the surface, up to a factor, at a frequency given as a multiple of that of the peak.
Real spectral_shape(WaveSpectrum spectrum, Real peak_enhancement, Real ratio);

}  // namespace trevi

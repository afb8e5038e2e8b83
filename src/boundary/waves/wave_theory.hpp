// What linear and second-order theory say of waves on water of constant depth and of the paddles that make them. Pure
// functions of their arguments with the same bits on any processor (elementary.hpp). SI units. Sources: Biésel, La
// Houille Blanche 6 (1951); Madsen, J. Geophys. Res. 76 (1971); Goring, Caltech KH-R-38 (1978); Goda, Random seas and
// design of maritime structures. Not collective.
#pragma once

#include <vector>

#include "trevi/wavemaker.hpp"

namespace trevi {

/// k, 1/m, with omega² = g k tanh(k depth).
Real wave_number(Real omega, Real depth, Real gravity);

/// H/S of a paddle by Biésel: the height of a linear wave far away over the stroke, which for a flap is that at the
/// still water's surface; its hinge is on the floor.
Real biesel_transfer(PaddleKind kind, Real k_depth);

/// Of the level before a paddle over its displacement at the surface what does not go away as a wave (evanescent
/// modes), in the mean over a strip that is so many depths wide, from the face on. In phase with the displacement.
Real evanescent_transfer(PaddleKind kind, Real k_depth, Real strip_depths);

/// Amplitude of sin 2 omega t that a piston with S/2 sin omega t needs besides, so that no free wave of twice the
/// frequency goes with a wave of height H (Madsen, equation 17).
Real madsen_correction(Real height, Real k_depth, Real depth);

/// Amplitude of the second harmonic of a Stokes wave, m.
Real stokes_second_amplitude(Real height, Real k, Real depth);

/// kappa, 1/m, and celerity, m/s, of a solitary wave eta = H sech²(kappa (x − c t)) of first order.
struct SolitaryWave {
  Real kappa, celerity;
};
SolitaryWave solitary_wave(Real height, Real depth, Real gravity);

/// How long the paddle of a solitary wave moves, s, and how far, m (Goring).
Real solitary_duration(Real height, Real depth, Real gravity);
Real solitary_stroke(Real height, Real depth);

/// A part a sin(2 pi (frequency t + phase)) of the motion of a paddle at the surface of the still water.
struct PaddleComponent {
  Real amplitude;  ///< m
  Real frequency;  ///< Hz
  Real phase;      ///< turns
};

/// The motion of a paddle that makes regular or irregular waves. Of irregular ones each band of the spectrum of equal
/// width from half to two and a half times the peak's frequency has one component, at a random place in it and of
/// random phase; their energy is H_m0²/16 exactly.
std::vector<PaddleComponent> paddle_components(const WavemakerSettings& wavemaker);

/// The spectral density of the surface, up to a factor, at a frequency over that of the peak.
Real spectral_shape(WaveSpectrum spectrum, Real peak_enhancement, Real ratio);

}  // namespace trevi

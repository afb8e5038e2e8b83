// What a scene says about its physics, in the scene's own units (SI) and names, checked but not yet scaled.
// Plain data: the scene reader fills it, the scene builder hands each part to the object that needs it.
// Tables that are absent stay std::nullopt or empty, and then nothing is built for them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trevi/types.hpp"

namespace trevi {

enum class Mass { calibrated, volume };
enum class Kernel { poly6, spiky };
enum class Method { jacobi, chebyshev, anderson };
enum class Constraint { equality, inequality };
enum class Precision { single, double_ };
enum class WallDensity { none, analytic };
enum class Reflection { normal, report };
enum class MusicKind { score, midi, sound, live };
enum class Follow { pitch, loudness };
enum class SpeedMapping { linear, energy };

struct FluidSettings {
  Real spacing = 0.1;        ///< of the start lattice, m
  Real rest_density = 1000;  ///< kg/m³
  Real kernel_radius = 0.2;  ///< h, m
  Mass mass = Mass::calibrated;
  Kernel density_kernel = Kernel::spiky;  ///< of rho; gradients are Spiky's with either
  bool operator==(const FluidSettings&) const = default;
};

struct DensitySettings {
  Method method = Method::chebyshev;
  int iterations = 4;             ///< the coarse-grid correction counts as one; a sweep follows it at least
  std::optional<Real> tolerance;  ///< stop when mean compression is below it and the maximum below ten times it
  Real relaxation = 0.7;          ///< default: a share of what the kernel allows (lattice_jacobi_eigenvalue)
  Real spectral_radius = 0.95;    ///< chebyshev: assumed of the relaxed Jacobi iteration
  bool coarse_grid = true;        ///< the smooth part of the correction from the cell grid
  Real max_shift = 0.1;           ///< cap on what a pair is pushed apart in a sweep, in units of h; 0: none
  Real epsilon = 1;               ///< 1/m² at spacing 0.1
  Constraint constraint = Constraint::inequality;
  Precision precision = Precision::double_;
  bool operator==(const DensitySettings&) const = default;
};

struct WallSettings {
  Real restitution = 0.5;
  WallDensity density = WallDensity::analytic;
  Reflection reflection = Reflection::normal;
  Real floor_friction = 0;  ///< skin friction coefficient c_f of the floor; 0: none
  bool operator==(const WallSettings&) const = default;
};

struct TensileSettings {
  Real k = 0.001;  ///< m² at spacing 0.1
  int n = 4;
  Real dq = 0.2;  ///< in units of h
  bool operator==(const TensileSettings&) const = default;
};

struct MusicSettings {
  std::string source;                        ///< a file, or "-" for raw PCM on standard input
  MusicKind kind = MusicKind::score;         ///< by the ending of source
  Follow follow = Follow::pitch;             ///< what of it sets the speed; scores have a pitch only
  int track = 0, channel = 0;                ///< of a MIDI file, from 1; 0: all (but channel 10, the drums)
  int rate = 44100;                          ///< of raw PCM, Hz
  std::pair<Real, Real> speed_range{5, 10};  ///< m/s, for the lowest and highest note, or silence and the loudest
  SpeedMapping mapping = SpeedMapping::linear;
  bool operator==(const MusicSettings&) const = default;
};

struct FountainSettings {
  Real center[2] = {0, 0};             ///< m, on the floor
  Real diameter = 0.15, height = 0.2;  ///< m, upright cylinder on the floor
  Vec3 direction = Vec3::UnitZ();      ///< normalised
  Real speed = 10, jitter = 0;         ///< m/s; speed counts where there is no music
  Real start = 0, stop = 1e300;        ///< s
  std::optional<MusicSettings> music;
  int line = 0;  ///< of the table in the scene file, for later messages

  /// The highest speed without jitter, m/s.
  Real top_speed() const { return music ? music->speed_range.second : speed; }

  bool operator==(const FountainSettings&) const = default;
};

}  // namespace trevi

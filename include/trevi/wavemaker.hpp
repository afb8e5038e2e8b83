// A paddle across one end of a tank that makes waves, as a scene's [[wavemaker]] describes it (inputs/README.md,
// Wavemakers). Plain data in SI units.
#pragma once

#include <cstdint>

#include "trevi/types.hpp"

namespace trevi {

enum class PaddleKind { piston, flap };
enum class WaveKind { regular, irregular, solitary };
enum class WaveSpectrum { jonswap, pierson_moskowitz };

struct WavemakerSettings {
  PaddleKind kind = PaddleKind::piston;
  WaveKind wave = WaveKind::regular;
  Real height = 0;                 ///< m: H of a regular or a solitary wave, H_m0 of irregular ones
  Real period = 0;                 ///< s: T of regular waves, T_p of irregular ones; none of a solitary wave
  Real depth = 0;                  ///< m, of the still water in front of the paddle
  Real gravity = 9.8;              ///< m/s², downwards
  Vec3 direction = Vec3::UnitX();  ///< in which the waves go: along x or y, of length 1
  Real position = 0;               ///< m: where the face of the paddle is at rest along that axis
  Real floor = 0;                  ///< m: where a flap has its hinge
  Real ramp = 0;                   ///< s in which the motion grows to what it is
  bool second_order = true;        ///< piston, regular: Madsen's correction
  WaveSpectrum spectrum = WaveSpectrum::jonswap;
  Real peak_enhancement = 3.3;  ///< gamma of JONSWAP
  int components = 128;         ///< of irregular waves
  std::uint64_t seed = 1;       ///< of their phases

  /// Whether the paddle takes in waves that come back to it. Its place then depends on the water, and is state of a
  /// run.
  bool absorb = false;

  bool operator==(const WavemakerSettings&) const = default;
};

}  // namespace trevi

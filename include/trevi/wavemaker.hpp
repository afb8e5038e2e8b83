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
  Real period = 0;                 ///< s: T of regular waves, T_p of irregular ones; not used for a solitary wave
  Real depth = 0;                  ///< m, of the still water in front of the paddle
  Real gravity = 9.8;              ///< m/s², downwards
  Vec3 direction = Vec3::UnitX();  ///< of the waves: along x or y, of length 1
  Real position = 0;               ///< m: rest position of the face of the paddle along that axis
  Real floor = 0;                  ///< m: height of the hinge of a flap
  Real ramp = 0;                   ///< s: time in which the motion grows to its full amplitude
  bool second_order = true;        ///< piston, regular: Madsen's correction
  WaveSpectrum spectrum = WaveSpectrum::jonswap;
  Real peak_enhancement = 3.3;  ///< gamma of JONSWAP
  int components = 128;         ///< of irregular waves
  std::uint64_t seed = 1;       ///< of their phases

  /// Whether the paddle absorbs the waves that come back to it. Its position then depends on the water and is part of
  /// the state of a run.
  bool absorb = false;

  bool operator==(const WavemakerSettings&) const = default;
};

}  // namespace trevi

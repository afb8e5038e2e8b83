// Active absorption: paddles that absorb returning waves while they make waves. In each substep the mean level of the
// water in a strip in front of the paddle is measured. The excess over the level of the paddle's own waves is a
// returning wave, which the paddle absorbs by yielding to it: v = −eta omega/(H/S), the speed at which it would make
// such a wave, or sqrt(g/d) in shallow water (Schäffer & Klopman 2000). A returning wave reaches the middle of the
// strip before the paddle, by the travel time at its celerity, and the paddle's own waves reach it later by as much.
// The returning wave is therefore smoothed over that time. The strip moves with the face, forward where the paddle's
// own waves rise towards it. What it sees of their slope, k H S/8 on average, is not a returning wave, nor is the level
// that rises at a face that moves forward and stays there. The slow mean of the level is not a wave. It is subtracted,
// and the offset from the stroke of the own waves returns to 0 slowly, so that the paddle does not drift. The level is
// a sum of integers, so that it does not depend on the number of ranks or threads. Offset, smoothed level and slow mean
// are state and part of a checkpoint. Collective: move().
#pragma once

#include <vector>

#include "base/threads.hpp"
#include "boundary/obstacles/obstacles.hpp"
#include "boundary/waves/paddle_motion.hpp"
#include "trevi/forcing.hpp"

namespace trevi {

class ActiveAbsorption {
 public:
  /// `state`: that of the run that is continued, m; empty: 0.
  ActiveAbsorption(const Settings& settings, std::vector<Real> state);

  /// Whether any paddle absorbs.
  static bool is_wanted(const Settings& settings);
  /// Tells the obstacles the offsets of their paddles at the start.
  void place(Obstacles& obstacles) const;
  /// Tells the obstacles where their paddles are in the substep, before they move.
  void move(MPI_Comm comm, const Particles& particles, const StepInfo& info, Obstacles& obstacles);
  /// For the absorbing paddles in the order of the obstacles: the offset of each from the stroke of its own waves, then
  /// for each the smoothed level of the returning wave and its slow mean, m.
  const std::vector<Real>& state() const { return state_; }

 private:
  struct Paddle {
    std::size_t obstacle;
    WavemakerSettings maker;
    PaddleMotion motion;
    Real gain;       // 1/s, speed over level
    Real lag, seen;  // s, between strip and paddle; the share of the height of a wave in the mean over the strip
    Real slope;      // 1/m, of its own waves at the face over its displacement: k H/S; the strip moves along it
    Real beside;     // level over displacement that stays in front of it and is not a wave
    Real wide;       // m, width of the tank
    Real farthest;   // m, largest displacement by absorption, to either side
  };
  // `way`: displacement of the paddle at the still water surface, m.
  Real level_before(MPI_Comm comm, const Paddle& paddle, Real way, const Particles& particles);

  std::vector<Paddle> paddles_;
  std::vector<Real> state_;
  Real spacing_, strip_;  // m
  PerThread<std::vector<GlobalId>> sums_;
};

}  // namespace trevi

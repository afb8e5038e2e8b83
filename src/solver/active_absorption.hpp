// Paddles that absorb what comes back to them while they make waves. In each substep the mean level of the water in
// a strip before the paddle is measured; what it has above the level of the paddle's own waves is a wave that comes
// back, which the paddle takes in by going with it: v = −eta omega/(H/S), the speed at which it would make such a
// wave, or sqrt(g/d) in shallow water (Schäffer & Klopman 2000). The middle of the strip sees a wave earlier than
// the paddle, by the way at its celerity, and its own waves later by as much, so what comes back is smoothed over
// that time. It goes with the face, forward where its own waves rise towards it: what it sees of their slope, k H S/8
// in the mean, is no wave that comes back, nor is what rises beside a face that goes forward and stays there. The slow
// mean of the level is no wave; it is left out, and the offset from the stroke of its own waves returns to 0 slowly, so
// that the paddle does not drift. The level is a sum of integers, so that no number of ranks or threads is seen in it;
// offset, smoothed level and slow mean are state, which a checkpoint has. Collective: move().
#pragma once

#include <vector>

#include "base/threads.hpp"
#include "boundary/obstacles/obstacles.hpp"
#include "boundary/waves/paddle_motion.hpp"
#include "trevi/forcing.hpp"

namespace trevi {

class ActiveAbsorption {
 public:
  /// `state`: of the run that goes on, m; empty: 0.
  ActiveAbsorption(const Settings& settings, std::vector<Real> state);

  /// Whether any paddle absorbs.
  static bool is_wanted(const Settings& settings);
  /// Tells the obstacles the offsets of their paddles at the start.
  void place(Obstacles& obstacles) const;
  /// Tells the obstacles where their paddles are in the substep, before they move.
  void move(MPI_Comm comm, const Particles& particles, const StepInfo& info, Obstacles& obstacles);
  /// Of the absorbing paddles in the order of the obstacles the offset of each from the stroke of its own waves, then
  /// of each the smoothed level of what comes back and its slow mean, m.
  const std::vector<Real>& state() const { return state_; }

 private:
  struct Paddle {
    std::size_t obstacle;
    WavemakerSettings maker;
    PaddleMotion motion;
    Real gain;       // 1/s, of the speed over the level
    Real lag, seen;  // s, between the strip and the paddle; of the height of a wave, what the mean over the strip has
    Real slope;      // 1/m, of its own waves at the face over its way: k H/S; the strip goes up and down it
    Real beside;     // of the level over its way, what stays before it and is no wave
    Real wide;       // m, of the tank across
    Real farthest;   // m, that it may go by absorbing, to either side
  };
  // `way`: of the paddle at the surface of the still water, m.
  Real level_before(MPI_Comm comm, const Paddle& paddle, Real way, const Particles& particles);

  std::vector<Paddle> paddles_;
  std::vector<Real> state_;
  Real spacing_, strip_;  // m
  PerThread<std::vector<GlobalId>> sums_;
};

}  // namespace trevi

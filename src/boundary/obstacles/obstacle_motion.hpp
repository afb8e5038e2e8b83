// Moves the obstacles at the start of each substep, and begins toll and gauges anew with each step. No particle is
// changed: obstacles act on water where it meets them. Not collective.
#pragma once

#include <memory>

#include "boundary/obstacles/obstacles.hpp"
#include "trevi/forcing.hpp"

namespace trevi {

class ObstacleMotion : public Forcing {
 public:
  explicit ObstacleMotion(std::shared_ptr<Obstacles> obstacles) : obstacles_(std::move(obstacles)) {}
  void prepare(const StepInfo&) override {
    obstacles_->toll().clear();
    obstacles_->gauges().clear();
  }
  void apply(Particles&, const StepInfo& info) override { obstacles_->move(info.time, info.time + info.dt); }
  Real fastest(const TimeSpan& span) const override { return obstacles_->fastest(span.begin, span.end); }

 private:
  std::shared_ptr<Obstacles> obstacles_;
};

}  // namespace trevi

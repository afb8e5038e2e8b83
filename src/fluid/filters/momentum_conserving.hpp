// A filter that keeps no momentum, made to: what it adds to the momentum of all water is taken from all particles
// alike, so that their sum stays to rounding. (Angular momentum is not kept.) Collective.
#pragma once

#include "fluid/filters/velocity_filter.hpp"

namespace trevi {

template <class T>
class MomentumConserving : public VelocityFilter<T> {
 public:
  MomentumConserving(MPI_Comm comm, std::unique_ptr<VelocityFilter<T>> filter)
      : comm_(comm), filter_(std::move(filter)) {}
  void apply(Neighbourhood<T>& near, Particles& particles, Real dt) override;

 private:
  Borrowed<Vec3> copy_of(const std::vector<Vec3>& velocity, Scratch& scratch) const;
  Vec3 mean_change(const CellOrder& order, const Borrowed<Vec3>& before, const std::vector<Vec3>& velocity) const;

  Event event_{"Projection"};
  MPI_Comm comm_;
  std::unique_ptr<VelocityFilter<T>> filter_;
};

extern template class MomentumConserving<float>;
extern template class MomentumConserving<double>;

}  // namespace trevi

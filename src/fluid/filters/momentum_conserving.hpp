// Makes a filter that does not conserve momentum conserve it: what the filter adds to the momentum of all water is
// subtracted from all particles equally, so that their sum is unchanged to rounding. (Angular momentum is not
// conserved.) Collective.
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

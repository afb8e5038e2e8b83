// What smooths or stirs velocities after the density solve, on the frozen neighbour list (report, section 2.3): one
// file for each filter. A filter reads only the velocities the one before left, never half-updated ones. It refreshes
// the ghosts it reads and uses the scalar of the records as it likes. Collective.
#pragma once

#include <memory>

#include "domain/neighbourhood.hpp"
#include "fluid/density.hpp"

namespace trevi {

template <class T>
class VelocityFilter {
 public:
  virtual ~VelocityFilter() = default;
  virtual void apply(Neighbourhood<T>& near, Particles& particles, Real dt) = 0;
  virtual std::size_t bytes() const = 0;
};

/// Velocities of all particles, ghosts included, as the pair loops read them. Filters share one: each refreshes it.
template <class T>
class VelocityField {
 public:
  /// Collective.
  const Vec4<T>* refresh(Neighbourhood<T>& near, const std::vector<Vec3>& velocity);
  std::size_t bytes() const { return vectors_.capacity() * sizeof(Vec4<T>); }

 private:
  std::vector<Vec4<T>> vectors_;
};

/// What one of the filters that share a field answers for.
template <class T>
std::size_t share_of(const std::shared_ptr<VelocityField<T>>& field) {
  return field->bytes() / static_cast<std::size_t>(field.use_count());
}

/// What the pair loops read.
template <class T>
Pairs<T> pairs_of(const Neighbourhood<T>& near) {
  return {near.records(), near.list(), near.order().low_ghosts()};
}

extern template class VelocityField<float>;
extern template class VelocityField<double>;

}  // namespace trevi

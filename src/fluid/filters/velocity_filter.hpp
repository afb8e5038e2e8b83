// Filters change velocities after the density solve, on the neighbour list of the substep (Macklin & Müller 2013, eqs.
// 15 to 17); each has its own file. A filter reads only velocities that the one before has completed. It refreshes the
// ghosts that it reads and may overwrite the scalar of the records. Collective.
#pragma once

#include <memory>

#include "domain/neighbourhood.hpp"
#include "fluid/constraint/density.hpp"

namespace trevi {

template <class T>
class VelocityFilter {
 public:
  virtual ~VelocityFilter() = default;
  virtual void apply(Neighbourhood<T>& near, Particles& particles, Real dt) = 0;
  virtual std::size_t bytes() const = 0;
};

/// Velocities of all particles, ghosts included, in the form that the pair loops read. All filters share one field;
/// each refreshes it before use.
template <class T>
class VelocityField {
 public:
  /// write() and an exchange of the velocities, whose scalars are not for use. Collective.
  const Vec4<T>* refresh(Neighbourhood<T>& near, const std::vector<Vec3>& velocity);
  /// Those of the owned particles, in their order, with a scalar of 0 that may be set before exchange().
  Vec4<T>* write(const Neighbourhood<T>& near, const std::vector<Vec3>& velocity);
  /// Collective.
  const Vec4<T>* exchange(Neighbourhood<T>& near);
  std::size_t bytes() const { return vectors_.capacity() * sizeof(Vec4<T>); }

 private:
  std::vector<Vec4<T>> vectors_;
};

/// Fraction of the field's memory, bytes, that each of the filters that share it reports.
template <class T>
std::size_t contribution_of(const std::shared_ptr<VelocityField<T>>& field) {
  return field->bytes() / static_cast<std::size_t>(field.use_count());
}

/// The input of a pair loop.
template <class T>
Pairs<T> pairs_of(const Neighbourhood<T>& near) {
  return {near.records(), near.list(), near.order().low_ghosts()};
}

/// What so many passes over all pairs read and write, as log_work() takes it: lists, records, velocities, sums.
template <class T>
double bytes_of_passes(const Neighbourhood<T>& near, int passes) {
  const double each = sizeof(Packed<T>) + 2 * sizeof(Vec4<T>);
  return passes * (near.list().bytes_read(near.all()) + each * near.all().size());
}

extern template class VelocityField<float>;
extern template class VelocityField<double>;

}  // namespace trevi

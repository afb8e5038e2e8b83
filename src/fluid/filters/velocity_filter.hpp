// Filters change velocities after the density solve, on the neighbour list of the substep (Macklin & Müller 2013, eqs.
// 15 to 17); each has its own file. A filter reads only velocities that the one before has completed. It refreshes the
// ghosts that it reads and may overwrite the scalar of the records. Arrays are borrowed from near.scratch().
// Collective.
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
};

/// Velocities of the owned particles, in their order, in the form that the pair loops read, with a scalar of 0 that may
/// be set before an exchange.
template <class T>
Borrowed<Vec4<T>> own_velocities(const Neighbourhood<T>& near, const std::vector<Vec3>& velocity);
/// The velocities of all particles, ghosts included; the scalars of ghosts must not be used. Collective.
template <class T>
Borrowed<Vec4<T>> all_velocities(Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  Borrowed<Vec4<T>> velocities = own_velocities(near, velocity);
  near.exchange_vectors(velocities);
  return velocities;
}

/// The input of a pair loop.
template <class T>
Pairs<T> pairs_of(const Neighbourhood<T>& near) {
  return {near.records(), near.list(), near.order().low_ghosts()};
}

/// Bytes that this many passes over all pairs read and write, as log_work() takes them: lists, records, velocities,
/// sums.
template <class T>
double bytes_of_passes(const Neighbourhood<T>& near, int passes) {
  const double each = sizeof(Packed<T>) + 2 * sizeof(Vec4<T>);
  return passes * (near.list().bytes_read(near.all()) + each * near.all().size());
}

}  // namespace trevi

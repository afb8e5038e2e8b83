// The vectorised loops over particles between the pair loops: from sums to multipliers, from shifts to positions and
// records. Each particle is processed separately, with the same operations on every processor. Lengths in metres. Not
// collective, on this thread.
#pragma once

#include <array>
#include <span>

#include "boundary/obstacles/open_space.hpp"
#include "particles/packed.hpp"

namespace trevi {

/// lambda = −C / (slope2 (|Σ g r̂|² + Σ g²) + epsilon) with C = alone (1 + Σ w) − 1, and 0 where C is not above
/// `least`; rho = rest_density alone (1 + Σ w). `alone` is the density of a particle without neighbours over the rest
/// density, slope2 the square of the gradient factor, 1/m².
struct MultiplierLaw {
  Real rest_density, alone, slope2, epsilon, least;
};

/// The sums of the density loop for a few particles.
template <class T>
struct DensitySums {
  std::span<const Vec4<T>> sums;  ///< (Σ g r̂, Σ w)
  const T* squares;               ///< Σ g²
};

/// Writes rho, kg/m³, and lambda, m², for as many particles as there are sums.
template <class T>
void find_multipliers(const MultiplierLaw& law, const DensitySums<T>& in, Real* rho, T* lambda);
template <>
void find_multipliers(const MultiplierLaw& law, const DensitySums<float>& in, Real* rho, float* lambda);
template <>
void find_multipliers(const MultiplierLaw& law, const DensitySums<double>& in, Real* rho, double* lambda);

/// p += factor · delta where nothing is in the way, and the records for the new p, with a scalar of zero.
template <class T>
struct Shift {
  const OpenSpace& open;
  bool from_inside;  ///< whether all particles are there
  const Encoding<T>& encoding;
  Real factor;
};
template <class T>
struct Moved {
  std::span<Vec3> p;
  Packed<T>* records;
};
/// Particles whose path leaves the open space, and a few beside them, are not moved: writes which, in their order, and
/// returns how many; `left` has room for all.
template <class T>
std::size_t move_particles(const Shift<T>& shift, const Vec4<T>* delta, const Moved<T>& moved, LocalId* left);
template <>
std::size_t move_particles(const Shift<float>& shift, const Vec4<float>* delta, const Moved<float>& moved,
                           LocalId* left);
template <>
std::size_t move_particles(const Shift<double>& shift, const Vec4<double>* delta, const Moved<double>& moved,
                           LocalId* left);

/// Whether two of the positions may be closer to each other than a distance whose square, m², is given: never false if
/// two are. It is true if there are more positions than are tested at once.
bool may_coincide(std::span<const Vec3> p, Real squared);

}  // namespace trevi

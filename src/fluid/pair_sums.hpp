// The sums over neighbours that the method consists of, dimensionless (u = r/h, r̂ from j to i), vectorised: with w(u)
// the shape W/W(0) of one kernel and g(u) that of −dW/dr of one, see kernels.hpp.
// This is where the run time goes. Each sum is a few terms under one common traversal of the neighbour list
// (pair_sums-inl.hpp); what the sums mean is in density.hpp and the velocity filters.
// Pairs that have drifted beyond h on the frozen list contribute nothing. Terms are added in the order of the list,
// lane by lane: the same bits wherever a particle is stored. Not collective.
#pragma once

#include "fluid/kernels.hpp"
#include "particles/neighbour_list.hpp"

namespace trevi {

/// What a pair loop reads. Owned particle i is records[low_ghosts + i].
template <class T>
struct Pairs {
  const std::vector<Packed<T>>& records;
  const NeighbourList& list;
  LocalId low_ghosts;
};

/// s_corr = −k ((1 − u²)/(1 − dq²))^(3n), the report's −k (W6(r)/W6(dq h))ⁿ; k in the unit of lambda, m².
struct Tensile {
  Real k = 0;
  int n = 4;
  Real dq = 0.2;
};

/// The loops of a density constraint for the instruction set in use. Owned particle i of a range writes to index
/// i − range.begin of `out`.
template <class T>
struct ConstraintLoops {
  /// out = (Σ g r̂, Σ w), squares = Σ g².
  void (*density)(const Pairs<T>&, Range, Vec4<T>* out, T* squares);
  /// out = Σ (lambda_i + lambda_j) g r̂, with lambda the scalar of the records.
  void (*delta)(const Pairs<T>&, Range, Vec4<T>* out);
  /// out = Σ (lambda_i + lambda_j + s_corr) g r̂.
  void (*tensile_delta)(const Pairs<T>&, Range, const Tensile&, Vec4<T>* out);
};

/// w of the first kernel, g of the second.
template <class T>
ConstraintLoops<T> constraint_loops(const Kernels& kernels);
template <>
ConstraintLoops<float> constraint_loops<float>(const Kernels& kernels);
template <>
ConstraintLoops<double> constraint_loops<double>(const Kernels& kernels);

/// The loops of the velocity filters, with g of Spiky and w of Poly6. Velocities are given for all particles, ghosts
/// included.
template <class T>
struct FilterLoops {
  /// out = Σ (v_j − v_i) × g r̂.
  void (*curl)(const Pairs<T>&, Range, const Vec4<T>* velocity, Vec4<T>* out);
  /// out = Σ (w_j − w_i) g r̂, with w_i the scalar of the records.
  void (*gradient)(const Pairs<T>&, Range, Vec4<T>* out);
  /// out = Σ (v_j − v_i) w.
  void (*smoothing)(const Pairs<T>&, Range, const Vec4<T>* velocity, Vec4<T>* out);
};

template <class T>
FilterLoops<T> filter_loops();
template <>
FilterLoops<float> filter_loops<float>();
template <>
FilterLoops<double> filter_loops<double>();

}  // namespace trevi

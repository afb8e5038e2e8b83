// The sums over neighbours that the method consists of, dimensionless (u = r/h, t = 1 − u, r̂ from j to i), vectorised.
// This is where the run time goes. Each sum is one small kernel under one common traversal of the neighbour list
// (src/fluid/pair_sums.cpp); what the sums mean is in density.hpp and velocity_filter.hpp.
// Pairs that have drifted beyond h on the frozen list contribute nothing. Terms are added in the order of the list,
// lane by lane: the same bits wherever a particle is stored. Not collective.
#pragma once

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

/// The loops for the instruction set in use. Owned particle i of a range writes to place i − range.begin of `out`.
/// Velocities are given for all particles, ghosts included.
template <class T>
struct PairLoops {
  /// out = (Σ t² r̂, Σ (1 − u²)³), squares = Σ t⁴.
  void (*density)(const Pairs<T>&, Range, Quad<T>* out, T* squares);
  /// The same with Σ (1 − u)³.
  void (*spiky_density)(const Pairs<T>&, Range, Quad<T>* out, T* squares);
  /// out = Σ (lambda_i + lambda_j) t² r̂, with lambda the scalar of the records.
  void (*delta)(const Pairs<T>&, Range, Quad<T>* out);
  /// out = Σ (lambda_i + lambda_j + s_corr) t² r̂.
  void (*tensile_delta)(const Pairs<T>&, Range, const Tensile&, Quad<T>* out);
  /// out = Σ (v_j − v_i) × t² r̂.
  void (*curl)(const Pairs<T>&, Range, const Quad<T>* velocity, Quad<T>* out);
  /// out = Σ (w_j − w_i) t² r̂, with w the scalar of the records.
  void (*gradient)(const Pairs<T>&, Range, Quad<T>* out);
  /// out = Σ (v_j − v_i) (1 − u²)³.
  void (*smoothing)(const Pairs<T>&, Range, const Quad<T>* velocity, Quad<T>* out);
};

template <class T>
PairLoops<T> pair_loops();
template <>
PairLoops<float> pair_loops<float>();
template <>
PairLoops<double> pair_loops<double>();

}  // namespace trevi

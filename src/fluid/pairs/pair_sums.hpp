// The vectorised sums over neighbours, in dimensionless form (u = r/h, r̂ from j to i): w(u) is the shape W/W(0) of a
// kernel, g(u) that of −dW/dr, see kernels.hpp. Most of the run time is spent here. All sums share one traversal of the
// neighbour list (pair_sums-inl.hpp); what they mean is in density.hpp and in the velocity filters. Pairs on the list
// that have moved further than h apart contribute nothing. Terms are added in the order of the list, in a fixed number
// of lanes: the same bits wherever a particle is stored. Not collective.
#pragma once

#include "kernels/kernels.hpp"
#include "particles/neighbour_list.hpp"

namespace trevi {

/// The input of a pair loop. Owned particle i is records[low_ghosts + i].
template <class T>
struct Pairs {
  const std::vector<Packed<T>>& records;
  const NeighbourList& list;
  LocalId low_ghosts;
};

/// Artificial pressure s_corr = −k (W6(r)/W6(dq h))ⁿ = −k ((1 − u²)/(1 − dq²))^(3n) (Macklin & Müller 2013, eq. 13); k
/// has the unit of lambda, m².
struct Tensile {
  Real k = 0;
  int n = 4;
  Real dq = 0.2;
};

/// The loops of a density constraint for the instruction set in use. Owned particle i of a range writes to index
/// i − range.begin of `out`.
template <class T>
struct ConstraintLoops {
  /// out = Σ w.
  void (*value)(const Pairs<T>&, Range, T* out);
  /// out = (Σ g r̂, Σ w), squares = Σ g².
  void (*density)(const Pairs<T>&, Range, Vec4<T>* out, T* squares);
  /// out = Σ (lambda_i + lambda_j) g r̂, with lambda the scalar of the records.
  void (*delta)(const Pairs<T>&, Range, Vec4<T>* out);
  /// out = Σ (lambda_i + lambda_j + s_corr) g r̂.
  void (*tensile_delta)(const Pairs<T>&, Range, const Tensile&, Vec4<T>* out);
};

/// w is that of the density kernel, g that of the gradient kernel.
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

/// The sums of a linear fit of velocities, v = v_i − v_j over u = p_ij/h with the weights F: the rows a = x, y, z are
/// Σ F (v_a u_x, v_a u_y, v_a u_z, u_a²), the last is Σ F (u_y u_z, u_z u_x, u_x u_y, 0).
template <class T>
struct VelocityFit {
  Vec4<T> row[4];
};

/// Half the gradients of the components of all velocities, ghosts included, in m/s per unit of the records: ½ ∇v_x of
/// particle i is x[i], and so on. The scalar of z is a factor f of each.
template <class T>
struct VelocityGradients {
  const Vec4<T>*x, *y, *z;
};

/// The loops of viscous friction, F being friction_weight(). Velocities are given for all particles, ghosts included.
template <class T>
struct FrictionLoops {
  /// The sums of `out` over all neighbours.
  void (*velocity_fit)(const Pairs<T>&, Range, const Vec4<T>* velocity, VelocityFit<T>* out);
  /// out_a = Σ (f_i + f_j) (v_ja − v_ia + ½ (∂_a v_i + ∂_a v_j)·(p_j − p_i)) F.
  void (*friction)(const Pairs<T>&, Range, const Vec4<T>* velocity, const VelocityGradients<T>&, Vec4<T>* out);
};

template <class T>
FrictionLoops<T> friction_loops(int dimensions);
template <>
FrictionLoops<float> friction_loops<float>(int dimensions);
template <>
FrictionLoops<double> friction_loops<double>(int dimensions);

}  // namespace trevi

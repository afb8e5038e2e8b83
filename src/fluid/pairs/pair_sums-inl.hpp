// The terms of the density constraint: the contribution of one vector of pairs to the sums of its particle; and the
// pair loops composed of these terms and of those of the filters, for one precision. Nothing here depends on a
// particular kernel. Included once per instruction set, inside the sources that Highway compiles repeatedly
// (pair_sums_single.cpp and pair_sums_double.cpp: one per precision, so that they can be compiled in parallel).
#if defined(TREVI_FLUID_PAIR_SUMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_PAIR_SUMS_INL
#undef TREVI_FLUID_PAIR_SUMS_INL
#else
#define TREVI_FLUID_PAIR_SUMS_INL
#endif

#include <tuple>
#include <utility>

#include "fluid/pairs/filter_terms-inl.hpp"
#include "kernels/list-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

template <class T, class Density>
struct ValueTerms : NumberTerms<T> {
  template <class D, class Sums>
  void add(D d, Sums& sums, const PairVector<D>& pair) const {
    const Product<D> value = Shape<Density>::value(d, distance_of(pair));
    sums.value = hn::MulAdd(value.first, value.second, sums.value);
  }
};

template <class T, class Density, class Gradient>
struct DensityTerms : VectorTerms<T> {
  T* squares;

  template <class D>
  struct Sums {
    hn::Vec<D> x, y, z, w, squares;
  };
  template <class D>
  Sums<D> start(D d, LocalId) const {
    const auto zero = hn::Zero(d);
    return {zero, zero, zero, zero, zero};
  }
  template <class D>
  void add(D d, Sums<D>& sums, const PairVector<D>& pair) const {
    const Distance<D> distance = distance_of(pair);
    const Product<D> value = Shape<Density>::value(d, distance);
    const Slope<D> slope = Shape<Gradient>::slope(d, distance);
    sums.w = hn::MulAdd(value.first, value.second, sums.w);
    sums.squares = hn::MulAdd(slope.size, slope.size, sums.squares);
    this->add_along(sums, pair, slope.per_u);
  }
  template <class D>
  struct Kept {
    typename VectorTerms<T>::template Kept<D> vectors;
    Unfinished<D> squares;
  };
  template <class D>
  static void keep(D d, const Groups<Sums<D>>& sums, std::size_t k, Kept<D>& kept) {
    VectorTerms<T>::keep(d, sums, k, kept.vectors);
    hn::Store(sum_of_groups<D>({sums.a.squares, sums.b.squares, sums.c.squares, sums.e.squares}), d,
              kept.squares.of[k]);
  }
  template <class D>
  void finish(D d, std::size_t first, std::size_t count, const Kept<D>& kept) const {
    VectorTerms<T>::finish(d, first, count, kept.vectors);
    const Finished<T> sums = sum_of_lanes(d, kept.squares);
    for (std::size_t k = 0; k < count; ++k) squares[first + k] = sums.of[k][0];
  }
};

template <class T, class Gradient>
struct DeltaTerms : RecordTerms<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    this->add_along(sums, pair, hn::Mul(hn::Add(sums.self.w, pair.w), slope_per_u<Gradient>(d, pair)));
  }
};

template <class T, class Gradient>
struct TensileDeltaTerms : RecordTerms<T> {
  T minus_k, per_base;
  int n;

  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    const auto q = hn::Mul(Shape<Poly6>::base(d, distance_of(pair)), hn::Set(d, per_base));
    const auto s_corr = hn::Mul(hn::Set(d, minus_k), power(d, hn::Mul(hn::Mul(q, q), q)));
    this->add_along(sums, pair, hn::Mul(hn::Add(hn::Add(sums.self.w, pair.w), s_corr), slope_per_u<Gradient>(d, pair)));
  }
  template <class D>
  hn::Vec<D> power(D d, hn::Vec<D> base) const {
    auto result = hn::Set(d, T{1});
    for (int e = n; e > 0; e >>= 1) {
      if (e & 1) result = hn::Mul(result, base);
      base = hn::Mul(base, base);
    }
    return result;
  }
};

// The pair loops themselves as plain functions: Highway's dispatch supports no others.
template <class T, class Density>
void value(const Pairs<T>& pairs, Range range, T* out) {
  for_each_particle(pairs, range, ValueTerms<T, Density>{{out}});
}
template <class T, class Density, class Gradient>
void density(const Pairs<T>& pairs, Range range, Vec4<T>* out, T* squares) {
  for_each_particle(pairs, range, DensityTerms<T, Density, Gradient>{{out}, squares});
}
template <class T, class Gradient>
void delta(const Pairs<T>& pairs, Range range, Vec4<T>* out) {
  for_each_particle(pairs, range, DeltaTerms<T, Gradient>{{{out}, pairs.records.data()}});
}
template <class T, class Gradient>
void tensile_delta(const Pairs<T>& pairs, Range range, const Tensile& tensile, Vec4<T>* out) {
  const auto per_base = static_cast<T>(1 / (1 - tensile.dq * tensile.dq));
  for_each_particle(
      pairs, range,
      TensileDeltaTerms<T, Gradient>{{{out}, pairs.records.data()}, static_cast<T>(-tensile.k), per_base, tensile.n});
}
template <class T>
void curl(const Pairs<T>& pairs, Range range, const Vec4<T>* velocity, Vec4<T>* out) {
  for_each_particle(pairs, range, CurlTerms<T>{{{out}, velocity}});
}
template <class T>
void gradient(const Pairs<T>& pairs, Range range, Vec4<T>* out) {
  for_each_particle(pairs, range, GradientTerms<T>{{{out}, pairs.records.data()}});
}
template <class T>
void smoothing(const Pairs<T>& pairs, Range range, const Vec4<T>* velocity, Vec4<T>* out) {
  for_each_particle(pairs, range, SmoothingTerms<T>{{{out}, velocity}});
}
template <class T, int dimensions>
void velocity_fit(const Pairs<T>& pairs, Range range, const Vec4<T>* velocity, VelocityFit<T>* out) {
  for_each_particle(pairs, range, VelocityFitTerms<T, dimensions>{velocity, out});
}
template <class T, int dimensions>
void friction(const Pairs<T>& pairs, Range range, const Vec4<T>* velocity, const VelocityGradients<T>& gradients,
              Vec4<T>* out) {
  for_each_particle(pairs, range, FrictionTerms<T, dimensions>{{{{out}, velocity}}, gradients});
}

// The loops for all pairs of kernels; number k has density kernel k / count and gradient kernel k % count.
template <class T, std::size_t... k>
ConstraintLoops<T> listed_loops(std::size_t wanted, std::index_sequence<k...>) {
  constexpr std::size_t count = std::tuple_size_v<KernelList>;
  const ConstraintLoops<T> all[] = {
      {value<T, std::tuple_element_t<k / count, KernelList>>,
       density<T, std::tuple_element_t<k / count, KernelList>, std::tuple_element_t<k % count, KernelList>>,
       delta<T, std::tuple_element_t<k % count, KernelList>>,
       tensile_delta<T, std::tuple_element_t<k % count, KernelList>>}...};
  return all[wanted];
}

template <class T>
ConstraintLoops<T> loops_of_constraint(const Kernels& kernels) {
  constexpr std::size_t count = std::tuple_size_v<KernelList>;
  return listed_loops<T>(kernels.density.index * count + kernels.gradient.index,
                         std::make_index_sequence<count * count>());
}
template <class T>
FilterLoops<T> loops_of_filters() {
  return {curl<T>, gradient<T>, smoothing<T>};
}
template <class T>
FrictionLoops<T> loops_of_friction(int dimensions) {
  if (dimensions == 2) return {velocity_fit<T, 2>, friction<T, 2>};
  return {velocity_fit<T, 3>, friction<T, 3>};
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

// The terms of the pair loops: what one vector of pairs adds to the sums of its particle, and the pair loops made of
// them for one precision. Nothing here depends on a particular kernel of a constraint. Included once per instruction
// set, inside the sources that Highway compiles repeatedly (pair_sums_single.cpp and pair_sums_double.cpp: one per
// precision, so that they can be compiled in parallel).
#if defined(TREVI_FLUID_PAIR_SUMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_PAIR_SUMS_INL
#undef TREVI_FLUID_PAIR_SUMS_INL
#else
#define TREVI_FLUID_PAIR_SUMS_INL
#endif

#include <tuple>
#include <utility>

#include "fluid/pairs/pair_traversal-inl.hpp"
#include "kernels/list-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Where the kernel uses no square root the compiler removes this one.
template <class D>
HWY_INLINE Distance<D> distance_of(const PairVector<D>& pair) {
  return {hn::Sqrt(pair.r2), pair.r2};
}
template <class Kernel, class D>
HWY_INLINE hn::Vec<D> slope_per_u(D d, const PairVector<D>& pair) {
  return Shape<Kernel>::slope(d, distance_of(pair)).per_u;
}

// Base of terms whose sum is a vector along p_ij. finish() divides by the units of the records, so that distances are
// u.
template <class T>
struct VectorTerms {
  Vec4<T>* out;

  template <class D>
  static Four<D> start(D d, LocalId) {
    const auto zero = hn::Zero(d);
    return {zero, zero, zero, zero};
  }
  template <class D, class Sums>
  static void add_along(Sums& sums, const PairVector<D>& pair, hn::Vec<D> factor) {
    sums.x = hn::MulAdd(factor, pair.dx, sums.x);
    sums.y = hn::MulAdd(factor, pair.dy, sums.y);
    sums.z = hn::MulAdd(factor, pair.dz, sums.z);
  }
  template <class D, class Sums>
  Vec4<T> finish(D d, LocalId index, const Groups<Sums>& sums) const {
    constexpr T per_unit = static_cast<T>(1 / Packed<T>::units_per_h);
    const Vec4<T> total = sum_of_groups(d, sums);
    return out[index] = {total.x * per_unit, total.y * per_unit, total.z * per_unit, total.w};
  }
};

// Base of terms whose sum is one number.
template <class T>
struct NumberTerms {
  T* out;

  template <class D>
  struct Sums {
    hn::Vec<D> value;
  };
  template <class D>
  static Sums<D> start(D d, LocalId) {
    return {hn::Zero(d)};
  }
  template <class D>
  void finish(D d, LocalId index, const Groups<Sums<D>>& sums) const {
    out[index] = sum_of_lanes(d, Groups<hn::Vec<D>>{sums.a.value, sums.b.value, sums.c.value, sums.e.value});
  }
};

template <class T, class Density>
struct ValueTerms : NumberTerms<T> {
  template <class D, class Sums>
  void add(D d, Sums& sums, const PairVector<D>& pair) const {
    const Product<D> value = Shape<Density>::value(d, distance_of(pair));
    sums.value = hn::MulAdd(value.first, value.second, sums.value);
  }
};

template <class T>
struct SecondMomentTerms : NumberTerms<T> {
  template <class D, class Sums>
  void add(D d, Sums& sums, const PairVector<D>& pair) const {
    const Product<D> value = Shape<Poly6>::value(d, distance_of(pair));
    sums.value = hn::MulAdd(hn::Mul(value.first, value.second), pair.r2, sums.value);
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
  void finish(D d, LocalId index, const Groups<Sums<D>>& sums) const {
    VectorTerms<T>::finish(d, index, sums);
    squares[index] =
        sum_of_lanes(d, Groups<hn::Vec<D>>{sums.a.squares, sums.b.squares, sums.c.squares, sums.e.squares});
  }
};

// The sums, and values of particle i that the terms compare with those of its neighbours (self).
template <class D>
struct SumsOf {
  hn::Vec<D> x, y, z, w;
  Four<D> self;
};

template <class T>
struct RecordTerms : VectorTerms<T> {
  const Packed<T>* records;

  template <class D>
  SumsOf<D> start(D d, LocalId i) const {
    const auto zero = hn::Zero(d);
    return {zero, zero, zero, zero, {zero, zero, zero, hn::Set(d, records[i].w)}};
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

template <class T>
struct GradientTerms : RecordTerms<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    this->add_along(sums, pair, hn::Mul(hn::Sub(pair.w, sums.self.w), slope_per_u<Spiky>(d, pair)));
  }
};

template <class T>
struct VelocityTerms : VectorTerms<T> {
  const Vec4<T>* velocity;

  template <class D>
  SumsOf<D> start(D d, LocalId i) const {
    const auto zero = hn::Zero(d);
    const Vec4<T>& v = velocity[i];
    return {zero, zero, zero, zero, {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z), hn::Set(d, v.w)}};
  }
  template <class D>
  Four<D> relative(D d, const SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = gather(d, velocity, pair.index);
    return {hn::Sub(v.x, sums.self.x), hn::Sub(v.y, sums.self.y), hn::Sub(v.z, sums.self.z), v.w};
  }
};

template <class T>
struct CurlTerms : VelocityTerms<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = this->relative(d, sums, pair);
    const auto factor = slope_per_u<Spiky>(d, pair);
    const auto cross_x = hn::NegMulAdd(v.z, pair.dy, hn::Mul(v.y, pair.dz));
    const auto cross_y = hn::NegMulAdd(v.x, pair.dz, hn::Mul(v.z, pair.dx));
    const auto cross_z = hn::NegMulAdd(v.y, pair.dx, hn::Mul(v.x, pair.dy));
    sums.x = hn::MulAdd(factor, cross_x, sums.x);
    sums.y = hn::MulAdd(factor, cross_y, sums.y);
    sums.z = hn::MulAdd(factor, cross_z, sums.z);
  }
};

template <class T>
struct SmoothingTerms : VelocityTerms<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    add_weighted(sums, this->relative(d, sums, pair), weight(d, pair));
  }
  template <class D>
  static hn::Vec<D> weight(D d, const PairVector<D>& pair) {
    const Product<D> value = Shape<Poly6>::value(d, distance_of(pair));
    return hn::Mul(value.first, value.second);
  }
  template <class D>
  static void add_weighted(SumsOf<D>& sums, const Four<D>& v, hn::Vec<D> weight) {
    sums.x = hn::MulAdd(weight, v.x, sums.x);
    sums.y = hn::MulAdd(weight, v.y, sums.y);
    sums.z = hn::MulAdd(weight, v.z, sums.z);
  }
  template <class D>
  void finish(D d, LocalId index, const Groups<SumsOf<D>>& sums) const {
    this->out[index] = sum_of_groups(d, sums);
  }
};

template <class T>
struct WeightedSmoothingTerms : SmoothingTerms<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = this->relative(d, sums, pair);
    this->add_weighted(sums, v, hn::Mul(hn::Add(sums.self.w, v.w), this->weight(d, pair)));
  }
};

// The pair loops themselves as plain functions: Highway's dispatch takes no others.
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
template <class T>
void weighted_smoothing(const Pairs<T>& pairs, Range range, const Vec4<T>* velocity, Vec4<T>* out) {
  for_each_particle(pairs, range, WeightedSmoothingTerms<T>{{{{out}, velocity}}});
}
template <class T>
void second_moment(const Pairs<T>& pairs, Range range, T* out) {
  for_each_particle(pairs, range, SecondMomentTerms<T>{{out}});
}

// The loops of all pairs of kernels; that with number k has density kernel k / count and gradient kernel k % count.
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
  return {curl<T>, gradient<T>, smoothing<T>, weighted_smoothing<T>, second_moment<T>};
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

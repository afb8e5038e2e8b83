// The kernels of the pair loops: what one vector of pairs adds to the sums of its particle.
// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "fluid/pair_sums.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fluid/pair_sums.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include "fluid/pair_traversal-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// 1 − u², zero from h on.
template <class D>
HWY_INLINE hn::Vec<D> poly6_base(D d, const PairVector<D>& pair) {
  return hn::Max(hn::Sub(hn::Set(d, hn::TFromD<D>{1}), pair.r2), hn::Zero(d));
}

// t = 1 − u, t² and t²/r; coincident particles get a finite factor of a zero vector.
template <class D>
struct Spiky {
  hn::Vec<D> t, t2, t2_per_r;
};
template <class D>
HWY_INLINE Spiky<D> spiky(D d, const PairVector<D>& pair) {
  using T = hn::TFromD<D>;
  const auto r = hn::Sqrt(pair.r2);
  const auto t = hn::Max(hn::Sub(hn::Set(d, T{1}), r), hn::Zero(d));
  const auto t2 = hn::Mul(t, t);
  return {t, t2, hn::Div(t2, hn::Max(r, hn::Set(d, static_cast<T>(1e-18))))};
}

// Sums of three components start at zero; what they are multiplied with at the end takes r̂ from record units to none.
template <class T>
struct VectorKernel {
  Quad<T>* out;

  template <class D>
  static Four<D> start(D d, LocalId) {
    const auto zero = hn::Zero(d);
    return {zero, zero, zero, zero};
  }
  template <class D>
  static void add_along(Four<D>& sums, const PairVector<D>& pair, hn::Vec<D> factor) {
    sums.x = hn::MulAdd(factor, pair.dx, sums.x);
    sums.y = hn::MulAdd(factor, pair.dy, sums.y);
    sums.z = hn::MulAdd(factor, pair.dz, sums.z);
  }
  template <class D>
  Quad<T> finish(D d, LocalId place, const Four<D>& sums) const {
    constexpr T per_unit = static_cast<T>(1 / Packed<T>::units_per_h);
    const Quad<T> total = sum_of_lanes(d, sums);
    return out[place] = {total.x * per_unit, total.y * per_unit, total.z * per_unit, total.w};
  }
};

template <class T, bool of_poly6>
struct DensityKernel : VectorKernel<T> {
  T* squares;

  template <class D>
  struct Sums {
    Four<D> vector;
    hn::Vec<D> squares;
  };
  template <class D>
  Sums<D> start(D d, LocalId i) const {
    return {VectorKernel<T>::start(d, i), hn::Zero(d)};
  }
  template <class D>
  void add(D d, Sums<D>& sums, const PairVector<D>& pair) const {
    const Spiky<D> s = spiky(d, pair);
    const auto q = of_poly6 ? poly6_base(d, pair) : s.t;
    sums.vector.w = hn::MulAdd(hn::Mul(q, q), q, sums.vector.w);
    sums.squares = hn::MulAdd(s.t2, s.t2, sums.squares);
    this->add_along(sums.vector, pair, s.t2_per_r);
  }
  template <class D>
  void finish(D d, LocalId place, const Sums<D>& sums) const {
    VectorKernel<T>::finish(d, place, sums.vector);
    squares[place] = hn::GetLane(hn::SumOfLanes(d, sums.squares));
  }
};

// The sums of a kernel that compares a scalar or vector of particle i with that of its neighbours.
template <class D>
struct SumsOf : Four<D> {
  Four<D> self;
};

template <class T>
struct RecordKernel : VectorKernel<T> {
  const Packed<T>* records;

  template <class D>
  SumsOf<D> start(D d, LocalId i) const {
    const auto zero = hn::Zero(d);
    return {{zero, zero, zero, zero}, {zero, zero, zero, hn::Set(d, records[i].w)}};
  }
};

template <class T>
struct DeltaKernel : RecordKernel<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    this->add_along(sums, pair, hn::Mul(hn::Add(sums.self.w, pair.w), spiky(d, pair).t2_per_r));
  }
};

template <class T>
struct TensileDeltaKernel : RecordKernel<T> {
  T minus_k, per_base;
  int n;

  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    const auto q = hn::Mul(poly6_base(d, pair), hn::Set(d, per_base));
    const auto s_corr = hn::Mul(hn::Set(d, minus_k), power(d, hn::Mul(hn::Mul(q, q), q)));
    this->add_along(sums, pair, hn::Mul(hn::Add(hn::Add(sums.self.w, pair.w), s_corr), spiky(d, pair).t2_per_r));
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
struct GradientKernel : RecordKernel<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    this->add_along(sums, pair, hn::Mul(hn::Sub(pair.w, sums.self.w), spiky(d, pair).t2_per_r));
  }
};

template <class T>
struct VelocityKernel : VectorKernel<T> {
  const Quad<T>* velocity;

  template <class D>
  SumsOf<D> start(D d, LocalId i) const {
    const auto zero = hn::Zero(d);
    const Quad<T>& v = velocity[i];
    return {{zero, zero, zero, zero}, {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z), zero}};
  }
  template <class D>
  Four<D> relative(D d, const SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = gather(d, velocity, pair.index);
    return {hn::Sub(v.x, sums.self.x), hn::Sub(v.y, sums.self.y), hn::Sub(v.z, sums.self.z), v.w};
  }
};

template <class T>
struct CurlKernel : VelocityKernel<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = this->relative(d, sums, pair);
    const auto factor = spiky(d, pair).t2_per_r;
    const auto cross_x = hn::NegMulAdd(v.z, pair.dy, hn::Mul(v.y, pair.dz));
    const auto cross_y = hn::NegMulAdd(v.x, pair.dz, hn::Mul(v.z, pair.dx));
    const auto cross_z = hn::NegMulAdd(v.y, pair.dx, hn::Mul(v.x, pair.dy));
    sums.x = hn::MulAdd(factor, cross_x, sums.x);
    sums.y = hn::MulAdd(factor, cross_y, sums.y);
    sums.z = hn::MulAdd(factor, cross_z, sums.z);
  }
};

template <class T>
struct SmoothingKernel : VelocityKernel<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = this->relative(d, sums, pair);
    const auto q = poly6_base(d, pair);
    const auto weight = hn::Mul(hn::Mul(q, q), q);
    sums.x = hn::MulAdd(weight, v.x, sums.x);
    sums.y = hn::MulAdd(weight, v.y, sums.y);
    sums.z = hn::MulAdd(weight, v.z, sums.z);
  }
  template <class D>
  void finish(D d, LocalId place, const SumsOf<D>& sums) const {
    this->out[place] = sum_of_lanes(d, static_cast<const Four<D>&>(sums));
  }
};

// One set of entry points per precision; Highway's dispatch takes plain functions only.
template <class T>
struct Loops {
  static void density(const Pairs<T>& pairs, Range range, Quad<T>* out, T* squares) {
    for_each_particle(pairs, range, DensityKernel<T, true>{{out}, squares});
  }
  static void spiky_density(const Pairs<T>& pairs, Range range, Quad<T>* out, T* squares) {
    for_each_particle(pairs, range, DensityKernel<T, false>{{out}, squares});
  }
  static void delta(const Pairs<T>& pairs, Range range, Quad<T>* out) {
    for_each_particle(pairs, range, DeltaKernel<T>{{{out}, pairs.records.data()}});
  }
  static void tensile_delta(const Pairs<T>& pairs, Range range, const Tensile& tensile, Quad<T>* out) {
    const auto per_base = static_cast<T>(1 / (1 - tensile.dq * tensile.dq));
    for_each_particle(
        pairs, range,
        TensileDeltaKernel<T>{{{out}, pairs.records.data()}, static_cast<T>(-tensile.k), per_base, tensile.n});
  }
  static void curl(const Pairs<T>& pairs, Range range, const Quad<T>* velocity, Quad<T>* out) {
    for_each_particle(pairs, range, CurlKernel<T>{{{out}, velocity}});
  }
  static void gradient(const Pairs<T>& pairs, Range range, Quad<T>* out) {
    for_each_particle(pairs, range, GradientKernel<T>{{{out}, pairs.records.data()}});
  }
  static void smoothing(const Pairs<T>& pairs, Range range, const Quad<T>* velocity, Quad<T>* out) {
    for_each_particle(pairs, range, SmoothingKernel<T>{{{out}, velocity}});
  }
};

template <class T>
PairLoops<T> pair_loops() {
  return {Loops<T>::density, Loops<T>::spiky_density, Loops<T>::delta,    Loops<T>::tensile_delta,
          Loops<T>::curl,    Loops<T>::gradient,      Loops<T>::smoothing};
}
PairLoops<float> pair_loops_single() { return pair_loops<float>(); }
PairLoops<double> pair_loops_double() { return pair_loops<double>(); }

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(pair_loops_single);
HWY_EXPORT(pair_loops_double);

template <>
PairLoops<float> pair_loops<float>() {
  return HWY_DYNAMIC_DISPATCH(pair_loops_single)();
}
template <>
PairLoops<double> pair_loops<double>() {
  return HWY_DYNAMIC_DISPATCH(pair_loops_double)();
}

}  // namespace trevi
#endif

// Building blocks of the terms of pair loops, and the terms of the velocity filters: curl, gradient and smoothing.
// Included once per instruction set, inside the sources that Highway compiles repeatedly.
#if defined(TREVI_FLUID_FILTER_TERMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_FILTER_TERMS_INL
#undef TREVI_FLUID_FILTER_TERMS_INL
#else
#define TREVI_FLUID_FILTER_TERMS_INL
#endif

#include <array>

#include "fluid/pairs/pair_traversal-inl.hpp"
#include "kernels/list-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Where the kernel uses no square root, the compiler removes this one.
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
  template <class D>
  struct Kept {
    Unfinished<D> xy, zw;  // single precision: all in xy
  };
  template <class D, class Sums>
  static void keep(D d, const Groups<Sums>& sums, std::size_t k, Kept<D>& kept) {
    const BlockSums<D> of_blocks = sums_of_blocks(d, sums);
    hn::Store(of_blocks.xy, d, kept.xy.of[k]);
    if constexpr (sizeof(T) == 8) hn::Store(of_blocks.zw, d, kept.zw.of[k]);
  }
  template <class D>
  void finish(D d, std::size_t first, std::size_t count, const Kept<D>& kept) const {
    write(d, first, count, kept, static_cast<T>(1 / Packed<T>::units_per_h));
  }

 protected:
  // The sums of x, y and z times `per_unit`, and that of w.
  template <class D>
  void write(D d, std::size_t first, std::size_t count, const Kept<D>& kept, T per_unit) const {
    alignas(64) Vec4<T> sums[batch];  // as wide as the vectors that are stored there
    if constexpr (sizeof(T) == 4) {
      const Finished<T> all = sum_of_blocks(d, kept.xy);
      alignas(16) const T scale[4] = {per_unit, per_unit, per_unit, 1};
      for (std::size_t at = 0; at < batch * 4; at += hn::MaxLanes(d))
        hn::Store(hn::Mul(hn::Load(d, &all.of[0][0] + at), hn::LoadDup128(d, scale)), d, &sums[0].x + at);
    } else {
      const Finished<T> xy = sum_of_blocks(d, kept.xy), zw = sum_of_blocks(d, kept.zw);
      for (std::size_t k = 0; k < batch; ++k)
        sums[k] = {xy.of[k][0] * per_unit, xy.of[k][1] * per_unit, zw.of[k][0] * per_unit, zw.of[k][1]};
    }
    std::copy_n(sums, count, out + first);
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
  using Kept = Unfinished<D>;
  template <class D>
  static void keep(D d, const Groups<Sums<D>>& sums, std::size_t k, Kept<D>& kept) {
    hn::Store(sum_of_groups<D>({sums.a.value, sums.b.value, sums.c.value, sums.e.value}), d, kept.of[k]);
  }
  template <class D>
  void finish(D d, std::size_t first, std::size_t count, const Kept<D>& kept) const {
    const Finished<T> sums = sum_of_lanes(d, kept);
    for (std::size_t k = 0; k < count; ++k) out[first + k] = sums.of[k][0];
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

// friction_weight().
template <int dimensions, class D>
HWY_INLINE hn::Vec<D> weight_of_friction(D d, const PairVector<D>& pair) {
  const auto rest = rest_to_one(d, pair.r2);
  return hn::Mul(rest, dimensions == 2 ? rest : hn::Sqrt(rest));
}

template <class T>
struct GradientTerms : RecordTerms<T> {
  template <class D>
  void add(D d, SumsOf<D>& sums, const PairVector<D>& pair) const {
    this->add_along(sums, pair, hn::Mul(hn::Sub(pair.w, sums.self.w), slope_per_u<Spiky>(d, pair)));
  }
};

template <class D, class T>
HWY_INLINE Four<D> in_all_lanes(D d, const Vec4<T>& v) {
  return {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z), hn::Set(d, v.w)};
}

template <class T>
struct VelocityTerms : VectorTerms<T> {
  const Vec4<T>* velocity;

  template <class D>
  SumsOf<D> start(D d, LocalId i) const {
    const auto zero = hn::Zero(d);
    return {zero, zero, zero, zero, in_all_lanes(d, velocity[i])};
  }
  template <class D>
  Four<D> relative(D d, const SumsOf<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = gather(d, velocity, pair.place);
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
    const Product<D> value = Shape<Poly6>::value(d, distance_of(pair));
    add_weighted(sums, this->relative(d, sums, pair), hn::Mul(value.first, value.second));
  }
  template <class D>
  static void add_weighted(SumsOf<D>& sums, const Four<D>& v, hn::Vec<D> weight) {
    sums.x = hn::MulAdd(weight, v.x, sums.x);
    sums.y = hn::MulAdd(weight, v.y, sums.y);
    sums.z = hn::MulAdd(weight, v.z, sums.z);
  }
  template <class D>
  void finish(D d, std::size_t first, std::size_t count, const typename VectorTerms<T>::template Kept<D>& kept) const {
    this->write(d, first, count, kept, 1);
  }
};

template <class T, int dimensions>
struct VelocityFitTerms {
  const Vec4<T>* velocity;
  VelocityFit<T>* out;

  template <class D>
  struct Sums {
    Four<D> row[4], self;
  };
  template <class D>
  using Kept = std::array<typename VectorTerms<T>::template Kept<D>, 4>;
  template <class D>
  Sums<D> start(D d, LocalId i) const {
    const auto zero = hn::Zero(d);
    const Four<D> none{zero, zero, zero, zero};
    return {{none, none, none, none}, in_all_lanes(d, velocity[i])};
  }
  template <class D>
  void add(D d, Sums<D>& sums, const PairVector<D>& pair) const {
    const Four<D> v = gather(d, velocity, pair.place);
    const auto weight = weight_of_friction<dimensions>(d, pair);
    const auto x = hn::Mul(weight, pair.dx), y = hn::Mul(weight, pair.dy), z = hn::Mul(weight, pair.dz);
    const auto add_row = [&](Four<D>& row, hn::Vec<D> component, hn::Vec<D> square) {
      row = {hn::MulAdd(component, x, row.x), hn::MulAdd(component, y, row.y), hn::MulAdd(component, z, row.z),
             hn::Add(square, row.w)};
    };
    add_row(sums.row[0], hn::Sub(sums.self.x, v.x), hn::Mul(x, pair.dx));
    add_row(sums.row[1], hn::Sub(sums.self.y, v.y), hn::Mul(y, pair.dy));
    add_row(sums.row[2], hn::Sub(sums.self.z, v.z), hn::Mul(z, pair.dz));
    Four<D>& mixed = sums.row[3];
    mixed = {hn::MulAdd(y, pair.dz, mixed.x), hn::MulAdd(z, pair.dx, mixed.y), hn::MulAdd(x, pair.dy, mixed.z),
             mixed.w};
  }
  template <class D>
  static void keep(D d, const Groups<Sums<D>>& sums, std::size_t k, Kept<D>& kept) {
    for (std::size_t r = 0; r < 4; ++r)
      VectorTerms<T>::keep(d, Groups<Four<D>>{sums.a.row[r], sums.b.row[r], sums.c.row[r], sums.e.row[r]}, k, kept[r]);
  }
  template <class D>
  void finish(D d, std::size_t first, std::size_t count, const Kept<D>& kept) const {
    alignas(64) Vec4<T> sums[batch];
    for (std::size_t r = 0; r < 4; ++r) {
      VectorTerms<T>{sums}.finish(d, 0, count, kept[r]);  // divides by the units once, and not w
      constexpr T per_unit = static_cast<T>(1 / Packed<T>::units_per_h);
      const T vector = r < 3 ? T{1} : per_unit, square = per_unit * per_unit;
      for (std::size_t k = 0; k < count; ++k) {
        const Vec4<T>& sum = sums[k];
        out[first + k].row[r] = {sum.x * vector, sum.y * vector, sum.z * vector, sum.w * square};
      }
    }
  }
};

template <class T, int dimensions>
struct FrictionTerms : SmoothingTerms<T> {
  VelocityGradients<T> gradient;

  template <class D>
  struct Sums : SumsOf<D> {
    Four<D> gx, gy, gz;
  };
  template <class D>
  Sums<D> start(D d, LocalId i) const {
    Sums<D> sums{VelocityTerms<T>::start(d, i), in_all_lanes(d, gradient.x[i]), in_all_lanes(d, gradient.y[i]),
                 in_all_lanes(d, gradient.z[i])};
    sums.self.w = sums.gz.w;
    return sums;
  }
  template <class D>
  void add(D d, Sums<D>& sums, const PairVector<D>& pair) const {
    Four<D> v = this->relative(d, sums, pair);
    const auto turn = [&](const Four<D>& mine, const Vec4<T>* field, hn::Vec<D> way) {
      const Four<D> row = gather(d, field, pair.place);
      v = {hn::NegMulAdd(hn::Add(mine.x, row.x), way, v.x), hn::NegMulAdd(hn::Add(mine.y, row.y), way, v.y),
           hn::NegMulAdd(hn::Add(mine.z, row.z), way, v.z), row.w};
    };
    turn(sums.gx, gradient.x, pair.dx);
    turn(sums.gy, gradient.y, pair.dy);
    turn(sums.gz, gradient.z, pair.dz);
    this->add_weighted(sums, v, hn::Mul(hn::Add(sums.self.w, v.w), weight_of_friction<dimensions>(d, pair)));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

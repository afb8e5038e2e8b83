// The interface of a smoothing kernel for the pair loops, for a vector of pairs at a time. Each kernel specialises
// Shape<Kernel> beside its scalar type (poly6-inl.hpp) with two functions of the distance u = r/h, both zero from u = 1
// on:
//   value(d, distance)   W(r)/W(0), as two factors: the loops fuse the last product with the addition to the sum
//   slope(d, distance)   −dW/dr over slope_factor(h), as it is (size) and over u (per_u, finite at u = 0)
// Included once per instruction set, inside the sources that Highway compiles repeatedly.
#if defined(TREVI_FLUID_KERNELS_SHAPE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_FLUID_KERNELS_SHAPE_INL
#undef TREVI_FLUID_KERNELS_SHAPE_INL
#else
#define TREVI_FLUID_KERNELS_SHAPE_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
struct Distance {
  hn::Vec<D> u, u2;
};
template <class D>
struct Product {
  hn::Vec<D> first, second;
};
template <class D>
struct Slope {
  hn::Vec<D> size, per_u;
};

template <class Kernel>
struct Shape;

// 1 − x, and zero where x > 1.
template <class D>
HWY_INLINE hn::Vec<D> rest_to_one(D d, hn::Vec<D> x) {
  return hn::Max(hn::Sub(hn::Set(d, hn::TFromD<D>{1}), x), hn::Zero(d));
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

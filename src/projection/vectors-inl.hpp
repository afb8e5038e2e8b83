// Vectors for the loops of the projection: doubles, at most four at a time. Included once per instruction set.
#if defined(TREVI_PROJECTION_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_PROJECTION_VECTORS_INL
#undef TREVI_PROJECTION_VECTORS_INL
#else
#define TREVI_PROJECTION_VECTORS_INL
#endif

#include <hwy/highway.h>

#include <array>

#include "trevi/types.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t max_lanes = 4;
using Wide = hn::CappedTag<double, max_lanes>;
using V = hn::Vec<Wide>;
using V3 = std::array<V, 3>;

HWY_INLINE V set(Real a) { return hn::Set(Wide(), a); }
HWY_INLINE V clamp(V v, Real low, Real high) { return hn::Min(hn::Max(v, set(low)), set(high)); }
// Always initialised with values: the default constructor would not be compiled for this instruction set.
HWY_INLINE V3 zeros() { return {hn::Zero(Wide()), hn::Zero(Wide()), hn::Zero(Wide())}; }

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();
#endif

// The pair loops in single precision, compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "fluid/pairs/pair_sums.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fluid/pairs/pair_sums_single.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include "fluid/pairs/pair_sums-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

ConstraintLoops<float> constraint_loops_single(const Kernels& kernels) { return loops_of_constraint<float>(kernels); }
FilterLoops<float> filter_loops_single() { return loops_of_filters<float>(); }
FrictionLoops<float> friction_loops_single(int dimensions) { return loops_of_friction<float>(dimensions); }

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(constraint_loops_single);
HWY_EXPORT(filter_loops_single);
HWY_EXPORT(friction_loops_single);

template <>
ConstraintLoops<float> constraint_loops<float>(const Kernels& kernels) {
  return HWY_DYNAMIC_DISPATCH(constraint_loops_single)(kernels);
}
template <>
FilterLoops<float> filter_loops<float>() {
  return HWY_DYNAMIC_DISPATCH(filter_loops_single)();
}
template <>
FrictionLoops<float> friction_loops<float>(int dimensions) {
  return HWY_DYNAMIC_DISPATCH(friction_loops_single)(dimensions);
}

}  // namespace trevi
#endif

// The pair loops in double precision, compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "fluid/pairs/pair_sums.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fluid/pairs/pair_sums_double.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include "fluid/pairs/pair_sums-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

ConstraintLoops<double> constraint_loops_double(const Kernels& kernels) { return loops_of_constraint<double>(kernels); }
FilterLoops<double> filter_loops_double() { return loops_of_filters<double>(); }
FrictionLoops<double> friction_loops_double(int dimensions) { return loops_of_friction<double>(dimensions); }

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(constraint_loops_double);
HWY_EXPORT(filter_loops_double);
HWY_EXPORT(friction_loops_double);

template <>
ConstraintLoops<double> constraint_loops<double>(const Kernels& kernels) {
  return HWY_DYNAMIC_DISPATCH(constraint_loops_double)(kernels);
}
template <>
FilterLoops<double> filter_loops<double>() {
  return HWY_DYNAMIC_DISPATCH(filter_loops_double)();
}
template <>
FrictionLoops<double> friction_loops<double>(int dimensions) {
  return HWY_DYNAMIC_DISPATCH(friction_loops_double)(dimensions);
}

}  // namespace trevi
#endif

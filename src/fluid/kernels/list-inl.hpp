// The list of the smoothing kernels. A kernel is one file beside this one and its two lines here: from the list come
// the names that scenes may give, the lattice sums, and the pair loops of each kernel for densities with each for
// gradients. May be included anywhere; in the sources that Highway compiles repeatedly, once per instruction set.
#include <tuple>

#include "fluid/kernels/poly6-inl.hpp"
#include "fluid/kernels/spiky-inl.hpp"
#include "fluid/kernels/wendland_c2-inl.hpp"

#ifndef TREVI_FLUID_KERNELS_LIST
#define TREVI_FLUID_KERNELS_LIST

namespace trevi {

using KernelList = std::tuple<  //
    Poly6,                      //
    Spiky,                      //
    WendlandC2>;

}  // namespace trevi

#endif

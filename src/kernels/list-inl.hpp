// The list of the smoothing kernels. To add a kernel, write one file beside this one and add two lines here, its
// include and its entry: the names for scenes, the sums over the lattice, and the pair loops for each pair of density
// and gradient kernel follow from the list. May be included anywhere; in the sources that Highway compiles repeatedly,
// once per instruction set.
#include <tuple>

#include "kernels/poly6-inl.hpp"
#include "kernels/spiky-inl.hpp"
#include "kernels/wendland_c2-inl.hpp"

#ifndef TREVI_FLUID_KERNELS_LIST
#define TREVI_FLUID_KERNELS_LIST

namespace trevi {

using KernelList = std::tuple<  //
    Poly6,                      //
    Spiky,                      //
    WendlandC2>;

}  // namespace trevi

#endif

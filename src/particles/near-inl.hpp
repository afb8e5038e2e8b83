// The neighbours of particles among the candidates of their cell: the second half of the search of neighbour_list.cpp.
// Included once per instruction set, inside the source that Highway compiles repeatedly.
#if defined(TREVI_PARTICLES_NEAR_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_PARTICLES_NEAR_INL
#undef TREVI_PARTICLES_NEAR_INL
#else
#define TREVI_PARTICLES_NEAR_INL
#endif

#include <array>

#include "particles/candidates-inl.hpp"
#include "particles/neighbour_list.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Stores signed integers as wide as T as LocalIds, or as codes.
template <class D, class V>
void store_indices(D, V index, LocalId* HWY_RESTRICT out) {
  const hn::Rebind<LocalId, D> d32;
  if constexpr (sizeof(hn::TFromD<D>) == sizeof(LocalId)) {
    hn::StoreU(index, d32, out);
  } else {
    const hn::RebindToUnsigned<D> du;
    const hn::Rebind<std::uint32_t, D> du32;
    hn::StoreU(hn::BitCast(d32, hn::TruncateTo(du32, hn::BitCast(du, index))), d32, out);
  }
}

template <class D, class V>
void store_indices(D, V index, std::uint16_t* HWY_RESTRICT out) {
  const hn::RebindToUnsigned<D> du;
  const hn::Rebind<std::uint16_t, D> d16;
  hn::StoreU(hn::TruncateTo(d16, hn::BitCast(du, index)), d16, out);
}

// Writes the candidates nearer than h to particle `self` at p and returns their number; stops when there are too many.
template <class T, class Out>
std::size_t near(const Candidates<T>& candidates, LocalId self, const std::array<T, 3>& p, Out* HWY_RESTRICT out) {
  constexpr auto most = static_cast<std::size_t>(NeighbourList::max_neighbours);
  const hn::ScalableTag<T> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto x = hn::Set(d, p[0]), y = hn::Set(d, p[1]), z = hn::Set(d, p[2]);
  const auto self_index = hn::Set(di, self);
  const auto limit = hn::Set(d, static_cast<T>(Packed<T>::units_per_h * Packed<T>::units_per_h));
  const T *all_x = candidates.x.data(), *all_y = candidates.y.data(), *all_z = candidates.z.data();
  const auto* all_index = candidates.index.data();
  const std::size_t size = candidates.size();
  std::size_t found = 0;
  for (std::size_t k = 0; k < size && found <= most; k += hn::Lanes(d)) {
    const auto dx = hn::Sub(hn::LoadU(d, all_x + k), x);
    const auto dy = hn::Sub(hn::LoadU(d, all_y + k), y);
    const auto dz = hn::Sub(hn::LoadU(d, all_z + k), z);
    const auto r2 = hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)));
    const auto index = hn::LoadU(di, all_index + k);
    const auto other = hn::RebindMask(d, hn::Ne(index, self_index));
    // Compress in a register and store whole: a compressing store to memory is slow on some processors.
    const Chosen<decltype(d)> chosen(d, hn::And(other, hn::Lt(r2, limit)));
    store_indices(d, hn::BitCast(di, chosen.first(hn::BitCast(d, index))), out + found);
    found += chosen.count();
  }
  return found;
}

// The same for two particles at a time, so that a candidate is read once; there are no more than max_neighbours.
template <class T>
std::array<std::size_t, 2> near_two(const Candidates<T>& candidates, LocalId self,
                                    const std::array<std::array<T, 3>, 2>& p,
                                    const std::array<std::uint16_t*, 2>& out) {
  const hn::ScalableTag<T> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto x0 = hn::Set(d, p[0][0]), y0 = hn::Set(d, p[0][1]), z0 = hn::Set(d, p[0][2]);
  const auto x1 = hn::Set(d, p[1][0]), y1 = hn::Set(d, p[1][1]), z1 = hn::Set(d, p[1][2]);
  const auto self0 = hn::Set(di, self), self1 = hn::Set(di, self + 1);
  const auto limit = hn::Set(d, static_cast<T>(Packed<T>::units_per_h * Packed<T>::units_per_h));
  const T *all_x = candidates.x.data(), *all_y = candidates.y.data(), *all_z = candidates.z.data();
  const auto* all_index = candidates.index.data();
  const std::size_t size = candidates.size();
  std::uint16_t *out0 = out[0], *out1 = out[1];
  for (std::size_t k = 0; k < size; k += hn::Lanes(d)) {
    const auto x = hn::LoadU(d, all_x + k), y = hn::LoadU(d, all_y + k), z = hn::LoadU(d, all_z + k);
    const auto index = hn::LoadU(di, all_index + k);
    const auto add = [&](auto px, auto py, auto pz, auto own, std::uint16_t*& to) HWY_ATTR {
      const auto dx = hn::Sub(x, px), dy = hn::Sub(y, py), dz = hn::Sub(z, pz);
      const auto r2 = hn::MulAdd(dz, dz, hn::MulAdd(dy, dy, hn::Mul(dx, dx)));
      const auto other = hn::RebindMask(d, hn::Ne(index, own));
      const Chosen<decltype(d)> chosen(d, hn::And(other, hn::Lt(r2, limit)));
      store_indices(d, hn::BitCast(di, chosen.first(hn::BitCast(d, index))), to);
      to += chosen.count();
    };
    add(x0, y0, z0, self0, out0);
    add(x1, y1, z1, self1, out1);
  }
  return {static_cast<std::size_t>(out0 - out[0]), static_cast<std::size_t>(out1 - out[1])};
}

// Copies whole vectors.
inline void copy_codes(const std::uint16_t* from, std::size_t count, std::uint16_t* to) {
  const hn::CappedTag<std::uint16_t, Candidates<float>::padding / 2> d;
  for (std::size_t k = 0; k < count; k += hn::Lanes(d)) hn::StoreU(hn::LoadU(d, from + k), d, to + k);
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

// Moves the chosen lanes of a vector to its front, keeping their order. Highway's own Compress is used if the processor
// has an instruction for it; otherwise Highway before 1.1 keeps its tables in local arrays, which GCC copies to the
// stack at every use, so that a search spends most of its time there. Included once per instruction set, inside the
// sources that Highway compiles repeatedly.
#if !defined(TREVI_PARTICLES_COMPRESS_TABLE)
#define TREVI_PARTICLES_COMPRESS_TABLE

#include <array>
#include <cstddef>
#include <cstdint>

namespace trevi {

// Row m: the indices of the bits set in m, in ascending order, then zeros.
inline constexpr auto places_of_bits = [] {
  std::array<std::array<std::uint8_t, 8>, 256> table{};
  for (std::size_t m = 0; m < table.size(); ++m) {
    std::size_t found = 0;
    for (std::size_t bit = 0; bit < 8; ++bit) {
      if ((m >> bit & 1) != 0) table[m][found++] = static_cast<std::uint8_t>(bit);
    }
  }
  return table;
}();

}  // namespace trevi
#endif

#if defined(TREVI_PARTICLES_COMPRESS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TREVI_PARTICLES_COMPRESS_INL
#undef TREVI_PARTICLES_COMPRESS_INL
#else
#define TREVI_PARTICLES_COMPRESS_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// AVX-512 compresses 32-bit lanes in a register; its 64-bit lanes go through Highway's table, too.
template <class D>
inline constexpr bool has_compress_instruction = HWY_TARGET <= HWY_AVX3 && sizeof(hn::TFromD<D>) == 4;

template <class D>
class Chosen;

template <class D>
requires(has_compress_instruction<D>) class Chosen<D> {
 public:
  HWY_INLINE Chosen(D d, hn::Mask<D> mask) : mask_(mask), count_(hn::CountTrue(d, mask)) {}
  HWY_INLINE hn::Vec<D> first(hn::Vec<D> v) const { return hn::Compress(v, mask_); }
  HWY_INLINE std::size_t count() const { return count_; }

 private:
  hn::Mask<D> mask_;
  std::size_t count_;
};

template <class D>
requires(!has_compress_instruction<D>) class Chosen<D> {
 public:
  HWY_INLINE Chosen(D d, hn::Mask<D> mask) : indices_(indices(d, bits_of(d, mask))), count_(hn::CountTrue(d, mask)) {}
  HWY_INLINE hn::Vec<D> first(hn::Vec<D> v) const { return hn::TableLookupLanes(v, indices_); }
  HWY_INLINE std::size_t count() const { return count_; }

 private:
  static HWY_INLINE std::size_t bits_of(D d, hn::Mask<D> mask) {
    static_assert(hn::MaxLanes(D()) <= 8);
    std::uint8_t bits[8];
    hn::StoreMaskBits(d, mask, bits);
    return bits[0];
  }
  static HWY_INLINE auto indices(D d, std::size_t bits) {
    const hn::Rebind<std::uint8_t, D> d8;
    const hn::Rebind<std::int32_t, D> d32;
    const auto as32 = hn::PromoteTo(d32, hn::LoadU(d8, places_of_bits[bits].data()));
    if constexpr (sizeof(hn::TFromD<D>) == 8) {
      return hn::IndicesFromVec(d, hn::PromoteTo(hn::RebindToSigned<D>(), as32));
    } else {
      return hn::IndicesFromVec(d, as32);
    }
  }

  decltype(indices(D(), 0)) indices_;
  std::size_t count_;
};

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#endif

// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/row_fits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/row_faces.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own headers after foreach_target.
#include <hwy/highway.h>

#include "projection/row_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// What the particles of the cell at one side of a face say of it: their weight and weighted sum, and, where that is
// little, their number and what their fit says, times the number.
struct Side {
  V weight, value, n, fitted;
};

// The place of Σ y_a y_b among the moments.
constexpr std::size_t second(std::size_t a, std::size_t b) { return 4 + (a == b ? a : a + b + 2); }

// `middle` of the face in cells from the corner of that cell. The weight of a particle falls from 1 at the face to 0 a
// cell away.
template <bool below>
HWY_INLINE Side side_of(const ConstCellRow& moments, const ConstCellRow& fit, std::size_t i, const V3& middle) {
  const auto weighted = [&](std::size_t sum, std::size_t with_y) {
    return below ? load(moments, with_y) : hn::Sub(load(moments, sum), load(moments, with_y));
  };
  const V n = load(moments, 0), weight = weighted(0, 1 + i);
  V value = weighted(10 + i, 13 + 4 * i), at = load(fit, 1 + i);
  for (std::size_t j = 0; j < 3; ++j) {
    const V slope = load(fit, 4 + 3 * i + j);
    value = hn::MulAdd(slope, hn::MulSub(middle[j], weight, weighted(1 + j, second(i, j))), value);
    at = hn::MulAdd(slope, middle[j], at);
  }
  return {weight, value, n, hn::Mul(n, at)};
}

HWY_INLINE ConstCellRow from(const ConstCellRow& row, std::size_t c) { return {row.first + c, row.width}; }

void displace_faces_of(const FaceRow& faces, std::size_t count, Real* out) {
  const V zero = set(0), one = set(1);
  for (Part part{0, count}; part.begin < count; part.begin += hn::Lanes(Wide())) {
    const std::size_t c = part.begin, i = faces.axis;
    V3 low = zeros();
    for (std::size_t a = 0; a < 3; ++a) low[a] = load(faces.middle[a], part);
    V3 high = low;
    low[i] = zero;
    high[i] = one;
    const Side over = side_of<false>(from(faces.moments_above, c), from(faces.fit_above, c), i, low);
    const Side under = side_of<true>(from(faces.moments_below, c), from(faces.fit_below, c), i, high);
    const V weight = hn::Add(over.weight, under.weight), n = hn::Add(over.n, under.n);
    const auto enough = hn::Ge(weight, set(projection::least_face_weight)), any = hn::Gt(n, zero);
    const V sum = hn::IfThenElse(enough, hn::Add(over.value, under.value), hn::Add(over.fitted, under.fitted));
    const V of = hn::IfThenElse(enough, weight, hn::IfThenElse(any, n, one));
    store(hn::IfThenElseZero(any, hn::Div(sum, of)), part, {out, 0}, 0);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(displace_faces_of);

void displace_faces(const FaceRow& faces, std::size_t count, Real* out) {
  HWY_DYNAMIC_DISPATCH(displace_faces_of)(faces, count, out);
}

}  // namespace trevi
#endif

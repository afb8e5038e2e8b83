// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "projection/row_fits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "projection/row_faces.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

#include "projection/row_vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

// Contributions of the particles of the cells on one side of a row of faces: their weight and weighted sum, and, for
// faces where the weight is small, their number and the value of their fit times this number.
struct Sides {
  std::vector<Real> weight, value, n, fitted;
  template <class Use>
  HWY_INLINE void for_each(const Use& use) {
    use(weight), use(value), use(n), use(fitted);
  }
};

// The index of Σ y_a y_b in the moments.
constexpr std::size_t second(std::size_t a, std::size_t b) { return 4 + (a == b ? a : a + b + 2); }

// For the cells of a row and the faces from number `first` on. The weight of a particle falls from 1 at the face to 0
// one cell away.
template <bool below>
HWY_INLINE void find_sides(const FaceRow& faces, std::size_t first, std::size_t count, Sides& sides) {
  const RowBeside& row = below ? faces.below : faces.above;
  const std::size_t i = faces.axis;
  sides.for_each([&](std::vector<Real>& of) { of.assign(first + count + 2 * max_lanes, 0.0); });
  for (Part part{0, count}; part.begin < part.end; ++part) {
    if (!part.is_in(row.moments)) continue;
    const Numbers<> moments{part.of(row.moments)}, fit{part.of(row.fit)};
    const std::size_t face = first + part.begin;
    const auto weighted = [&](std::size_t sum, std::size_t with_y) {
      return below ? moments[with_y] : hn::Sub(moments[sum], moments[with_y]);
    };
    const V weight = weighted(0, 1 + i);
    V value = weighted(10 + i, 13 + 4 * i), at = fit[1 + i];
    for (std::size_t j = 0; j < 3; ++j) {
      const V middle = j == i ? set(below ? 1 : 0) : hn::LoadU(Wide(), faces.middle[j] + face);
      const V slope = fit[4 + 3 * i + j];
      value = hn::MulAdd(slope, hn::MulSub(middle, weight, weighted(1 + j, second(i, j))), value);
      at = hn::MulAdd(slope, middle, at);
    }
    const auto write_side = [&](V v, std::vector<Real>& of) { hn::StoreU(v, Wide(), of.data() + face); };
    write_side(weight, sides.weight);
    write_side(value, sides.value);
    write_side(moments[0], sides.n);
    write_side(hn::Mul(moments[0], at), sides.fitted);
  }
}

// Whether there are particles in any cell beside the next faces. Along a row the cell below a face is the preceding
// one.
HWY_INLINE bool are_wet(const FaceRow& faces, const Part& part, std::size_t cells) {
  if (faces.repeats) return true;
  if (faces.along && part.begin > 0 && faces.below.moments.has((part.begin - 1) / max_lanes)) return true;
  return part.begin < cells && (part.is_in(faces.above.moments) || part.is_in(faces.below.moments));
}

void displace_faces_of(const FaceRow& faces, std::size_t count, Real* out) {
  static thread_local Sides over, under;
  const std::size_t cells = count - (faces.along ? 1 : 0);
  find_sides<false>(faces, 0, cells, over);
  find_sides<true>(faces, count - cells, cells, under);
  if (faces.repeats) {
    over.for_each([&](std::vector<Real>& of) { of[cells] = of[0]; });
    under.for_each([&](std::vector<Real>& of) { of[0] = of[cells]; });
  }
  const V zero = set(0), one = set(1);
  for (Part part{0, count}; part.begin < part.end; ++part) {
    if (!are_wet(faces, part, cells)) continue;
    const auto sum = [&](const std::vector<Real>& a, const std::vector<Real>& b) {
      return hn::Add(load(a.data(), part), load(b.data(), part));
    };
    const V weight = sum(over.weight, under.weight), n = sum(over.n, under.n);
    const auto enough = hn::Ge(weight, set(projection::min_face_weight)), any = hn::Gt(n, zero);
    const V value = hn::IfThenElse(enough, sum(over.value, under.value), sum(over.fitted, under.fitted));
    const V of = hn::IfThenElse(enough, weight, hn::IfThenElse(any, n, one));
    store(hn::IfThenElseZero(any, hn::Div(value, of)), part, out);
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

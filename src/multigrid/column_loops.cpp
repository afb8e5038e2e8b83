// Compiled once per instruction set (Highway's foreach_target), chosen at run time.
#include "multigrid/column_loops.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "multigrid/column_loops.cpp"
#include <hwy/foreach_target.h>
// Highway requires its own headers to be included after foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace trevi {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Calls put(tag, c) for vectors from cell c on, and one by one for the rest. Vectors have at most four lanes, because
// few columns have more cells.
template <class Put>
HWY_INLINE void for_each_vector(std::size_t count, const Put& put) {
  const hn::CappedTag<double, 4> d;
  const hn::CappedTag<double, 1> one;
  std::size_t c = 0;
  for (; c + hn::Lanes(d) <= count; c += hn::Lanes(d)) put(d, c);
  for (; c < count; ++c) put(one, c);
}

void gather(const ColumnOfLevel& of, Real* HWY_RESTRICT y) {
  const Real *const x = of.x, *const wx = of.wx, *const wy = of.wy, *const rhs = of.rhs;
  const std::size_t row = of.row, plane = of.plane;
  for_each_vector(of.count, [=](auto d, std::size_t c) {
    const auto part = [=](const Real* w, const Real* field) { return hn::Mul(hn::LoadU(d, w), hn::LoadU(d, field)); };
    const auto over_planes = hn::Add(part(wx + c, x + c - plane), part(wx + c + plane, x + c + plane));
    const auto over_rows = hn::Add(part(wy + c, x + c - row), part(wy + c + row, x + c + row));
    hn::StoreU(hn::Add(hn::LoadU(d, rhs + c), hn::Add(over_planes, over_rows)), d, y + c);
  });
}

void residual(const ColumnOfLevel& of, const LinksUpwards& up, Real* HWY_RESTRICT y) {
  const Real *const x = of.x, *const wx = of.wx, *const wy = of.wy, *const rhs = of.rhs;
  const Real *const wz = up.wz, *const dirichlet = up.dirichlet, *const per = up.per;
  const std::size_t row = of.row, plane = of.plane;
  for_each_vector(of.count, [=](auto d, std::size_t c) {
    const auto here = hn::LoadU(d, x + c);
    const auto from = [=](const Real* w, const Real* beside) {
      return hn::Mul(hn::LoadU(d, w), hn::Sub(hn::LoadU(d, beside), here));
    };
    const auto over_planes = hn::Add(from(wx + c, x + c - plane), from(wx + c + plane, x + c + plane));
    const auto over_rows = hn::Add(from(wy + c, x + c - row), from(wy + c + row, x + c + row));
    const auto up_and_down = hn::Add(from(wz + c, x + c - 1), from(wz + c + 1, x + c + 1));
    const auto flow = hn::Add(hn::Add(over_planes, over_rows), up_and_down);
    const auto left = hn::Sub(hn::LoadU(d, rhs + c), hn::Mul(hn::LoadU(d, dirichlet + c), here));
    const auto is_water = hn::Gt(hn::LoadU(d, per + c), hn::Zero(d));
    hn::StoreU(hn::IfThenElseZero(is_water, hn::Add(left, flow)), d, y + c);
  });
}

void damp_of(const Real* HWY_RESTRICT x, Real weight, std::size_t count, Real* HWY_RESTRICT y) {
  for_each_vector(count, [=](auto d, std::size_t c) {
    const auto before = hn::LoadU(d, x + c);
    hn::StoreU(hn::Add(before, hn::Mul(hn::Set(d, weight), hn::Sub(hn::LoadU(d, y + c), before))), d, y + c);
  });
}

void add_to_water(const Real* HWY_RESTRICT x, const Real* HWY_RESTRICT per, std::size_t count, Real* HWY_RESTRICT y) {
  for_each_vector(count, [=](auto d, std::size_t c) {
    const auto is_water = hn::Gt(hn::LoadU(d, per + c), hn::Zero(d));
    hn::StoreU(hn::Add(hn::LoadU(d, y + c), hn::IfThenElseZero(is_water, hn::LoadU(d, x + c))), d, y + c);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace trevi
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace trevi {

HWY_EXPORT(gather);
HWY_EXPORT(residual);
HWY_EXPORT(damp_of);
HWY_EXPORT(add_to_water);

void gather_sides(const ColumnOfLevel& of, Real* y) { HWY_DYNAMIC_DISPATCH(gather)(of, y); }

void find_residual_of(const ColumnOfLevel& of, const LinksUpwards& up, Real* y) {
  HWY_DYNAMIC_DISPATCH(residual)(of, up, y);
}

void damp(const Real* x, Real weight, std::size_t count, Real* y) {
  HWY_DYNAMIC_DISPATCH(damp_of)(x, weight, count, y);
}

void add_where_water(const Real* x, const Real* per, std::size_t count, Real* y) {
  HWY_DYNAMIC_DISPATCH(add_to_water)(x, per, count, y);
}

}  // namespace trevi
#endif

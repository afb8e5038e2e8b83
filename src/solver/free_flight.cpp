#include "solver/free_flight.hpp"

#include "base/threads.hpp"

namespace trevi {

template <class T>
bool FreeFlight<T>::is_clear(const Vec3& p) const {
  const Box& box = boundary_.walls().box();
  for (int a = 0; a < 3; ++a) {
    if (gravity_[a] < 0 ? p[a] < box.min[a] + h_ : gravity_[a] > 0 && p[a] > box.max[a] - h_) return false;
  }
  const Obstacles* obstacles = boundary_.obstacles();
  return obstacles == nullptr || !obstacles->is_near(p);
}

template <class T>
void FreeFlight<T>::borrow(Range all, Scratch& scratch) {
  if (!flies_.empty()) return;
  flies_ = scratch.borrow<T>(static_cast<std::size_t>(all.end));
  for_each_index(all, [&](std::size_t i) { flies_[i] = 0; });
}

template <class T>
void FreeFlight<T>::find(Range all, std::span<const Vec4<T>> displacements, std::span<const Vec3> p, Scratch& scratch) {
  borrow(all, scratch);
  for_each_index(all, [&](std::size_t i) {
    if (!may_fly(displacements[i]) || !is_clear(p[i])) return;
    const Real carried = vector_of(displacements[i]).squaredNorm() / lift_in_full().squaredNorm();
    flies_[i] = static_cast<T>(std::max(1 - carried, 0.0) * left_by_pumps(i));
  });
}

template <class T>
void FreeFlight<T>::let_fly(Range all, std::span<const Range> some, Scratch& scratch) {
  if (gravity_.isZero(0) || some.empty()) return;
  borrow(all, scratch);
  constexpr LocalId part_size = 16;
  for_each_part({0, static_cast<LocalId>(some.size())}, part_size, [&](Range part) {
    for (LocalId n = part.begin; n < part.end; ++n) {
      const Range& range = some[static_cast<std::size_t>(n)];
      for (auto i = static_cast<std::size_t>(range.begin); i < static_cast<std::size_t>(range.end); ++i)
        flies_[i] = let + static_cast<T>(left_by_pumps(i));
    }
  });
}

template <class T>
void FreeFlight<T>::land(Range all, std::span<const T> multipliers) {
  if (flies_.empty()) return;
  for_each_index(all, [&](std::size_t i) {
    if (multipliers[i] != 0 && flies_[i] < let) flies_[i] = 0;
  });
}

template <class T>
void FreeFlight<T>::lift(Range all, std::span<Vec3> p) const {
  if (flies_.empty()) return;
  const Vec3 in_full = lift_in_full();
  for_each_index(all, [&](std::size_t i) {
    if (flies_[i] > 0) p[i] = boundary_.collide(p[i], share(i) * in_full);
  });
}

template class FreeFlight<float>;
template class FreeFlight<double>;

}  // namespace trevi

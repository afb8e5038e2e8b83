#include "fluid/filters/velocity_filter.hpp"

#include "base/threads.hpp"

namespace trevi {

template <class T>
Borrowed<Vec4<T>> own_velocities(const Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  Borrowed<Vec4<T>> all = near.scratch().template borrow<Vec4<T>>(near.records().size());
  Vec4<T>* const owned = all.data() + near.order().low_ghosts();
  for_each_index({0, near.order().owned()}, [&](std::size_t i) {
    const Vec3& v = velocity[i];
    owned[i] = {static_cast<T>(v.x()), static_cast<T>(v.y()), static_cast<T>(v.z()), T{0}};
  });
  return all;
}

template Borrowed<Vec4<float>> own_velocities(const Neighbourhood<float>&, const std::vector<Vec3>&);
template Borrowed<Vec4<double>> own_velocities(const Neighbourhood<double>&, const std::vector<Vec3>&);

}  // namespace trevi

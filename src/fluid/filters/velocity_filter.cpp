#include "fluid/filters/velocity_filter.hpp"

#include "base/growth.hpp"
#include "base/threads.hpp"

namespace trevi {

template <class T>
const Vec4<T>* VelocityField<T>::refresh(Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  write(near, velocity);
  near.exchange_vectors(vectors_);
  return vectors_.data();
}

template <class T>
Vec4<T>* VelocityField<T>::write(const Neighbourhood<T>& near, const std::vector<Vec3>& velocity) {
  resize_tightly(vectors_, near.records().size());
  Vec4<T>* owned = vectors_.data() + near.order().low_ghosts();
  for_each_index({0, near.order().owned()}, [&](std::size_t i) {
    const Vec3& v = velocity[i];
    owned[i] = {static_cast<T>(v.x()), static_cast<T>(v.y()), static_cast<T>(v.z()), T{0}};
  });
  return owned;
}

template <class T>
const Vec4<T>* VelocityField<T>::exchange(Neighbourhood<T>& near) {
  near.exchange(vectors_);
  return vectors_.data();
}

template class VelocityField<float>;
template class VelocityField<double>;

}  // namespace trevi

#include "kernels/kernels.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "kernels/lattice_points.hpp"
#include "kernels/list-inl.hpp"
#include "trevi/error.hpp"

namespace trevi {

namespace {

template <class K, class... Listed>
constexpr std::size_t index_of(std::type_identity<std::tuple<Listed...>>) {
  static_assert((std::is_same_v<K, Listed> || ...), "a kernel names another for its gradient that is not in the list");
  std::size_t index = 0;
  for (const bool found : {std::is_same_v<K, Listed>...}) {
    if (found) return index;
    ++index;
  }
  return index;
}

// The two-dimensional form of a kernel: the same shape with another factor.
template <class K>
struct InPlane {
  static constexpr Real per_space(Real h) { return K::in_plane * h; }
  static Real factor(Real h) { return per_space(h) * K::factor(h); }
  static Real slope_factor(Real h) { return per_space(h) * K::slope_factor(h); }
  static Real steepest(Real h) { return per_space(h) * K::steepest(h); }
  static Real value(const Vec3& r, Real h) { return per_space(h) * K::value(r, h); }
  static Vec3 gradient(const Vec3& r, Real h) { return per_space(h) * K::gradient(r, h); }
};

template <class... Listed>
constexpr std::array<Kernel, sizeof...(Listed)> described(std::type_identity<std::tuple<Listed...>> list) {
  return {Kernel{Listed::name, 3, index_of<Listed>(list), index_of<typename Listed::Gradient>(list), Listed::factor,
                 Listed::slope_factor, Listed::steepest, Listed::value, Listed::gradient}...};
}

template <class... Listed>
constexpr std::array<Kernel, sizeof...(Listed)> described_in_plane(std::type_identity<std::tuple<Listed...>> list) {
  return {Kernel{Listed::name, 2, index_of<Listed>(list), index_of<typename Listed::Gradient>(list),
                 InPlane<Listed>::factor, InPlane<Listed>::slope_factor, InPlane<Listed>::steepest,
                 InPlane<Listed>::value, InPlane<Listed>::gradient}...};
}

}  // namespace

PointLattice lattice_of(const FluidSettings& fluid) { return {fluid.spacing, fluid.dimensions}; }

std::span<const Kernel> all_kernels(int dimensions) {
  static constexpr auto all = described(std::type_identity<KernelList>());
  static constexpr auto in_plane = described_in_plane(std::type_identity<KernelList>());
  return dimensions == 2 ? in_plane : all;
}

std::vector<std::string> kernel_names() {
  std::vector<std::string> names;
  for (const Kernel& kernel : all_kernels()) names.emplace_back(kernel.name);
  return names;
}

const Kernel& kernel_named(std::string_view name, int dimensions) {
  for (const Kernel& kernel : all_kernels(dimensions))
    if (kernel.name == name) return kernel;
  throw InputError(fmt::format("there is no kernel \"{}\"; take one of {}", name, fmt::join(kernel_names(), ", ")));
}

Kernels kernels_of(const FluidSettings& fluid) {
  const Kernel& density = kernel_named(fluid.density_kernel, fluid.dimensions);
  return {density, fluid.gradient_kernel.given() ? kernel_named(fluid.gradient_kernel.value(), fluid.dimensions)
                                                 : all_kernels(fluid.dimensions)[density.gradient_index]};
}

Real lattice_density_sum(const Kernel& kernel, const PointLattice& lattice, Real h) {
  Real sum = 0;
  for_each_lattice_point(lattice, h, [&](const Vec3& offset) { sum += kernel.value(offset, h); });
  return sum;
}

Real friction_weight(Real u2, int dimensions) {
  const Real rest = std::max(1 - u2, 0.0);
  return rest * (dimensions == 2 ? rest : std::sqrt(rest));
}

Real lattice_friction_sum(const PointLattice& lattice, Real h) {
  Real sum = 0;
  for_each_lattice_point(lattice, h,
                         [&](const Vec3& r) { sum += friction_weight(r.squaredNorm() / (h * h), lattice.dimensions); });
  return sum;
}

Real lattice_laplacian_moment(const PointLattice& lattice, Real h) {
  Real sum = 0;
  for_each_lattice_point(lattice, h, [&](const Vec3& r) {
    sum += r.x() * r.x() * friction_weight(r.squaredNorm() / (h * h), lattice.dimensions);
  });
  return sum / 2;
}

Real lattice_laplacian_truncation(const PointLattice& lattice, Real h) {
  Real fourth = 0, second = 0;
  for_each_lattice_point(lattice, h, [&](const Vec3& r) {
    const Real r2 = r.squaredNorm(), weighted = r2 * friction_weight(r2 / (h * h), lattice.dimensions);
    fourth += r2 * weighted;
    second += weighted;
  });
  return fourth / (4 * (lattice.dimensions + 2) * second);
}

int lattice_neighbours(const PointLattice& lattice, Real h) {
  int points = 0;
  for_each_lattice_point(lattice, h, [&](const Vec3&) { ++points; });
  return points - 1;
}

namespace {

// sin(π q/12) for q = 0 ... 23, without a library function, whose last bit may depend on the processor.
std::array<Real, 24> sines_of_twelfths() {
  const Real twice_cosine = (std::sqrt(6.0) + std::sqrt(2.0)) / 2;
  std::array<Real, 24> sine{};
  sine[1] = (std::sqrt(6.0) - std::sqrt(2.0)) / 4;
  for (std::size_t q = 2; q <= 12; ++q) sine[q] = twice_cosine * sine[q - 1] - sine[q - 2];
  for (std::size_t q = 0; q < 12; ++q) sine[q + 12] = -sine[q];
  return sine;
}

}  // namespace

Real lattice_jacobi_eigenvalue(const Kernels& kernels, const PointLattice& lattice, Real h, Real volume, Real epsilon) {
  struct Neighbour {
    std::array<int, 3> position;
    Vec3 dense, push;
  };
  std::vector<Neighbour> neighbours;
  Real diagonal = epsilon;
  for_each_lattice_point(lattice, h, [&](const Vec3& r) {
    const auto index = [&](Real x) { return static_cast<int>(std::lround(x / lattice.spacing)); };
    neighbours.push_back({{index(r.x()), index(r.y()), index(r.z())},
                          volume * kernels.density.gradient(r, h),
                          volume * kernels.gradient.gradient(r, h)});
    diagonal += neighbours.back().push.squaredNorm();
  });
  const std::array<Real, 24> sine = sines_of_twelfths();
  Real largest = 0;
  // k = π/spacing (x, y, z)/12 with 12 >= x >= y >= z >= 0; the other waves are mirror images. In two dimensions y has
  // no effect.
  for (int x = 0; x <= 12; ++x) {
    for (int y = 0; y <= x; ++y) {
      for (int z = 0; z <= y; ++z) {
        Vec3 dense = Vec3::Zero(), push = Vec3::Zero();
        for (const Neighbour& n : neighbours) {
          const int q = (x * n.position[0] + y * n.position[1] + z * n.position[2]) % 24;
          const Real s = sine[static_cast<std::size_t>(q < 0 ? q + 24 : q)];
          dense += s * n.dense;
          push += s * n.push;
        }
        largest = std::max(largest, dense.dot(push) / diagonal);
      }
    }
  }
  return largest;
}

}  // namespace trevi

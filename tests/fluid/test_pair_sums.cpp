// The sums over neighbours against brute force in double precision, for every kernel of the list for densities with
// every one for gradients, every precision and instruction set that this machine can be made to use, with pairs that
// have drifted since the search. The brute force takes W and its gradient of each kernel from its description. An error
// is measured against the sum of the absolute terms: 1e-12 of it in double precision, 1e-5 in single.
#include <Eigen/Geometry>
#include <map>
#include <random>

#include "base/simd.hpp"
#include "fluid/pairs/pair_sums.hpp"
#include "fluid/pairs/particle_loops.hpp"
#include "support/distributed.hpp"

namespace trevi::test {
namespace {

constexpr Tensile tensile{0.03, 4, 0.25};

/// What the loops see of a particle, in double precision: place in units of h as the records hold it.
struct Seen {
  Vec3 place, velocity;
  Eigen::Matrix3d half_gradient;
  Real w, weight;
};

Vec3 velocity_of(GlobalId id) { return Vec3(std::sin(0.1 * id), std::cos(0.7 * id), std::sin(1.3 * id)); }
Real scalar_of(GlobalId id) { return std::cos(0.37 * id); }
Real weight_of(GlobalId id) { return 1 + std::sin(0.53 * id); }
Vec3 drift_of(GlobalId id) { return 0.3 * radius * velocity_of(3 * id); }

/// Sums of one particle that a constraint with these kernels asks for, and of the absolute values of their terms.
struct ConstraintSums {
  Kernels kernels;
  Vec3 along = Vec3::Zero(), delta = Vec3::Zero(), tensile_delta = Vec3::Zero();
  Real value = 0, squares = 0, scale = 0.01;  // the scale is never nothing

  void add(const Seen& i, const Seen& j) {
    const Vec3 d = i.place - j.place;
    const Real q = 1 - d.squaredNorm(), w = kernels.density.value(d, 1) / kernels.density.factor(1);
    if (q <= 0) return;
    const Vec3 g = -kernels.gradient.gradient(d, 1) / kernels.gradient.slope_factor(1);
    const Real s_corr = -tensile.k * std::pow(std::pow(q / (1 - tensile.dq * tensile.dq), 3), tensile.n);
    along += g;
    value += w;
    squares += g.squaredNorm();
    delta += (i.w + j.w) * g;
    tensile_delta += (i.w + j.w + s_corr) * g;
    scale += g.norm() + w + std::abs(s_corr);
  }
};

/// The same of the velocity filters: Spiky's gradient, Poly6's value, and the weight of friction in both dimensions.
struct FilterSums {
  using Matrix = Eigen::Matrix3d;
  Vec3 curl = Vec3::Zero(), gradient = Vec3::Zero(), smoothing = Vec3::Zero(), friction[2] = {smoothing, smoothing};
  Matrix slopes[2] = {Matrix::Zero(), Matrix::Zero()}, moments[2] = {Matrix::Zero(), Matrix::Zero()};
  Real scale = 0.01;

  void add(const Seen& i, const Seen& j) {
    const Vec3 d = i.place - j.place;
    const Real u = d.norm(), t = 1 - u, q = 1 - u * u;
    if (u >= 1) return;
    const Vec3 along = t * t * d / u;
    curl += (j.velocity - i.velocity).cross(along);
    gradient += (j.w - i.w) * along;
    smoothing += (j.velocity - i.velocity) * q * q * q;
    for (const int k : {0, 1}) {
      const Real weight = friction_weight(u * u, k + 2);
      const Vec3 turned = (i.half_gradient + j.half_gradient).transpose() * (j.place - i.place);
      friction[k] += (i.weight + j.weight) * (j.velocity - i.velocity + turned) * weight;
      slopes[k] += weight * (i.velocity - j.velocity) * d.transpose();
      moments[k] += weight * d * d.transpose();
    }
    scale += t * t + std::pow(q, 1.5);
  }
};

template <class T>
class PairSumsOf : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PairSumsOf, Precisions);

template <class T>
void expect_near(const Vec4<T>& found, const Vec3& expected, Real scale) {
  EXPECT_LT((vector_of(found) - expected).norm(), (std::is_same_v<T, float> ? 1e-5 : 1e-12) * scale);
}

/// A cloud whose neighbours were found before the particles drifted, with scalars and velocities from their ids.
template <class T>
struct Drifted : Distributed<T> {
  explicit Drifted(const Cloud& all) : Distributed<T>(all) {
    std::vector<Vec3> places = this->particles.predicted;
    for (std::size_t k = 0; k < places.size(); ++k) places[k] += drift_of(this->particles.id[k]);
    this->near.encode(places, this->near.all());
    for (LocalId i = 0; i < this->near.order().owned(); ++i)
      this->near.record(i).w = static_cast<T>(scalar_of(this->particles.id[static_cast<std::size_t>(i)]));
    this->near.halo().exchange(this->near.records());
    for (const GlobalId particle : this->id) {
      const Vec3 v = velocity_of(particle);
      velocity.push_back({static_cast<T>(v.x()), static_cast<T>(v.y()), static_cast<T>(v.z()), T{0}});
      for (int a = 0; a < 3; ++a) {
        const Vec3 row = velocity_of(particle + 7 * a) / Packed<T>::units_per_h;
        gradient[a].push_back({static_cast<T>(row.x()), static_cast<T>(row.y()), static_cast<T>(row.z()),
                               static_cast<T>(weight_of(particle))});
      }
    }
  }

  Seen seen(std::size_t k) const {
    const Packed<T>& r = this->near.records()[k];
    Eigen::Matrix3d half;
    for (int a = 0; a < 3; ++a) half.row(a) = vector_of(gradient[a][k]) * Packed<T>::units_per_h;
    return {Vec3(r.x, r.y, r.z) / Packed<T>::units_per_h, vector_of(velocity[k]), half, static_cast<Real>(r.w),
            static_cast<Real>(gradient[2][k].w)};
  }

  template <class Sums>
  Sums brute_force(LocalId i, Sums sums) const {
    const auto self = static_cast<std::size_t>(this->near.order().low_ghosts() + i);
    for (const LocalId j : this->near.list()[i]) sums.add(seen(self), seen(static_cast<std::size_t>(j)));
    return sums;
  }

  VelocityGradients<T> gradients() const { return {gradient[0].data(), gradient[1].data(), gradient[2].data()}; }

  std::vector<Vec4<T>> velocity, gradient[3];
};

/// What the loops of the instruction set in use write for the owned particles [begin, end).
template <class T>
struct FoundByConstraint {
  std::vector<Vec4<T>> density, delta, tensile_delta;
  std::vector<T> squares;

  FoundByConstraint(const Drifted<T>& d, const Kernels& kernels, Range range) {
    const auto n = static_cast<std::size_t>(range.size());
    for (auto* field : {&density, &delta, &tensile_delta}) field->resize(n);
    squares.resize(n);
    const Pairs<T> pairs{d.near.records(), d.near.list(), d.near.order().low_ghosts()};
    const ConstraintLoops<T> loops = constraint_loops<T>(kernels);
    loops.density(pairs, range, density.data(), squares.data());
    loops.delta(pairs, range, delta.data());
    loops.tensile_delta(pairs, range, tensile, tensile_delta.data());
  }
};

template <class T>
struct FoundByFilters {
  std::vector<Vec4<T>> curl, gradient, smoothing, friction[2];
  std::vector<VelocityFit<T>> fit[2];

  FoundByFilters(const Drifted<T>& d, Range range) {
    const auto n = static_cast<std::size_t>(range.size());
    for (auto* field : {&curl, &gradient, &smoothing}) field->resize(n);
    const Pairs<T> pairs{d.near.records(), d.near.list(), d.near.order().low_ghosts()};
    const FilterLoops<T> loops = filter_loops<T>();
    loops.curl(pairs, range, d.velocity.data(), curl.data());
    loops.gradient(pairs, range, gradient.data());
    loops.smoothing(pairs, range, d.velocity.data(), smoothing.data());
    for (const int k : {0, 1}) {
      friction[k].resize(n);
      fit[k].resize(n);
      friction_loops<T>(k + 2).friction(pairs, range, d.velocity.data(), d.gradients(), friction[k].data());
      friction_loops<T>(k + 2).velocity_fit(pairs, range, d.velocity.data(), fit[k].data());
    }
  }
};

std::vector<Kernels> all_pairs_of_kernels() {
  std::vector<Kernels> all;
  for (const Kernel& density : all_kernels())
    for (const Kernel& gradient : all_kernels()) all.push_back({density, gradient});
  return all;
}

template <class T>
void expect_brute_force(const Drifted<T>& d, const Kernels& kernels) {
  SCOPED_TRACE(std::string(kernels.density.name) + ", gradient of " + std::string(kernels.gradient.name));
  const LocalId owned = d.near.order().owned();
  const FoundByConstraint<T> found(d, kernels, {0, owned});
  for (LocalId i = 0; i < owned; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const ConstraintSums sums = d.brute_force(i, ConstraintSums{kernels});
    expect_near(found.density[k], sums.along, sums.scale);
    expect_near(found.delta[k], sums.delta, 2 * sums.scale);
    expect_near(found.tensile_delta[k], sums.tensile_delta, 2 * sums.scale);
    expect_near(Vec4<T>{found.density[k].w, found.squares[k], 0, 0}, Vec3(sums.value, sums.squares, 0), sums.scale);
  }
}

template <class T>
void expect_brute_force(const Drifted<T>& d) {
  const LocalId owned = d.near.order().owned();
  const FoundByFilters<T> found(d, {0, owned});
  for (LocalId i = 0; i < owned; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const FilterSums sums = d.brute_force(i, FilterSums{});
    expect_near(found.curl[k], sums.curl, 3 * sums.scale);
    expect_near(found.gradient[k], sums.gradient, 2 * sums.scale);
    expect_near(found.smoothing[k], sums.smoothing, 3 * sums.scale);
    for (const int m : {0, 1}) {
      expect_near(found.friction[m][k], sums.friction[m], 4 * 6 * sums.scale);
      const auto& row = found.fit[m][k].row;
      for (int a = 0; a < 3; ++a) {
        expect_near(row[a], sums.slopes[m].row(a), 3 * sums.scale);
        expect_near(Vec4<T>{row[a].w, 0, 0, 0}, Vec3(sums.moments[m](a, a), 0, 0), sums.scale);
      }
      expect_near(row[3], Vec3(sums.moments[m](1, 2), sums.moments[m](2, 0), sums.moments[m](0, 1)), sums.scale);
    }
  }
}

TYPED_TEST(PairSumsOf, EveryKernelEqualsBruteForceWithEveryInstructionSet) {
  const std::int64_t all = supported_instruction_sets();
  for (const auto& [name, cloud] : clouds()) {
    const Drifted<TypeParam> d(cloud);
    for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {  // the lowest bit, one after the other
      restrict_instruction_sets(rest & -rest);
      SCOPED_TRACE(name + ", " + instruction_set_name());
      for (const Kernels& kernels : all_pairs_of_kernels()) expect_brute_force(d, kernels);
      expect_brute_force(d);
    }
    restrict_instruction_sets(all);
  }
}

// The same bits wherever a particle's sum is formed: in one loop over all, or alone.
TYPED_TEST(PairSumsOf, DoNotDependOnTheRange) {
  const Drifted<TypeParam> d(random_cloud(300, cloud_box, 1));
  const LocalId owned = d.near.order().owned();
  const auto same = [](const Vec4<TypeParam>& a, const Vec4<TypeParam>& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  };
  const FoundByFilters<TypeParam> filtered(d, {0, owned});
  for (LocalId i = 0; i < owned; ++i) {
    const FoundByFilters<TypeParam> alone(d, {i, i + 1});
    const auto k = static_cast<std::size_t>(i);
    EXPECT_TRUE(same(alone.curl[0], filtered.curl[k]) && same(alone.smoothing[0], filtered.smoothing[k]));
    for (const int m : {0, 1}) {
      EXPECT_TRUE(same(alone.friction[m][0], filtered.friction[m][k]));
      for (int r = 0; r < 4; ++r) EXPECT_TRUE(same(alone.fit[m][0].row[r], filtered.fit[m][k].row[r]));
    }
  }
  for (const Kernels& kernels : all_pairs_of_kernels()) {
    const FoundByConstraint<TypeParam> whole(d, kernels, {0, owned});
    for (LocalId i = 0; i < owned; ++i) {
      const FoundByConstraint<TypeParam> alone(d, kernels, {i, i + 1});
      const auto k = static_cast<std::size_t>(i);
      EXPECT_TRUE(same(alone.density[0], whole.density[k]) && same(alone.tensile_delta[0], whole.tensile_delta[k]));
    }
  }
}

// Two particles in one place have no direction to part in; the sums must stay numbers.
TYPED_TEST(PairSumsOf, CoincidentParticlesGiveFiniteSums) {
  Cloud cloud;
  for (const GlobalId id : {3, 4, 5}) cloud.add(id, Vec3(0.5, 0.6, 0.7), Vec3::Zero());
  cloud.add(9, Vec3(0.55, 0.6, 0.7), Vec3::Zero());
  const Distributed<TypeParam> d(cloud);
  const LocalId owned = d.near.order().owned();
  std::vector<Vec4<TypeParam>> sums(static_cast<std::size_t>(owned));
  std::vector<TypeParam> squares(sums.size());
  const Pairs<TypeParam> pairs{d.near.records(), d.near.list(), d.near.order().low_ghosts()};
  const Real tolerance = std::is_same_v<TypeParam, float> ? 1e-5 : 1e-12;
  for (const Kernels& kernels : all_pairs_of_kernels()) {
    constraint_loops<TypeParam>(kernels).density(pairs, {0, owned}, sums.data(), squares.data());
    // Of each that is 0.25 h away; Spiky's is (1 − ¼)².
    const Real slope = -kernels.gradient.gradient(Vec3(0.25, 0, 0), 1).x() / kernels.gradient.slope_factor(1);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      EXPECT_NEAR(sums[k].x, d.particles.id[k] == 9 ? 3 * slope : -slope, tolerance);
      EXPECT_NEAR(sums[k].y, 0, tolerance);
      EXPECT_TRUE(std::isfinite(squares[k]));
    }
  }
}

// As many as are tested at once, and more, of which it says so; the two that do are any of them.
TEST(Coincident, NoneIsMissedAndFewAreSuspected) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<Real> number(-1, 1);
  constexpr Real near = 1e-6;
  for (const std::string& name : instruction_set_names()) {
    ASSERT_TRUE(use_instruction_set(name));
    for (std::size_t count = 2; count < 70; ++count) {
      std::vector<Vec3> p(count);
      for (Vec3& one : p) one = {number(generator), number(generator), number(generator)};
      EXPECT_EQ(may_coincide(p, near * near), count > 64) << name << ' ' << count;
      const std::size_t one = generator() % count, other = (one + 1 + generator() % (count - 1)) % count;
      p[one] = p[other] + Vec3(0.5, -0.5, 0.6) * near;
      EXPECT_TRUE(may_coincide(p, near * near)) << name << ' ' << count << ' ' << one << ' ' << other;
    }
  }
  restrict_instruction_sets(-1);
}

}  // namespace
}  // namespace trevi::test

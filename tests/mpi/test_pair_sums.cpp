// The sums over neighbours against brute force in double precision, for every kernel, precision and instruction set
// that this machine can be made to use, with pairs that have drifted since the search. An error is measured against
// the sum of the absolute terms: 1e-12 of it in double precision, 1e-5 in single.
#include <Eigen/Geometry>
#include <map>

#include "base/simd.hpp"
#include "distributed.hpp"
#include "fluid/pair_sums.hpp"

namespace trevi::test {
namespace {

constexpr Tensile tensile{0.03, 4, 0.25};

/// What the loops see of a particle, in double precision: place in units of h as the records hold it.
struct Seen {
  Vec3 place, velocity;
  Real w;
};

Vec3 velocity_of(GlobalId id) { return Vec3(std::sin(0.1 * id), std::cos(0.7 * id), std::sin(1.3 * id)); }
Real scalar_of(GlobalId id) { return std::cos(0.37 * id); }
Vec3 drift_of(GlobalId id) { return 0.3 * radius * velocity_of(3 * id); }

/// Sums of one particle, and of the absolute values of their terms.
struct Sums {
  Vec3 spiky = Vec3::Zero(), delta = Vec3::Zero(), tensile_delta = Vec3::Zero(), curl = Vec3::Zero(),
       gradient = Vec3::Zero(), smoothing = Vec3::Zero();
  Real poly6 = 0, spiky_sum = 0, squares = 0, scale = 0.01;  // the scale is never nothing

  void add(const Seen& i, const Seen& j) {
    const Vec3 d = i.place - j.place;
    const Real u = d.norm(), t = 1 - u, q = 1 - u * u;
    if (u >= 1) return;
    const Vec3 along = t * t * d / u;
    const Real s_corr = -tensile.k * std::pow(std::pow(q / (1 - tensile.dq * tensile.dq), 3), tensile.n);
    spiky += along;
    poly6 += q * q * q;
    spiky_sum += t * t * t;
    squares += t * t * t * t;
    delta += (i.w + j.w) * along;
    tensile_delta += (i.w + j.w + s_corr) * along;
    curl += (j.velocity - i.velocity).cross(along);
    gradient += (j.w - i.w) * along;
    smoothing += (j.velocity - i.velocity) * q * q * q;
    scale += t * t + q * q * q;
  }
};

template <class T>
class PairSumsOf : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(PairSumsOf, Precisions);

template <class T>
void expect_near(const Quad<T>& found, const Vec3& expected, Real scale) {
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
    }
  }

  Seen seen(std::size_t k) const {
    const Packed<T>& r = this->near.records()[k];
    return {Vec3(r.x, r.y, r.z) / Packed<T>::units_per_h, vector_of(velocity[k]), static_cast<Real>(r.w)};
  }

  Sums brute_force(LocalId i) const {
    Sums sums;
    const auto self = static_cast<std::size_t>(this->near.order().low_ghosts() + i);
    for (const LocalId j : this->near.list()[i]) sums.add(seen(self), seen(static_cast<std::size_t>(j)));
    return sums;
  }

  std::vector<Quad<T>> velocity;
};

/// What the loops of the instruction set in use write for the owned particles [begin, end).
template <class T>
struct Found {
  std::vector<Quad<T>> density, spiky_density, delta, tensile_delta, curl, gradient, smoothing;
  std::vector<T> squares;

  Found(const Drifted<T>& d, Range range) {
    const auto n = static_cast<std::size_t>(range.size());
    for (auto* field : {&density, &spiky_density, &delta, &tensile_delta, &curl, &gradient, &smoothing})
      field->resize(n);
    squares.resize(n);
    const Pairs<T> pairs{d.near.records(), d.near.list(), d.near.order().low_ghosts()};
    const PairLoops<T> loops = pair_loops<T>();
    loops.density(pairs, range, density.data(), squares.data());
    loops.spiky_density(pairs, range, spiky_density.data(), squares.data());
    loops.delta(pairs, range, delta.data());
    loops.tensile_delta(pairs, range, tensile, tensile_delta.data());
    loops.curl(pairs, range, d.velocity.data(), curl.data());
    loops.gradient(pairs, range, gradient.data());
    loops.smoothing(pairs, range, d.velocity.data(), smoothing.data());
  }
};

template <class T>
void expect_brute_force(const Drifted<T>& d) {
  const LocalId owned = d.near.order().owned();
  const Found<T> found(d, {0, owned});
  for (LocalId i = 0; i < owned; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Sums sums = d.brute_force(i);
    expect_near(found.density[k], sums.spiky, sums.scale);
    expect_near(found.delta[k], sums.delta, 2 * sums.scale);
    expect_near(found.tensile_delta[k], sums.tensile_delta, 2 * sums.scale);
    expect_near(found.curl[k], sums.curl, 3 * sums.scale);
    expect_near(found.gradient[k], sums.gradient, 2 * sums.scale);
    expect_near(found.smoothing[k], sums.smoothing, 3 * sums.scale);
    expect_near(found.spiky_density[k], sums.spiky, sums.scale);
    const Quad<T> scalars{found.density[k].w, found.squares[k], found.spiky_density[k].w, 0};
    expect_near(scalars, Vec3(sums.poly6, sums.squares, sums.spiky_sum), sums.scale);
  }
}

TYPED_TEST(PairSumsOf, EveryKernelEqualsBruteForceWithEveryInstructionSet) {
  const std::int64_t all = supported_instruction_sets();
  for (const auto& [name, cloud] : clouds()) {
    const Drifted<TypeParam> d(cloud);
    for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {  // the lowest bit, one after the other
      restrict_instruction_sets(rest & -rest);
      SCOPED_TRACE(name + ", " + instruction_set_name());
      expect_brute_force(d);
    }
    restrict_instruction_sets(all);
  }
}

// The same bits wherever a particle's sum is formed: in one loop over all, or alone.
TYPED_TEST(PairSumsOf, DoNotDependOnTheRange) {
  const Drifted<TypeParam> d(random_cloud(300, cloud_box, 1));
  const LocalId owned = d.near.order().owned();
  const Found<TypeParam> whole(d, {0, owned});
  for (LocalId i = 0; i < owned; ++i) {
    const Found<TypeParam> alone(d, {i, i + 1});
    const auto k = static_cast<std::size_t>(i);
    const auto same = [](const Quad<TypeParam>& a, const Quad<TypeParam>& b) {
      return a.x == b.x && a.y == b.y && a.z == b.z;
    };
    EXPECT_TRUE(same(alone.density[0], whole.density[k]) && same(alone.tensile_delta[0], whole.tensile_delta[k]) &&
                same(alone.curl[0], whole.curl[k]) && same(alone.smoothing[0], whole.smoothing[k]));
  }
}

// Two particles in one place have no direction to part in; the sums must stay numbers.
TYPED_TEST(PairSumsOf, CoincidentParticlesGiveFiniteSums) {
  Cloud cloud;
  for (const GlobalId id : {3, 4, 5}) cloud.add(id, Vec3(0.5, 0.6, 0.7), Vec3::Zero());
  cloud.add(9, Vec3(0.55, 0.6, 0.7), Vec3::Zero());
  const Distributed<TypeParam> d(cloud);
  const LocalId owned = d.near.order().owned();
  std::vector<Quad<TypeParam>> sums(static_cast<std::size_t>(owned));
  std::vector<TypeParam> squares(sums.size());
  const Pairs<TypeParam> pairs{d.near.records(), d.near.list(), d.near.order().low_ghosts()};
  pair_loops<TypeParam>().density(pairs, {0, owned}, sums.data(), squares.data());
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const Real along = d.particles.id[k] == 9 ? 3 * 0.5625 : -0.5625;  // (1 − ¼)² for each that is 0.25 h away
    const Real tolerance = std::is_same_v<TypeParam, float> ? 1e-5 : 1e-12;
    EXPECT_NEAR(sums[k].x, along, tolerance);
    EXPECT_NEAR(sums[k].y, 0, tolerance);
    EXPECT_TRUE(std::isfinite(squares[k]));
  }
}

}  // namespace
}  // namespace trevi::test
